#include "tools/console/arguments.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <set>

#include "orb/ccdr/format.hpp"
#include "orb/ccdr/nesting.hpp"
#include "orb/core/reference.hpp"
#include "orb/giop/message.hpp"
#include "tools/console/integers.hpp"
#include "tools/console/literal.hpp"
#include "tools/console/type_codes.hpp"
#include "tools/console/utf16.hpp"

namespace canorb::console {
namespace {

using Form = Literal::Form;

/// Types whose values are JSON, as an argument too.
bool is_constructed(Kind kind) {
    switch (kind) {
        case Kind::sequence:
        case Kind::map:
        case Kind::array:
        case Kind::structure:
        case Kind::choice:
        case Kind::any:
            return true;
        default:
            return false;
    }
}

std::string quoted(std::string_view text) {
    constexpr std::size_t longest = 60;
    if (text.size() <= longest) return '\'' + std::string{text} + '\'';
    return '\'' + std::string{text.substr(0, longest)} + "...'";
}

/// The value as the user wrote it, for a message: in quotes but for numbers.
std::string shown(const Literal& literal) {
    const bool is_number = literal.text.find_first_not_of("0123456789+-.e") == std::string::npos &&
                           literal.text.find_first_of("0123456789") != std::string::npos;
    switch (literal.form) {
        case Form::bare:
            return is_number ? literal.text : quoted(literal.text);
        case Form::null:
            return "null";
        case Form::array:
            return "an array";
        case Form::object:
            return "an object";
        case Form::boolean:
        case Form::number:
            return literal.text;
        default:
            return quoted(literal.text);
    }
}

/// Digits with at most one point, as a number of so many digits; none is lost.
std::optional<std::string> fixed_digits_of(std::string_view text, const Type& type) {
    std::size_t point = std::min(text.find('.'), text.size());
    std::string whole{text.substr(0, point)};
    std::string fraction{point < text.size() ? text.substr(point + 1) : ""};
    if (whole.empty() && fraction.empty()) return std::nullopt;
    whole.erase(0, std::min(whole.find_first_not_of('0'), whole.size()));
    while (fraction.size() > type.scale && fraction.back() == '0') fraction.pop_back();
    if (whole.size() > type.digits - type.scale || fraction.size() > type.scale)
        return std::nullopt;
    std::string digits = whole + fraction;
    if (digits.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    digits.insert(0, type.digits - type.scale - whole.size(), '0');
    digits.append(type.scale - fraction.size(), '0');
    return digits;
}

/// Writes one argument; what is wrong with it is said once.
class ArgumentWriter {
  public:
    ArgumentWriter(ccdr::Encoder& out, const Model& model, std::string path)
        : out_(out), model_(model), path_(std::move(path)) {}

    /// "speed: unsigned short): 70000 is not 0 to 65535"; empty: all is well.
    const std::string& error() const { return error_; }

    void write(const Type& type, const Literal& value) {
        if (!error_.empty()) return;
        switch (type.kind) {
            case Kind::boolean:
                return write_boolean(type, value);
            case Kind::character:
                return write_character(type, value);
            case Kind::wide_character:
                return write_wide_character(type, value);
            case Kind::float32:
                return write_floating<float>(type, value);
            case Kind::float64:
                return write_floating<double>(type, value);
            case Kind::float128:
                return write_floating<long double>(type, value);
            case Kind::string:
                return write_string(type, value);
            case Kind::wide_string:
                return write_wide_string(type, value);
            case Kind::fixed:
                return write_fixed(type, value);
            case Kind::any:
                return write_any(type, value);
            case Kind::type_code:
                return write_type_code(type, value);
            case Kind::object:
                return write_reference(type, value);
            case Kind::enumeration:
                return write_enumerator(type, value);
            case Kind::bitmask:
                return write_flags(type, value);
            case Kind::structure:
                return write_struct(type, value);
            case Kind::choice:
                return write_union(type, value);
            case Kind::sequence:
            case Kind::array:
                return write_elements(type, value);
            case Kind::map:
                return write_map(type, value);
            case Kind::native:
                return fail(type, "a native type is never on the bus");
            default:
                return write_integer(type, value);
        }
    }

  private:
    void fail(const Type& type, const std::string& problem) {
        if (error_.empty()) error_ = path_ + ": " + type.name + "): " + problem;
    }
    void refuse(const Type& type, const Literal& value, const std::string& accepted) {
        fail(type, shown(value) + " is not " + accepted);
    }

    /// A value within the one that is being written.
    template <typename Write>
    void inside(const std::string& step, Write write) {
        const std::size_t size = path_.size();
        path_ += step;
        write();
        path_.resize(size);
    }

    static bool is_text(const Literal& value) {
        return value.form == Form::bare || value.form == Form::string;
    }
    static bool is_number(const Literal& value) {
        return value.form == Form::bare || value.form == Form::number;
    }

    void write_boolean(const Type& type, const Literal& value) {
        const bool may_be = value.form == Form::bare || value.form == Form::boolean;
        const bool is_true = value.text == "true" || value.text == "TRUE" || value.text == "1";
        const bool is_false = value.text == "false" || value.text == "FALSE" || value.text == "0";
        if (!may_be || (!is_true && !is_false)) return refuse(type, value, "true or false");
        encode(out_, is_true);
    }

    void write_integer(const Type& type, const Literal& value) {
        const IntegerRange range = integer_range(type.kind);
        const auto bits =
            is_number(value) ? parse_integer(value.text, range) : std::optional<std::uint64_t>{};
        if (!bits) return refuse(type, value, range.text());
        encode_integer(out_, type.kind, *bits);
    }

    template <typename Float>
    void write_floating(const Type& type, const Literal& value) {
        const std::string& text = value.text;
        Float number{};
        const char* const end = text.data() + text.size();
        const auto [rest, error] = std::from_chars(text.data(), end, number);
        const bool may_be = is_number(value) || value.form == Form::string;  // "nan", "inf"
        if (may_be && rest == end && error == std::errc::result_out_of_range)
            return fail(type, text + " is too large, or too close to 0, for this type");
        if (!may_be || rest != end || error != std::errc{})
            return refuse(type, value, "a number such as -1.5e3, or inf, -inf or nan");
        encode(out_, number);
    }

    void write_fixed(const Type& type, const Literal& value) {
        const bool may_be = is_number(value) || value.form == Form::string;
        std::string_view text = value.text;
        const bool is_negative = text.starts_with('-');
        if (is_negative || text.starts_with('+')) text.remove_prefix(1);
        const auto digits = may_be ? fixed_digits_of(text, type) : std::nullopt;
        if (!digits) {
            return refuse(type, value,
                          "a number of at most " + std::to_string(type.digits - type.scale) +
                              " digits before and " + std::to_string(type.scale) +
                              " behind the point");
        }
        std::vector<std::uint8_t> numbers;
        for (const char digit : *digits) numbers.push_back(static_cast<std::uint8_t>(digit - '0'));
        const bool is_zero = digits->find_first_not_of('0') == std::string::npos;
        fixed_digits::encode(out_, numbers, is_negative && !is_zero);
    }

    void write_character(const Type& type, const Literal& value) {
        const std::string& text = value.text;
        unsigned code = 0;
        constexpr std::string_view escape = "\\x";
        constexpr std::size_t escaped_size = 4;
        const bool is_escaped = text.size() == escaped_size && text.starts_with(escape);
        if (is_text(value) && is_escaped) {
            const char* const end = text.data() + text.size();
            const auto [rest, error] = std::from_chars(text.data() + escape.size(), end, code, 16);
            if (error == std::errc{} && rest == end)
                return encode(out_, static_cast<std::uint8_t>(code));
        }
        if (!is_text(value) || text.size() != 1)
            return refuse(type, value, "one character of ASCII, or one octet as \\xE4");
        encode(out_, text.front());
    }

    void write_wide_character(const Type& type, const Literal& value) {
        const auto units = is_text(value) ? to_utf16(value.text) : std::nullopt;
        if (!units || units->size() != 1)
            return refuse(type, value, "one character of UTF-16's first plane");
        encode(out_, units->front());
    }

    void write_string(const Type& type, const Literal& value) {
        if (!is_text(value)) return refuse(type, value, "a text in quotes");
        if (value.text.find('\0') != std::string::npos)
            return fail(type, "a string cannot have a NUL in it");
        if (type.bound != 0 && value.text.size() > type.bound) {
            return fail(type, quoted(value.text) + " has " + std::to_string(value.text.size()) +
                                  " octets; at most " + std::to_string(type.bound) +
                                  " are accepted");
        }
        out_.string(value.text);
    }

    void write_wide_string(const Type& type, const Literal& value) {
        const auto units = is_text(value) ? to_utf16(value.text) : std::nullopt;
        if (!units) return refuse(type, value, "a text of UTF-8 in quotes");
        if (units->find(u'\0') != std::u16string::npos)
            return fail(type, "a wstring cannot have a NUL in it");
        if (type.bound != 0 && units->size() > type.bound) {
            return fail(type, quoted(value.text) + " has " + std::to_string(units->size()) +
                                  " code units; at most " + std::to_string(type.bound) +
                                  " are accepted");
        }
        out_.wide_string(*units);
    }

    void write_enumerator(const Type& type, const Literal& value) {
        std::string names;
        for (const Enumerator& each : type.definition->enumerators) {
            if (is_text(value) && each.name == value.text)
                return out_.variable_unsigned(each.number);
            names += (names.empty() ? "" : ", ") + each.name;
        }
        refuse(type, value, "one of " + names);
    }

    void write_flags(const Type& type, const Literal& value) {
        const Definition& definition = *type.definition;
        const IntegerRange range{0, ~std::uint64_t{0} >> (64 - definition.bit_bound)};
        std::uint64_t bits = 0;
        bool is_valid = is_text(value) || value.form == Form::number;
        std::string_view rest = value.text;
        while (is_valid && !rest.empty()) {
            const std::size_t end = std::min(rest.find('|'), rest.size());
            const std::string_view name = rest.substr(0, end);
            rest.remove_prefix(std::min(end + 1, rest.size()));
            const auto flag = std::find_if(definition.flags.begin(), definition.flags.end(),
                                           [&](const Flag& each) { return each.name == name; });
            const auto number = parse_integer(name, range);
            is_valid = flag != definition.flags.end() || number.has_value();
            if (!is_valid) break;
            bits |= flag != definition.flags.end() ? std::uint64_t{1} << flag->position : *number;
        }
        if (is_valid) return encode_integer(out_, kind_of_bitmask(definition), bits);
        std::string names;
        for (const Flag& each : definition.flags) names += each.name + ", ";
        refuse(type, value,
               names + (names.empty() ? "" : "several of them with | between, or ") +
                   "a number from " + range.text());
    }

    void write_reference(const Type& type, const Literal& value) {
        core::Reference reference;
        const bool is_nil = value.form == Form::null || (is_text(value) && value.text == "nil");
        if (!is_nil) {
            if (!is_text(value)) return refuse(type, value, "a reference in quotes, or nil");
            auto parsed = core::parse_reference(value.text);
            if (!parsed) {
                return fail(type, quoted(value.text) + " is no reference (CAN_IOR:..., " +
                                      "corbaloc:caniop:NODE/INDEX, corbaloc:caniop:group/GROUP " +
                                      "or nil): " + std::string{parsed.error().why});
            }
            reference = std::move(*parsed);
        }
        core::encode(out_, reference);
    }

    /// Enters one more level of a value that may contain itself.
    template <typename Write>
    void nested(const Type& type, Write write) {
        const ccdr::Nesting nesting{out_};
        if (!nesting && out_.error() == ccdr::EncodeError::bad_value)
            return fail(type, "has more than " + std::to_string(ccdr::highest_levels) + " levels");
        write();
    }

    static std::string member_names(const Definition& definition) {
        std::string names;
        for (const Member& each : definition.members) {
            names += (names.empty() ? "" : ", ") + each.name;
        }
        return names;
    }

    void write_struct(const Type& type, const Literal& value) {
        if (type.definition->is_recursive) return nested(type, [&] { write_members(type, value); });
        write_members(type, value);
    }

    void write_members(const Type& type, const Literal& value) {
        const Definition& definition = *type.definition;
        if (value.form != Form::object)
            return refuse(type, value, "an object with the members " + member_names(definition));
        for (const auto& [name, ignored] : value.members) {
            const auto same_name = [&n = name](const auto& each) { return each.name == n; };
            if (std::none_of(definition.members.begin(), definition.members.end(), same_name)) {
                return fail(type, "has no member '" + name + "', but " + member_names(definition));
            }
        }
        for (const Member& member : definition.members) {
            const Literal* found = nullptr;
            for (const auto& [name, part] : value.members) {
                if (name != member.name) continue;
                if (found != nullptr) return fail(type, "has the member '" + name + "' twice");
                found = &part;
            }
            if (found == nullptr) return fail(type, "the member '" + member.name + "' is missing");
            inside('.' + member.name, [&] { write(member.type, *found); });
        }
    }

    void write_union(const Type& type, const Literal& value) {
        if (type.definition->is_recursive) return nested(type, [&] { write_choice(type, value); });
        write_choice(type, value);
    }

    void write_choice(const Type& type, const Literal& value) {
        const Definition& definition = *type.definition;
        const std::string accepted =
            "an object with _d, the discriminator, and the member that it selects: one of " +
            member_names(definition);
        const Literal* discriminator = nullptr;
        const std::pair<std::string, Literal>* chosen = nullptr;
        if (value.form != Form::object) return refuse(type, value, accepted);
        for (const auto& each : value.members) {
            const bool is_discriminator = each.first == "_d";
            if (is_discriminator ? discriminator != nullptr : chosen != nullptr)
                return fail(type, "'" + each.first + "' is too much; accepted is " + accepted);
            if (is_discriminator) {
                discriminator = &each.second;
            } else {
                chosen = &each;
            }
        }
        if (discriminator == nullptr) return write_chosen(type, chosen, accepted);

        const std::size_t start = out_.size();
        inside("._d", [&] { write(definition.discriminator, *discriminator); });
        if (!error_.empty() || out_.error() != ccdr::EncodeError::none) return;
        ccdr::Decoder again{out_.octets().subspan(start)};
        const Member* const selected =
            selected_member(definition, decode_label(again, definition.discriminator.kind));
        if (selected == nullptr) {
            if (chosen != nullptr) fail(type, "the discriminator selects no member");
            return;
        }
        if (chosen == nullptr || chosen->first != selected->name)
            return fail(type, "the discriminator selects the member '" + selected->name + "'");
        inside('.' + selected->name, [&] { write(selected->type, chosen->second); });
    }

    /// Without a discriminator the member says what it is.
    void write_chosen(const Type& type, const std::pair<std::string, Literal>* chosen,
                      const std::string& accepted) {
        if (chosen == nullptr) return fail(type, "is empty; accepted is " + accepted);
        for (const Member& member : type.definition->members) {
            if (member.name != chosen->first) continue;
            if (member.labels.size() != 1 || member.is_default) {
                return fail(type, "more than one discriminator selects '" + member.name +
                                      "': say which as _d");
            }
            const Kind kind = type.definition->discriminator.kind;
            encode_integer(out_, kind == Kind::enumeration ? Kind::uint32 : kind,
                           static_cast<std::uint64_t>(member.labels.front()));
            return inside('.' + member.name, [&] { write(member.type, chosen->second); });
        }
        fail(type, "has no member '" + chosen->first + "'; accepted is " + accepted);
    }

    void write_elements(const Type& type, const Literal& value) {
        const bool is_array = type.kind == Kind::array;
        if (value.form != Form::array) {
            return refuse(type, value,
                          "a JSON array of " +
                              (is_array ? std::to_string(type.bound) + " elements, each " : "") +
                              type.element->name);
        }
        const std::size_t size = value.elements.size();
        if (is_array ? size != type.bound : type.bound != 0 && size > type.bound) {
            return fail(type, "has " + std::to_string(size) + " elements; " +
                                  (is_array ? "" : "at most ") + std::to_string(type.bound) +
                                  " are accepted");
        }
        if (!is_array) out_.count(size, takes_no_octets(*type.element) ? 0 : 1);
        for (std::size_t i = 0; i < size; ++i) {
            inside('[' + std::to_string(i) + ']', [&] { write(*type.element, value.elements[i]); });
        }
    }

    void write_map(const Type& type, const Literal& value) {
        if (value.form != Form::object) return refuse(type, value, "a JSON object");
        const std::size_t size = value.members.size();
        if (type.bound != 0 && size > type.bound) {
            return fail(type, "has " + std::to_string(size) + " entries; at most " +
                                  std::to_string(type.bound) + " are accepted");
        }
        out_.count(size);
        std::set<std::vector<std::uint8_t>> keys;
        for (const auto& [key, part] : value.members) {
            inside('[' + quoted(key) + ']', [&, &name = key, &element = part] {
                const std::size_t start = out_.size();
                write(*type.key, {.form = Form::bare, .text = name});
                const Bytes octets = out_.octets().subspan(start);
                if (error_.empty() && !keys.emplace(octets.begin(), octets.end()).second)
                    fail(type, "this key is there twice");
                write(*type.element, element);
            });
        }
    }

    std::optional<TypeCode> named_type_code(const Type& type, const Literal& name, Type& named) {
        const auto found = is_text(name) ? model_.find_type(name.text) : std::nullopt;
        if (!found) {
            refuse(type, name, "the name of a type, such as unsigned short or one of the IDL");
            return std::nullopt;
        }
        named = *found;
        auto code = type_code(*found);
        if (!code) fail(type, found->name + " can be in no any");
        return code;
    }

    void write_any(const Type& type, const Literal& value) {
        if (value.form == Form::null) return encode(out_, TypeCode{});
        const Literal* name = nullptr;
        const Literal* part = nullptr;
        for (const auto& [key, each] : value.members) {
            if (key == "type") name = &each;
            if (key == "value") part = &each;
        }
        if (name == nullptr || part == nullptr || value.members.size() != 2)
            return refuse(type, value, R"(an object such as {"type": "long", "value": 5})");
        nested(type, [&] {
            Type of;
            const auto code = named_type_code(type, *name, of);
            if (!code) return;
            encode(out_, *code);
            const std::size_t start = out_.size();
            inside(".value", [&] { write(of, *part); });
            if (!error_.empty() || out_.error() != ccdr::EncodeError::none) return;
            // Read as the receiver will.
            ccdr::Decoder check{out_.octets().subspan(start), nullptr, out_.levels()};
            ccdr::read_value(check, code->octets());
            if (!check.finished()) fail(type, "the receiver would refuse this value");
        });
    }

    void write_type_code(const Type& type, const Literal& value) {
        Type ignored;
        if (const auto code = named_type_code(type, value, ignored)) encode(out_, *code);
    }

    ccdr::Encoder& out_;
    const Model& model_;
    std::string path_;
    std::string error_;
};

/// The argument as a value: what is no text, number or name is JSON.
Result<Literal, std::string> parse_argument(const Type& type, const std::string& text) {
    if (!is_constructed(type.kind)) return Literal{.form = Form::bare, .text = text};
    auto parsed = parse_literal(text);
    if (parsed) return parsed;
    return Failure{quoted(text) + " is not JSON, which is accepted here: " + parsed.error()};
}

}  // namespace

Result<std::vector<std::uint8_t>, std::string> encode_arguments(const Operation& operation,
                                                                std::span<const std::string> texts,
                                                                const Model& model) {
    if (texts.size() != operation.arguments()) {
        return Failure{operation.name + " takes " + std::to_string(operation.arguments()) +
                       (operation.arguments() == 1 ? " argument, not " : " arguments, not ") +
                       std::to_string(texts.size()) + ": " + operation.signature()};
    }
    std::vector<std::uint8_t> buffer(giop::max_parameter_octets);
    ccdr::Encoder out{buffer};
    std::size_t position = 0;
    for (const Parameter& parameter : operation.parameters) {
        if (parameter.direction == Direction::out) continue;
        const std::string& text = texts[position++];
        const std::string name = "argument " + std::to_string(position) + " (" + parameter.name;
        const auto literal = parse_argument(parameter.type, text);
        if (!literal) return Failure{name + ": " + parameter.type.name + "): " + literal.error()};
        ArgumentWriter writer{out, model, name};
        writer.write(parameter.type, *literal);
        if (!writer.error().empty()) return Failure{writer.error()};
        switch (out.error()) {
            case ccdr::EncodeError::none:
                break;
            case ccdr::EncodeError::buffer_full:
                return Failure{name + ": " + parameter.type.name +
                               "): the arguments are longer than a message can be, " +
                               std::to_string(buffer.size()) + " octets"};
            case ccdr::EncodeError::bad_value:
                return Failure{name + ": " + parameter.type.name +
                               "): this is no value that can be sent"};
        }
    }
    buffer.resize(out.size());
    return buffer;
}

}  // namespace canorb::console
