#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "idlc/emit/text.hpp"
#include "idlc/emit/type_pieces.hpp"

namespace canorb::idlc::emit {

namespace {

using model::TypeKind;

/// The TCKind numbers of doc/wire/ccdr.md, "Type codes".
enum class Kind : std::uint32_t {
    int16 = 2,
    int32 = 3,
    uint16 = 4,
    uint32 = 5,
    float32 = 6,
    float64 = 7,
    boolean = 8,
    character = 9,
    octet = 10,
    any = 11,
    type_code = 12,
    reference = 14,
    structure = 15,
    choice = 16,
    enumeration = 17,
    string = 18,
    sequence = 19,
    array = 20,
    alias = 21,
    exception = 22,
    int64 = 23,
    uint64 = 24,
    float128 = 25,
    wide_character = 26,
    wide_string = 27,
    fixed = 28,
};

constexpr std::size_t most_levels = 16;

bool is_contiguous(const model::Enum& body) {
    for (std::size_t i = 0; i < body.enumerators.size(); ++i) {
        if (body.enumerators[i].number != i) return false;
    }
    return true;
}

Kind basic_kind(TypeKind kind) {
    switch (kind) {
        case TypeKind::boolean:
            return Kind::boolean;
        case TypeKind::character:
            return Kind::character;
        case TypeKind::wide_character:
            return Kind::wide_character;
        case TypeKind::int16:
            return Kind::int16;
        case TypeKind::uint16:
            return Kind::uint16;
        case TypeKind::int32:
            return Kind::int32;
        case TypeKind::uint32:
            return Kind::uint32;
        case TypeKind::int64:
            return Kind::int64;
        case TypeKind::uint64:
            return Kind::uint64;
        case TypeKind::float32:
            return Kind::float32;
        case TypeKind::float64:
            return Kind::float64;
        case TypeKind::float128:
            return Kind::float128;
        case TypeKind::any:
            return Kind::any;
        case TypeKind::type_code:
            return Kind::type_code;
        default:
            return Kind::octet;
    }
}

/// The octets of values in CCDR.
class Octets {
  public:
    void octet(std::uint64_t value) { octets_ += static_cast<char>(value & 0xFF); }
    void big_endian(std::uint64_t value, unsigned octets) {
        for (unsigned i = octets; i-- > 0;) octet(value >> (8 * i));
    }
    void variable_unsigned(std::uint32_t value) {
        unsigned form = 1;
        while (form < 5 && value >> (7 * form) != 0) ++form;
        variable(value, form);
    }
    void variable_signed(std::int32_t value) {
        unsigned form = 1;
        while (form < 5 && (value >> (7 * form - 1)) != (value < 0 ? -1 : 0)) ++form;
        const std::uint32_t mask = form < 5 ? (std::uint32_t{1} << (7 * form)) - 1 : ~0U;
        variable(static_cast<std::uint32_t>(value) & mask, form);
    }
    void text(std::string_view value) {
        variable_unsigned(static_cast<std::uint32_t>(value.size() + 1));
        octets_ += value;
        octet(0);
    }
    std::string take() { return std::move(octets_); }

  private:
    void variable(std::uint32_t bits, unsigned form) {
        // One leading 1 for each octet that follows, then a 0.
        constexpr std::uint8_t leading[] = {0, 0x00, 0x80, 0xC0, 0xE0, 0xF0};
        if (form == 5) {
            octet(leading[form]);
            return big_endian(bits, 4);
        }
        big_endian(bits | std::uint32_t{leading[form]} << (8 * (form - 1)), form);
    }

    std::string octets_;
};

/// Writes one type code; the type may turn out to have none.
class TypeCodeWriter {
  public:
    std::optional<std::string> run(const model::Definition& definition) {
        write(definition);
        if (failed_) return std::nullopt;
        return out_.take();
    }

  private:
    /// One level of types within types.
    class Level {
      public:
        Level(TypeCodeWriter& writer, const model::Definition* definition) : writer_(writer) {
            writer_.around_.push_back(definition);
            if (writer_.around_.size() > most_levels) writer_.failed_ = true;
        }
        ~Level() { writer_.around_.pop_back(); }
        Level(const Level&) = delete;
        Level& operator=(const Level&) = delete;

      private:
        TypeCodeWriter& writer_;
    };

    void kind(Kind kind) { out_.variable_unsigned(static_cast<std::uint32_t>(kind)); }
    void nameless(Kind of, const std::string& id) {
        kind(of);
        out_.text(id);
        out_.text("");
    }

    void write(const model::Type& type) {
        if (failed_) return;
        const model::Type& known = model::resolved(type);
        if (known.kind == TypeKind::named) return write(*known.definition);
        const Level level{*this, nullptr};
        switch (known.kind) {
            case TypeKind::string:
            case TypeKind::wide_string:
                kind(known.kind == TypeKind::string ? Kind::string : Kind::wide_string);
                return out_.variable_unsigned(known.bound);
            case TypeKind::sequence:
            case TypeKind::array:
                kind(known.kind == TypeKind::sequence ? Kind::sequence : Kind::array);
                write(*known.element);
                return out_.variable_unsigned(known.bound);
            case TypeKind::map:
                kind(Kind::sequence);
                write_entry(known);
                return out_.variable_unsigned(known.bound);
            case TypeKind::fixed:
                kind(Kind::fixed);
                out_.variable_unsigned(known.digits);
                return out_.variable_signed(known.scale);
            case TypeKind::object:
                return nameless(Kind::reference, "IDL:omg.org/CORBA/Object:1.0");
            default:
                kind(basic_kind(known.kind));
        }
    }

    void write_entry(const model::Type& map) {
        const Level level{*this, nullptr};
        nameless(Kind::structure, "");
        out_.variable_unsigned(2);
        for (const auto& part : {map.key, map.element}) {
            out_.text("");
            write(*part);
        }
    }

    void write(const model::Definition& definition) {
        const auto found = std::find(around_.begin(), around_.end(), &definition);
        if (found != around_.end()) {
            const auto levels = static_cast<std::uint32_t>(around_.end() - found);
            const Level level{*this, nullptr};
            constexpr std::uint32_t recursion = 0xFFFFFFFF;
            out_.variable_unsigned(recursion);
            return out_.variable_unsigned(levels);
        }
        const Level level{*this, &definition};
        const std::string& id = definition.repository_id;
        if (const auto* body = std::get_if<model::Enum>(&definition.body)) {
            write(*body, id);
        } else if (const auto* mask = std::get_if<model::Bitmask>(&definition.body)) {
            const Kind number = mask->bit_bound <= 8    ? Kind::octet
                                : mask->bit_bound <= 16 ? Kind::uint16
                                : mask->bit_bound <= 32 ? Kind::uint32
                                                        : Kind::uint64;
            alias(id, number);
        } else if (const auto* choice = std::get_if<model::Union>(&definition.body)) {
            write(*choice, id);
        } else if (std::holds_alternative<model::Interface>(definition.body)) {
            nameless(Kind::reference, id);
        } else {
            const bool is_struct = std::holds_alternative<model::Struct>(definition.body);
            nameless(is_struct ? Kind::structure : Kind::exception, id);
            const std::vector<const model::Member*> members = all_members(definition);
            out_.variable_unsigned(static_cast<std::uint32_t>(members.size()));
            for (const model::Member* member : members) {
                out_.text("");
                write(member->type);
            }
        }
    }

    void alias(const std::string& id, Kind number) {
        nameless(Kind::alias, id);
        const Level level{*this, nullptr};
        kind(number);
    }

    void write(const model::Enum& body, const std::string& id) {
        if (!is_contiguous(body)) return alias(id, Kind::uint32);
        nameless(Kind::enumeration, id);
        out_.variable_unsigned(static_cast<std::uint32_t>(body.enumerators.size()));
        for (std::size_t i = 0; i < body.enumerators.size(); ++i) out_.text("");
    }

    void write(const model::Union& body, const std::string& id) {
        nameless(Kind::choice, id);
        write(body.discriminator);
        std::size_t count = 0;
        std::int32_t default_index = -1;
        for (const model::UnionCase& one : body.cases) {
            count += one.labels.size();
            if (one.is_default) default_index = static_cast<std::int32_t>(count++);
        }
        out_.variable_signed(default_index);
        out_.variable_unsigned(static_cast<std::uint32_t>(count));
        const model::Type& discriminator = model::resolved(body.discriminator);
        for (const model::UnionCase& one : body.cases) {
            for (const model::Value& value : one.labels) {
                write_case(discriminator, number_of(value), one.member.type);
            }
            if (one.is_default) write_case(discriminator, 0, one.member.type);
        }
    }

    void write_case(const model::Type& discriminator, std::uint64_t label,
                    const model::Type& member) {
        write_label(discriminator.kind, label);
        out_.text("");
        write(member);
    }

    static std::uint64_t number_of(const model::Value& value) {
        return std::visit(
            [](const auto& one) -> std::uint64_t {
                using T = std::decay_t<decltype(one)>;
                if constexpr (std::is_same_v<T, model::EnumeratorValue>) {
                    const auto& body = std::get<model::Enum>(one.enumeration->body);
                    return body.enumerators[one.index].number;
                } else if constexpr (std::is_integral_v<T>) {
                    return static_cast<std::uint64_t>(one);
                } else {
                    return 0;
                }
            },
            value);
    }

    void write_label(TypeKind discriminator, std::uint64_t label) {
        switch (discriminator) {
            case TypeKind::int16:
            case TypeKind::int32:
                return out_.variable_signed(static_cast<std::int32_t>(label));
            case TypeKind::uint16:
            case TypeKind::uint32:
            case TypeKind::named:
                return out_.variable_unsigned(static_cast<std::uint32_t>(label));
            case TypeKind::int64:
            case TypeKind::uint64:
                return out_.big_endian(label, 8);
            case TypeKind::wide_character:
                return out_.big_endian(label, 2);
            default:
                return out_.octet(label);
        }
    }

    Octets out_;
    std::vector<const model::Definition*> around_;  ///< null: a sequence, array, basic type...
    bool failed_ = false;
};

/// As string literals, each in a line of its own.
std::string literals(std::string_view octets) {
    constexpr std::size_t most_columns = line_width - 16;  // indentation, braces, quotes
    std::vector<std::string> lines{""};
    for (const char c : octets) {
        const auto octet = static_cast<unsigned char>(c);
        std::string written{c};
        if (c == '"' || c == '\\') {
            written = std::string{'\\', c};
        } else if (c < ' ' || c > '~') {
            // Three octal digits: a digit that follows is not taken for one of them.
            written = {'\\', static_cast<char>('0' + (octet >> 6)),
                       static_cast<char>('0' + ((octet >> 3) & 7)),
                       static_cast<char>('0' + (octet & 7))};
        }
        if (lines.back().size() + written.size() > most_columns) lines.emplace_back();
        lines.back() += written;
    }
    return '"' + join(lines, "\"\n        \"") + '"';
}

bool has_type_code(const model::Definition& definition) {
    return std::holds_alternative<model::Enum>(definition.body) ||
           std::holds_alternative<model::Bitmask>(definition.body) ||
           std::holds_alternative<model::Struct>(definition.body) ||
           std::holds_alternative<model::Union>(definition.body) ||
           std::holds_alternative<model::Exception>(definition.body) ||
           std::holds_alternative<model::Interface>(definition.body);
}

}  // namespace

std::string type_code_function(const model::Definition& definition, const Names& names) {
    if (!has_type_code(definition) || !is_sendable(definition)) return {};
    const std::optional<std::string> octets = TypeCodeWriter{}.run(definition);
    if (!octets) return {};
    const std::string name = names.spell(definition, around_codec(definition));
    return "constexpr std::string_view type_code_of(const " + name + "*) {\n    return {" +
           literals(*octets) + ", " + std::to_string(octets->size()) + "};\n}\n";
}

}  // namespace canorb::idlc::emit
