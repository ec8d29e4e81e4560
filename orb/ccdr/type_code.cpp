#include "orb/ccdr/type_code.hpp"

#include <algorithm>
#include <limits>

#include "orb/ccdr/format.hpp"
#include "orb/ccdr/type_code_reader.hpp"

namespace canorb::ccdr {
namespace {

constexpr std::string_view object_id = "IDL:omg.org/CORBA/Object:1.0";

/// Compares two type codes that need not be well-formed.
class Comparison {
  public:
    /// `loosely`: as TypeCode::accepts() says.
    explicit Comparison(bool loosely) : loosely_(loosely) {}

    bool same(Decoder& a, const Level* a_up, Decoder& b, const Level* b_up) const {
        Level a_level{a_up, a};
        Level b_level{b_up, b};
        const unsigned deepest = std::max(a_level.depth, b_level.depth);
        if (!a.ok() || !b.ok() || deepest > highest_type_code_levels) return false;
        a_level.kind = read_kind(a);
        if (a_level.kind == TCKind::tk_alias) {
            skip_id_and_name(a);
            return same(a, &a_level, b, b_up);
        }
        b_level.kind = read_kind(b);
        if (b_level.kind == TCKind::tk_alias) {
            skip_id_and_name(b);
            a = a_level.start;
            return same(a, a_up, b, &b_level);
        }
        return a_level.kind == b_level.kind && same_inside(a, a_level, b, b_level);
    }

  private:
    bool same_inside(Decoder& a, const Level& a_level, Decoder& b, const Level& b_level) const {
        switch (a_level.kind) {
            case TCKind::tk_recursion: {
                const Level* a_target = levels_up(a_level.up, read_unsigned(a));
                const Level* b_target = levels_up(b_level.up, read_unsigned(b));
                return a_target != nullptr && b_target != nullptr &&
                       place(a_target) == place(b_target);
            }
            case TCKind::tk_struct:
            case TCKind::tk_except:
                return same_ids(a, b) && same_members(a, a_level, b, b_level);
            case TCKind::tk_union:
                return same_ids(a, b) && same_unions(a, a_level, b, b_level);
            case TCKind::tk_sequence:
                return same(a, &a_level, b, &b_level) && same_bound(a, b);
            case TCKind::tk_array:
                return same(a, &a_level, b, &b_level) && read_unsigned(a) == read_unsigned(b);
            case TCKind::tk_string:
            case TCKind::tk_wstring:
                return same_bound(a, b);
            case TCKind::tk_fixed:
                // Digits and scale: one octet each.
                return read_unsigned(a) == read_unsigned(b) && read_unsigned(a) == read_unsigned(b);
            case TCKind::tk_objref:
                return same_ids(a, b);
            case TCKind::tk_enum: {
                if (!same_ids(a, b)) return false;
                const std::uint32_t count = read_unsigned(a);
                if (count != read_unsigned(b)) return false;
                for (std::uint32_t i = 0; i < count && a.ok() && b.ok(); ++i) {
                    a.string();
                    b.string();
                }
                return a.ok() && b.ok();
            }
            default:
                return true;
        }
    }

    /// Where a type code is among those around it, aliases left out.
    static unsigned place(const Level* level) {
        unsigned count = 0;
        for (; level != nullptr; level = level->up) {
            if (level->kind != TCKind::tk_alias) ++count;
        }
        return count;
    }

    bool same_bound(Decoder& a, Decoder& b) const {
        const std::uint32_t bound = read_unsigned(a);
        return bound == read_unsigned(b) || (loosely_ && bound == 0);
    }

    /// Two ids that are there; who sends none leaves it to what follows.
    bool same_ids(Decoder& a, Decoder& b) const {
        const std::string_view a_id = a.string();
        const std::string_view b_id = b.string();
        a.string();
        b.string();
        return a_id.empty() || b_id.empty() || a_id == b_id || (loosely_ && a_id == object_id);
    }

    bool same_members(Decoder& a, const Level& a_level, Decoder& b, const Level& b_level) const {
        const std::uint32_t count = read_unsigned(a);
        bool result = count == read_unsigned(b);
        for (std::uint32_t i = 0; i < count && result; ++i) {
            a.string();
            b.string();
            result = same(a, &a_level, b, &b_level);
        }
        return result;
    }

    bool same_unions(Decoder& a, const Level& a_level, Decoder& b, const Level& b_level) const {
        const Leaf discriminator = read_discriminator_type(a);
        if (!same(a, &a_level, b, &b_level)) return false;
        const auto highest = std::numeric_limits<std::int32_t>::max();
        const std::int32_t default_index = a.variable_signed(-1, highest);
        if (default_index != b.variable_signed(-1, highest)) return false;
        const std::uint32_t count = read_unsigned(a);
        bool result = count == read_unsigned(b);
        for (std::uint32_t i = 0; i < count && result; ++i) {
            const bool same_label =
                read_discriminator(a, discriminator) == read_discriminator(b, discriminator);
            a.string();
            b.string();
            result = (same_label || static_cast<std::int64_t>(i) == default_index) &&
                     same(a, &a_level, b, &b_level);
        }
        return result;
    }

    bool loosely_;
};

bool compare(const TypeCode& a, const TypeCode& b, bool loosely) {
    Decoder a_in{a.octets()};
    Decoder b_in{b.octets()};
    return Comparison{loosely}.same(a_in, nullptr, b_in, nullptr) && a_in.finished() &&
           b_in.finished();
}

}  // namespace

void append_unsigned(std::string& to, std::uint32_t value) {
    std::array<std::uint8_t, 5> buffer{};
    Encoder out{buffer};
    out.variable_unsigned(value);
    to.append(reinterpret_cast<const char*>(buffer.data()), out.size());
}

void append_kind(std::string& to, TCKind kind) {
    append_unsigned(to, static_cast<std::uint32_t>(kind));
}

void append_empty_name(std::string& to) {
    to.append("\x01\x00", 2);
}

void append_nameless_struct(std::string& to, std::uint32_t members) {
    append_empty_name(to);
    append_empty_name(to);
    append_unsigned(to, members);
}

}  // namespace canorb::ccdr

namespace canorb {

TCKind TypeCode::kind() const {
    ccdr::Decoder in{octets()};
    return ccdr::read_kind(in);
}

std::string_view TypeCode::id() const {
    ccdr::Decoder in{octets()};
    switch (ccdr::read_kind(in)) {
        case TCKind::tk_objref:
        case TCKind::tk_struct:
        case TCKind::tk_union:
        case TCKind::tk_enum:
        case TCKind::tk_alias:
        case TCKind::tk_except:
            return in.string();
        default:
            return {};
    }
}

bool TypeCode::equivalent(const TypeCode& other) const {
    return ccdr::compare(*this, other, false);
}

bool TypeCode::accepts(const TypeCode& other) const {
    return ccdr::compare(*this, other, true);
}

void encode(ccdr::Encoder& out, const TypeCode& value) {
    ccdr::Decoder check{value.octets()};
    ccdr::read_type_code(check);
    if (!check.finished()) return out.fail();
    out.octets(value.octets());
}

void decode(ccdr::Decoder& in, TypeCode& value) {
    const Bytes octets = ccdr::read_type_code(in);
    value = TypeCode{};
    if (in.ok()) {
        value = TypeCode{std::string{reinterpret_cast<const char*>(octets.data()), octets.size()}};
    }
}

}  // namespace canorb
