#include "tools/console/type_codes.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "orb/ccdr/format.hpp"

namespace canorb::console {
namespace {

TCKind kind_of_bits(unsigned bits) {
    if (bits <= 8) return TCKind::tk_octet;
    if (bits <= 16) return TCKind::tk_ushort;
    return bits <= 32 ? TCKind::tk_ulong : TCKind::tk_ulonglong;
}

TCKind basic_kind(Kind kind) {
    switch (kind) {
        case Kind::boolean:
            return TCKind::tk_boolean;
        case Kind::character:
            return TCKind::tk_char;
        case Kind::wide_character:
            return TCKind::tk_wchar;
        case Kind::int16:
            return TCKind::tk_short;
        case Kind::uint16:
            return TCKind::tk_ushort;
        case Kind::int32:
            return TCKind::tk_long;
        case Kind::uint32:
            return TCKind::tk_ulong;
        case Kind::int64:
            return TCKind::tk_longlong;
        case Kind::uint64:
            return TCKind::tk_ulonglong;
        case Kind::float32:
            return TCKind::tk_float;
        case Kind::float64:
            return TCKind::tk_double;
        case Kind::float128:
            return TCKind::tk_longdouble;
        case Kind::any:
            return TCKind::tk_any;
        case Kind::type_code:
            return TCKind::tk_TypeCode;
        default:
            return TCKind::tk_octet;
    }
}

/// doc/wire/ccdr.md, "Type codes".
class Writer {
  public:
    std::optional<TypeCode> run(const Type& type) {
        write(type);
        if (failed_) return std::nullopt;
        return TypeCode{std::move(to_)};
    }

  private:
    class Level {
      public:
        Level(Writer& writer, const Definition* definition) : writer_(writer) {
            writer_.around_.push_back(definition);
            if (writer_.around_.size() > ccdr::highest_type_code_levels) writer_.failed_ = true;
        }
        ~Level() { writer_.around_.pop_back(); }
        Level(const Level&) = delete;
        Level& operator=(const Level&) = delete;

      private:
        Writer& writer_;
    };

    void number(std::uint32_t value) { ccdr::append_unsigned(to_, value); }
    void kind(TCKind value) { ccdr::append_kind(to_, value); }
    void text(std::string_view value) {
        number(static_cast<std::uint32_t>(value.size() + 1));
        to_.append(value).push_back('\0');
    }
    void nameless(TCKind of, std::string_view id) {
        kind(of);
        text(id);
        text("");
    }
    template <typename T>
    void encoded(T value) {
        std::array<std::uint8_t, 8> buffer{};
        ccdr::Encoder out{buffer};
        ccdr::encode(out, value);
        to_.append(reinterpret_cast<const char*>(buffer.data()), out.size());
    }

    void write(const Type& type) {
        if (failed_) return;
        if (type.definition != nullptr) return write_named(type);
        const Level level{*this, nullptr};
        switch (type.kind) {
            case Kind::string:
            case Kind::wide_string:
                kind(type.kind == Kind::string ? TCKind::tk_string : TCKind::tk_wstring);
                return number(type.bound);
            case Kind::sequence:
            case Kind::array:
                kind(type.kind == Kind::sequence ? TCKind::tk_sequence : TCKind::tk_array);
                write(*type.element);
                return number(type.bound);
            case Kind::map:
                kind(TCKind::tk_sequence);
                write_entry(type);
                return number(type.bound);
            case Kind::fixed:
                kind(TCKind::tk_fixed);
                // Both are below 64, so a short has the same octet as an unsigned short.
                number(type.digits);
                return number(type.scale);
            case Kind::object:
                return nameless(TCKind::tk_objref, type.interface_id);
            default:
                kind(basic_kind(type.kind));
        }
    }

    void write_entry(const Type& map) {
        const Level level{*this, nullptr};
        nameless(TCKind::tk_struct, "");
        number(2);
        for (const auto& part : {map.key, map.element}) {
            text("");
            write(*part);
        }
    }

    void write_named(const Type& type) {
        const Definition& definition = *type.definition;
        const auto found = std::find(around_.begin(), around_.end(), &definition);
        if (found != around_.end()) {
            const auto levels = static_cast<std::uint32_t>(around_.end() - found);
            const Level level{*this, nullptr};
            kind(TCKind::tk_recursion);
            return number(levels);
        }
        const Level level{*this, &definition};
        switch (type.kind) {
            case Kind::enumeration:
                return write_enum(definition);
            case Kind::bitmask:
                return alias(definition, kind_of_bits(definition.bit_bound));
            case Kind::choice:
                return write_union(definition);
            case Kind::structure:
                nameless(TCKind::tk_struct, definition.repository_id);
                number(static_cast<std::uint32_t>(definition.members.size()));
                for (const Member& member : definition.members) {
                    text("");
                    write(member.type);
                }
                return;
            default:
                failed_ = true;
        }
    }

    void alias(const Definition& definition, TCKind of) {
        nameless(TCKind::tk_alias, definition.repository_id);
        const Level level{*this, nullptr};
        kind(of);
    }

    void write_enum(const Definition& definition) {
        std::uint32_t expected = 0;
        for (const Enumerator& each : definition.enumerators) {
            if (each.number != expected++) return alias(definition, TCKind::tk_ulong);
        }
        nameless(TCKind::tk_enum, definition.repository_id);
        number(expected);
        for (std::uint32_t i = 0; i < expected; ++i) text("");
    }

    void write_union(const Definition& definition) {
        nameless(TCKind::tk_union, definition.repository_id);
        write(definition.discriminator);
        std::size_t count = 0;
        std::int32_t default_index = -1;
        for (const Member& member : definition.members) {
            count += member.labels.size();
            if (member.is_default) default_index = static_cast<std::int32_t>(count++);
        }
        encoded(default_index);
        number(static_cast<std::uint32_t>(count));
        for (const Member& member : definition.members) {
            for (const std::int64_t label : member.labels) write_case(definition, label, member);
            if (member.is_default) write_case(definition, 0, member);
        }
    }

    void write_case(const Definition& definition, std::int64_t label, const Member& member) {
        switch (definition.discriminator.kind) {
            case Kind::int16:
            case Kind::int32:
                encoded(static_cast<std::int32_t>(label));
                break;
            case Kind::uint16:
            case Kind::uint32:
            case Kind::enumeration:
                number(static_cast<std::uint32_t>(label));
                break;
            case Kind::int64:
            case Kind::uint64:
                encoded(label);
                break;
            case Kind::wide_character:
                encoded(static_cast<char16_t>(label));
                break;
            default:
                encoded(static_cast<std::uint8_t>(label));
        }
        text("");
        write(member.type);
    }

    std::string to_;
    std::vector<const Definition*> around_;  ///< null: a type without a name
    bool failed_ = false;
};

std::optional<Type> read(ccdr::Decoder& in, const Model& model, unsigned depth);

std::optional<Type> bounded_text(std::string_view name, std::uint32_t bound, const Model& model) {
    auto type = model.find_type(name);
    if (bound != 0) {
        type->bound = bound;
        type->name += '<' + std::to_string(bound) + '>';
    }
    return type;
}

std::optional<Type> sequence(ccdr::Decoder& in, const Model& model, unsigned depth) {
    const auto element = read(in, model, depth + 1);
    if (!element) return std::nullopt;
    Type type{.kind = Kind::sequence, .bound = in.variable_unsigned(0xFFFFFFFF)};
    type.name =
        "sequence<" + element->name + (type.bound == 0 ? "" : ", " + std::to_string(type.bound));
    type.name += '>';
    type.element = std::make_shared<const Type>(*element);
    return type;
}

/// A type code of few levels that names no type.
std::optional<Type> read(ccdr::Decoder& in, const Model& model, unsigned depth) {
    if (depth > ccdr::highest_type_code_levels) return std::nullopt;
    const auto number = [&in] { return in.variable_unsigned(0xFFFFFFFF); };
    switch (static_cast<TCKind>(number())) {
        case TCKind::tk_short:
            return model.find_type("short");
        case TCKind::tk_long:
            return model.find_type("long");
        case TCKind::tk_ushort:
            return model.find_type("unsigned short");
        case TCKind::tk_ulong:
            return model.find_type("unsigned long");
        case TCKind::tk_float:
            return model.find_type("float");
        case TCKind::tk_double:
            return model.find_type("double");
        case TCKind::tk_boolean:
            return model.find_type("boolean");
        case TCKind::tk_char:
            return model.find_type("char");
        case TCKind::tk_octet:
            return model.find_type("octet");
        case TCKind::tk_any:
            return model.find_type("any");
        case TCKind::tk_TypeCode:
            return model.find_type("TypeCode");
        case TCKind::tk_longlong:
            return model.find_type("long long");
        case TCKind::tk_ulonglong:
            return model.find_type("unsigned long long");
        case TCKind::tk_longdouble:
            return model.find_type("long double");
        case TCKind::tk_wchar:
            return model.find_type("wchar");
        case TCKind::tk_string:
            return bounded_text("string", number(), model);
        case TCKind::tk_wstring:
            return bounded_text("wstring", number(), model);
        case TCKind::tk_objref: {
            Type type = *model.find_type("Object");
            type.interface_id = in.string();
            in.string();
            if (const Interface* known = model.find_interface(type.interface_id))
                type.name = known->name;
            return type;
        }
        case TCKind::tk_fixed: {
            Type type{.kind = Kind::fixed, .digits = number(), .scale = number()};
            type.name =
                "fixed<" + std::to_string(type.digits) + ", " + std::to_string(type.scale) + '>';
            return type;
        }
        case TCKind::tk_sequence:
            return sequence(in, model, depth);
        default:
            return std::nullopt;
    }
}

}  // namespace

std::optional<TypeCode> type_code(const Type& type) {
    return Writer{}.run(type);
}

std::optional<Type> find_type(const TypeCode& code, const Model& model) {
    if (const Type* known = model.find_type_by_id(code.id())) {
        const auto own = type_code(*known);
        if (own && own->equivalent(code)) return *known;
        return std::nullopt;
    }
    ccdr::Decoder in{code.octets()};
    auto type = read(in, model, 0);
    if (!in.finished()) return std::nullopt;
    return type;
}

}  // namespace canorb::console
