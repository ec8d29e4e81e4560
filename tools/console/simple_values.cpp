#include "tools/console/simple_values.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>
#include <vector>

#include "orb/ccdr/fixed.hpp"
#include "orb/core/reference.hpp"
#include "tools/console/integers.hpp"
#include "tools/console/utf16.hpp"

namespace canorb::console {
namespace {

using Form = Literal::Form;

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

class Writer {
  public:
    explicit Writer(ccdr::Encoder& out) : out_(out) {}

    std::optional<std::string> run(const Type& type, const Literal& value) {
        switch (type.kind) {
            case Kind::boolean:
                write_boolean(value);
                break;
            case Kind::character:
                write_character(value);
                break;
            case Kind::wide_character:
                write_wide_character(value);
                break;
            case Kind::float32:
                write_floating<float>(value);
                break;
            case Kind::float64:
                write_floating<double>(value);
                break;
            case Kind::float128:
                write_floating<long double>(value);
                break;
            case Kind::string:
                write_string(type, value);
                break;
            case Kind::wide_string:
                write_wide_string(type, value);
                break;
            case Kind::fixed:
                write_fixed(type, value);
                break;
            case Kind::enumeration:
                write_enumerator(*type.definition, value);
                break;
            case Kind::bitmask:
                write_flags(*type.definition, value);
                break;
            case Kind::object:
                write_reference(value);
                break;
            default:
                write_integer(type, value);
        }
        return std::move(problem_);
    }

  private:
    void fail(std::string problem) { problem_ = std::move(problem); }
    void refuse(const Literal& value, const std::string& accepted) {
        fail(shown(value) + " is not " + accepted);
    }

    void write_boolean(const Literal& value) {
        const bool may_be = value.form == Form::bare || value.form == Form::boolean;
        const bool is_true = value.text == "true" || value.text == "TRUE" || value.text == "1";
        const bool is_false = value.text == "false" || value.text == "FALSE" || value.text == "0";
        if (!may_be || (!is_true && !is_false)) return refuse(value, "true or false");
        encode(out_, is_true);
    }

    void write_integer(const Type& type, const Literal& value) {
        const IntegerRange range = integer_range(type.kind);
        const auto bits =
            value.is_number() ? parse_integer(value.text, range) : std::optional<std::uint64_t>{};
        if (!bits) return refuse(value, range.text());
        encode_integer(out_, type.kind, *bits);
    }

    template <typename Float>
    void write_floating(const Literal& value) {
        const std::string& text = value.text;
        Float number{};
        const char* const end = text.data() + text.size();
        const auto [rest, error] = std::from_chars(text.data(), end, number);
        const bool may_be = value.is_number() || value.form == Form::string;  // "nan", "inf"
        if (may_be && rest == end && error == std::errc::result_out_of_range)
            return fail(text + " is too large, or too close to 0, for this type");
        if (!may_be || rest != end || error != std::errc{})
            return refuse(value, "a number such as -1.5e3, or inf, -inf or nan");
        encode(out_, number);
    }

    void write_fixed(const Type& type, const Literal& value) {
        const bool may_be = value.is_number() || value.form == Form::string;
        std::string_view text = value.text;
        const bool is_negative = text.starts_with('-');
        if (is_negative || text.starts_with('+')) text.remove_prefix(1);
        const auto digits = may_be ? fixed_digits_of(text, type) : std::nullopt;
        if (!digits) {
            return refuse(value, "a number of at most " + std::to_string(type.digits - type.scale) +
                                     " digits before and " + std::to_string(type.scale) +
                                     " behind the point");
        }
        std::vector<std::uint8_t> numbers;
        for (const char digit : *digits) numbers.push_back(static_cast<std::uint8_t>(digit - '0'));
        const bool is_zero = digits->find_first_not_of('0') == std::string::npos;
        fixed_digits::encode(out_, numbers, is_negative && !is_zero);
    }

    void write_character(const Literal& value) {
        const std::string& text = value.text;
        unsigned code = 0;
        constexpr std::string_view escape = "\\x";
        constexpr std::size_t escaped_size = 4;
        const bool is_escaped = text.size() == escaped_size && text.starts_with(escape);
        if (value.is_text() && is_escaped) {
            const char* const end = text.data() + text.size();
            const auto [rest, error] = std::from_chars(text.data() + escape.size(), end, code, 16);
            if (error == std::errc{} && rest == end)
                return encode(out_, static_cast<std::uint8_t>(code));
        }
        if (!value.is_text() || text.size() != 1)
            return refuse(value, "one character of ASCII, or one octet as \\xE4");
        encode(out_, text.front());
    }

    void write_wide_character(const Literal& value) {
        const auto units = value.is_text() ? to_utf16(value.text) : std::nullopt;
        if (!units || units->size() != 1)
            return refuse(value, "one character of UTF-16's first plane");
        encode(out_, units->front());
    }

    void write_string(const Type& type, const Literal& value) {
        if (!value.is_text()) return refuse(value, "a text in quotes");
        if (value.text.find('\0') != std::string::npos)
            return fail("a string cannot have a NUL in it");
        if (type.bound != 0 && value.text.size() > type.bound) {
            return fail(in_quotes(value.text) + " has " + std::to_string(value.text.size()) +
                        " octets; at most " + std::to_string(type.bound) + " are accepted");
        }
        out_.string(value.text);
    }

    void write_wide_string(const Type& type, const Literal& value) {
        const auto units = value.is_text() ? to_utf16(value.text) : std::nullopt;
        if (!units) return refuse(value, "a text of UTF-8 in quotes");
        if (units->find(u'\0') != std::u16string::npos)
            return fail("a wstring cannot have a NUL in it");
        if (type.bound != 0 && units->size() > type.bound) {
            return fail(in_quotes(value.text) + " has " + std::to_string(units->size()) +
                        " code units; at most " + std::to_string(type.bound) + " are accepted");
        }
        out_.wide_string(*units);
    }

    void write_enumerator(const Definition& definition, const Literal& value) {
        std::string names;
        for (const Enumerator& each : definition.enumerators) {
            if (value.is_text() && each.name == value.text)
                return out_.variable_unsigned(each.number);
            names += (names.empty() ? "" : ", ") + each.name;
        }
        refuse(value, "one of " + names);
    }

    void write_flags(const Definition& definition, const Literal& value) {
        const IntegerRange range{0, ~std::uint64_t{0} >> (64 - definition.bit_bound)};
        std::uint64_t bits = 0;
        bool is_valid = value.is_text() || value.form == Form::number;
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
        refuse(value, names + (names.empty() ? "" : "several of them with | between, or ") +
                          "a number from " + range.text());
    }

    void write_reference(const Literal& value) {
        core::Reference reference;
        const bool is_nil = value.form == Form::null || (value.is_text() && value.text == "nil");
        if (!is_nil) {
            if (!value.is_text()) return refuse(value, "a reference in quotes, or nil");
            auto parsed = core::parse_reference(value.text);
            if (!parsed) {
                return fail(in_quotes(value.text) + " is no reference (CAN_IOR:..., " +
                            "corbaloc:caniop:NODE/INDEX, corbaloc:caniop:group/GROUP " +
                            "or nil): " + std::string{parsed.error().why});
            }
            reference = std::move(*parsed);
        }
        core::encode(out_, reference);
    }

    ccdr::Encoder& out_;
    std::optional<std::string> problem_;
};

}  // namespace

std::optional<std::string> write_simple(ccdr::Encoder& out, const Type& type,
                                        const Literal& value) {
    return Writer{out}.run(type, value);
}

}  // namespace canorb::console
