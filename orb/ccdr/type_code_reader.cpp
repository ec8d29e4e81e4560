#include "orb/ccdr/type_code_reader.hpp"

#include <limits>
#include <span>

#include "orb/ccdr/format.hpp"
#include "orb/ccdr/nesting.hpp"

namespace canorb::ccdr {

std::uint32_t read_unsigned(Decoder& in) {
    return in.variable_unsigned(std::numeric_limits<std::uint32_t>::max());
}

TCKind read_kind(Decoder& in) {
    return static_cast<TCKind>(read_unsigned(in));
}

void skip_id_and_name(Decoder& in) {
    in.string();
    in.string();
}

const Level* levels_up(const Level* inner, std::uint32_t levels) {
    if (levels == 0) return nullptr;
    for (; inner != nullptr && levels > 1; --levels) inner = inner->up;
    return inner;
}

bool is_leaf(TCKind kind) {
    switch (kind) {
        case TCKind::tk_struct:
        case TCKind::tk_union:
        case TCKind::tk_sequence:
        case TCKind::tk_array:
        case TCKind::tk_alias:
        case TCKind::tk_except:
        case TCKind::tk_recursion:
            return false;
        default:
            return true;
    }
}

Leaf read_leaf(Decoder& in, TCKind kind) {
    switch (kind) {
        case TCKind::tk_string:
        case TCKind::tk_wstring:
            return {kind, read_unsigned(in)};
        case TCKind::tk_fixed: {
            const std::uint32_t digits = in.variable_unsigned(31);
            if (digits == 0) in.fail();
            in.variable_signed(0, static_cast<std::int32_t>(digits));
            return {kind, digits};
        }
        case TCKind::tk_objref:
            skip_id_and_name(in);
            return {kind};
        case TCKind::tk_enum: {
            skip_id_and_name(in);
            const std::size_t count = in.count(fewest_octets<std::string>);
            if (count == 0) in.fail();
            for (std::size_t i = 0; i < count && in.ok(); ++i) in.string();
            return {kind, static_cast<std::uint32_t>(count)};
        }
        case TCKind::tk_null:
        case TCKind::tk_void:
        case TCKind::tk_short:
        case TCKind::tk_long:
        case TCKind::tk_ushort:
        case TCKind::tk_ulong:
        case TCKind::tk_float:
        case TCKind::tk_double:
        case TCKind::tk_boolean:
        case TCKind::tk_char:
        case TCKind::tk_octet:
        case TCKind::tk_any:
        case TCKind::tk_TypeCode:
        case TCKind::tk_longlong:
        case TCKind::tk_ulonglong:
        case TCKind::tk_longdouble:
        case TCKind::tk_wchar:
            return {kind};
        default:
            in.fail();
            return {};
    }
}

namespace {

template <typename Integer>
std::uint64_t read_integer(Decoder& in) {
    Integer value{};
    decode(in, value);
    return static_cast<std::uint64_t>(value);
}

}  // namespace

std::uint64_t read_discriminator(Decoder& in, const Leaf& leaf) {
    switch (leaf.kind) {
        case TCKind::tk_short:
            return read_integer<std::int16_t>(in);
        case TCKind::tk_long:
            return read_integer<std::int32_t>(in);
        case TCKind::tk_ushort:
            return read_integer<std::uint16_t>(in);
        case TCKind::tk_ulong:
            return read_integer<std::uint32_t>(in);
        case TCKind::tk_longlong:
        case TCKind::tk_ulonglong:
            return in.fixed64();
        case TCKind::tk_boolean:
            return read_integer<bool>(in);
        case TCKind::tk_char:
        case TCKind::tk_octet:
            return in.octet();
        case TCKind::tk_wchar:
            return read_integer<char16_t>(in);
        case TCKind::tk_enum:
            return in.variable_unsigned(leaf.size - 1);
        default:
            in.fail();
            return 0;
    }
}

Leaf read_discriminator_type(Decoder in) {
    TCKind kind = read_kind(in);
    for (; kind == TCKind::tk_alias; kind = read_kind(in)) skip_id_and_name(in);
    return is_leaf(kind) ? read_leaf(in, kind) : Leaf{};
}

namespace {

/// How many names and types in type codes read_value() reads at most, each as often as it is read:
/// 128 for each octet of the longest message. That is a fraction of a
/// second's work.
constexpr std::size_t highest_work = std::size_t{1} << 23;

void check_type_code(Decoder& in, const Level* up);

void check_recursion(Decoder& in, const Level* up) {
    const Level* target = levels_up(up, read_unsigned(in));
    if (target == nullptr ||
        (target->kind != TCKind::tk_struct && target->kind != TCKind::tk_union)) {
        return in.fail();
    }
    // A value within itself can end only where a sequence can be empty.
    for (const Level* level = up; level != target; level = level->up) {
        if (level->kind == TCKind::tk_sequence) return;
    }
    in.fail();
}

void check_struct(Decoder& in, const Level& level) {
    skip_id_and_name(in);
    constexpr std::size_t fewest_of_member = fewest_octets<std::string> + 1;
    const std::size_t members = in.count(fewest_of_member);
    for (std::size_t i = 0; i < members && in.ok(); ++i) {
        in.string();
        check_type_code(in, &level);
    }
}

void check_union(Decoder& in, const Level& level) {
    skip_id_and_name(in);
    const Decoder discriminator = in;
    check_type_code(in, &level);
    if (!in.ok()) return;
    const Leaf leaf = read_discriminator_type(discriminator);
    const std::int32_t default_index =
        in.variable_signed(-1, std::numeric_limits<std::int32_t>::max());
    constexpr std::size_t fewest_of_case = 1 + fewest_octets<std::string> + 1;
    const std::size_t cases = in.count(fewest_of_case);
    if (cases == 0 || default_index >= static_cast<std::int64_t>(cases)) in.fail();
    for (std::size_t i = 0; i < cases && in.ok(); ++i) {
        read_discriminator(in, leaf);
        in.string();
        check_type_code(in, &level);
    }
}

/// Reads a type code that stands in the one of `up`.
void check_type_code(Decoder& in, const Level* up) {
    Level level{up, in};
    if (level.depth > highest_type_code_levels) return in.fail();
    level.kind = read_kind(in);
    switch (level.kind) {
        case TCKind::tk_recursion:
            return check_recursion(in, up);
        case TCKind::tk_struct:
            return check_struct(in, level);
        case TCKind::tk_union:
            return check_union(in, level);
        case TCKind::tk_sequence:
            check_type_code(in, &level);
            read_unsigned(in);
            return;
        case TCKind::tk_array:
            check_type_code(in, &level);
            if (read_unsigned(in) == 0) in.fail();
            return;
        case TCKind::tk_alias:
            skip_id_and_name(in);
            return check_type_code(in, &level);
        case TCKind::tk_except:
            if (up != nullptr) return in.fail();
            return check_struct(in, level);
        case TCKind::tk_null:
        case TCKind::tk_void:
            if (up != nullptr) in.fail();
            return;
        default:
            read_leaf(in, level.kind);
    }
}

/// Reads values by type codes that were checked.
class ValueReader {
  public:
    explicit ValueReader(Decoder& in) : in_(in) {}

    void read(Decoder& code, const Level* up) {
        Level level{up, code};
        level.kind = read_kind(code);
        if (!spend(1)) return;
        switch (level.kind) {
            case TCKind::tk_recursion:
                return read_recursion(code, up);
            case TCKind::tk_struct:
            case TCKind::tk_except:
                return read_struct(code, level);
            case TCKind::tk_union:
                return read_union(code, level);
            case TCKind::tk_sequence:
            case TCKind::tk_array:
                return read_elements(code, level);
            case TCKind::tk_alias:
                skip_id_and_name(code);
                return read(code, &level);
            default: {
                const Leaf leaf = read_leaf(code, level.kind);
                if (leaf.kind != TCKind::tk_enum || spend(leaf.size)) read_leaf_value(leaf);
            }
        }
    }

  private:
    /// False: it was too much.
    bool spend(std::size_t work) {
        if (work > work_left_) in_.fail();
        work_left_ -= std::min(work, work_left_);
        return in_.ok();
    }

    void skip_type_code(Decoder& code, const Level& level) {
        const std::size_t before = code.remaining();
        check_type_code(code, &level);
        constexpr std::size_t fewest_of_name = fewest_octets<std::string>;
        spend((before - code.remaining()) / fewest_of_name);
    }

    void read_struct(Decoder& code, const Level& level) {
        skip_id_and_name(code);
        const std::uint32_t members = read_unsigned(code);
        for (std::uint32_t i = 0; i < members && spend(1); ++i) {
            code.string();
            read(code, &level);
        }
    }

    void read_recursion(Decoder& code, const Level* up) {
        const Nesting nesting{in_};
        if (!nesting) return;
        const Level* target = levels_up(up, read_unsigned(code));
        Decoder again = target->start;
        read(again, target->up);
    }

    void read_elements(Decoder& code, const Level& level) {
        Decoder element = code;
        skip_type_code(code, level);
        const std::uint32_t size = read_unsigned(code);
        const bool is_sequence = level.kind == TCKind::tk_sequence;
        std::uint32_t count = size;
        if (is_sequence) {
            count =
                in_.variable_unsigned(size == 0 ? std::numeric_limits<std::uint32_t>::max() : size);
        }
        Decoder behind_kind = element;
        const TCKind kind = read_kind(behind_kind);
        if (is_leaf(kind)) {
            const Leaf leaf = read_leaf(behind_kind, kind);
            for (std::uint32_t i = 0; i < count && in_.ok(); ++i) read_leaf_value(leaf);
            return;
        }
        for (std::uint32_t i = 0; i < count && in_.ok(); ++i) {
            const std::size_t before = in_.remaining();
            Decoder again = element;
            read(again, &level);
            if (in_.remaining() == before) {
                if (is_sequence && count > highest_octetless) in_.fail();
                return;
            }
        }
    }

    void read_union(Decoder& code, const Level& level) {
        skip_id_and_name(code);
        const Leaf discriminator = read_discriminator_type(code);
        skip_type_code(code, level);
        const std::int32_t default_index =
            code.variable_signed(-1, std::numeric_limits<std::int32_t>::max());
        const std::uint32_t cases = read_unsigned(code);
        const std::uint64_t value = read_discriminator(in_, discriminator);
        bool found = false;
        Decoder default_case = code;
        for (std::uint32_t i = 0; i < cases && spend(1); ++i) {
            const bool is_default = static_cast<std::int64_t>(i) == default_index;
            const std::uint64_t label = read_discriminator(code, discriminator);
            code.string();
            if (is_default) default_case = code;
            if (!found && !is_default && label == value) {
                found = true;
                read(code, &level);
            } else {
                skip_type_code(code, level);
            }
        }
        if (!found && default_index >= 0 && in_.ok()) read(default_case, &level);
    }

    void read_leaf_value(const Leaf& leaf) {
        switch (leaf.kind) {
            case TCKind::tk_null:
            case TCKind::tk_void:
                return;
            case TCKind::tk_float:
                in_.fixed32();
                return;
            case TCKind::tk_double:
                in_.fixed64();
                return;
            case TCKind::tk_longdouble:
                in_.octets(16);
                return;
            case TCKind::tk_string:
                if (in_.string().size() > highest_count(leaf.size)) in_.fail();
                return;
            case TCKind::tk_wstring:
                in_.wide_string(highest_count(leaf.size));
                return;
            case TCKind::tk_fixed: {
                std::array<std::uint8_t, 31> digits{};
                fixed_digits::decode(in_, std::span{digits}.first(leaf.size));
                return;
            }
            case TCKind::tk_objref:
                return read_reference();
            case TCKind::tk_any:
                return read_any();
            case TCKind::tk_TypeCode:
                read_type_code(in_);
                return;
            default:
                read_discriminator(in_, leaf);
        }
    }

    /// As far as it is needed to know where it ends; doc/wire/giop.md, "Object references".
    void read_reference() {
        in_.string();
        constexpr std::uint8_t nil_profile = 0xFF;
        const std::uint8_t profile = in_.octet();
        if (profile == nil_profile) return;
        const std::uint8_t reference_type = in_.octet();
        if (profile != 0 || reference_type > 1) return in_.fail();
        constexpr std::size_t object_octets = 3;
        constexpr std::size_t group_octets = 1;
        in_.octets(reference_type == 0 ? object_octets : group_octets);
    }

    void read_any() {
        const Nesting nesting{in_};
        if (!nesting) return;
        Decoder code{read_type_code(in_)};
        if (in_.ok()) read(code, nullptr);
    }

    Decoder& in_;
    std::size_t work_left_ = highest_work;
};

}  // namespace

Bytes read_type_code(Decoder& in) {
    const Bytes all = in.rest();
    check_type_code(in, nullptr);
    return in.ok() ? all.first(all.size() - in.remaining()) : Bytes{};
}

Bytes read_value(Decoder& in, Bytes type_code) {
    const Bytes all = in.rest();
    Decoder code{type_code};
    ValueReader{in}.read(code, nullptr);
    return in.ok() ? all.first(all.size() - in.remaining()) : Bytes{};
}

}  // namespace canorb::ccdr
