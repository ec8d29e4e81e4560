#include "tools/console/values.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <span>

#include "orb/ccdr/format.hpp"
#include "orb/ccdr/nesting.hpp"
#include "orb/core/reference.hpp"
#include "tools/console/integers.hpp"
#include "tools/console/type_codes.hpp"
#include "tools/console/utf16.hpp"

namespace canorb::console {
namespace {

constexpr std::string_view digits = "0123456789ABCDEF";

/// Of values without octets there may be as many as a type says, but not more than are soon read.
constexpr std::size_t most_octetless_values = 4 * ccdr::highest_octetless;

/// The shortest text that is read as the same number again.
template <typename Float>
std::string shortest(Float number) {
    std::array<char, 64> text{};
    const auto written = std::to_chars(text.data(), text.data() + text.size(), number);
    return {text.data(), written.ptr};
}

template <typename Float>
Json number_json(Float number) {
    if (std::isnan(number)) return "nan";
    if (std::isinf(number)) return number < 0 ? "-inf" : "inf";
    if constexpr (std::is_same_v<Float, float>) {
        // Of 0.1F the digits 0.1, not those of the double with the same value.
        const std::string text = shortest(number);
        double same = 0;
        std::from_chars(text.data(), text.data() + text.size(), same);
        return same;
    } else {
        return number;
    }
}

std::string character_text(std::uint8_t octet) {
    if (octet >= ' ' && octet <= '~') return {static_cast<char>(octet)};
    return {'\\', 'x', digits[octet >> 4], digits[octet & 0xF]};
}

/// Reads values; remembers where the first that is none was.
class ValueReader {
  public:
    ValueReader(Bytes octets, const Model& model) : in_(octets), model_(model) {}

    ccdr::Decoder& decoder() { return in_; }

    Json read(const Type& type, const std::string& name) {
        Json value;
        inside(name, [&] { value = read(type); });
        return value;
    }

    /// Empty: all was read, and well.
    std::string error() const {
        if (!failed_at_.empty()) return failed_at_;
        if (in_.remaining() == 0) return {};
        return "it has " + std::to_string(in_.remaining()) + " octets too many: " + hex(in_.rest());
    }

  private:
    template <typename Read>
    void inside(const std::string& step, Read read_it) {
        const std::size_t size = path_.size();
        path_ += step;
        read_it();
        path_.resize(size);
    }

    Json read(const Type& type) {
        if (!in_.ok()) return {};
        const std::size_t before = in_.remaining();
        Json value = read_kind(type);
        if (in_.remaining() == before && ++octetless_values_ > most_octetless_values) in_.fail();
        if (!in_.ok() && failed_at_.empty())
            failed_at_ = "what should be " + path_ + " is no " + type.name;
        return value;
    }

    Json read_kind(const Type& type) {
        switch (type.kind) {
            case Kind::boolean: {
                bool value{};
                decode(in_, value);
                return value;
            }
            case Kind::character:
                return character_text(in_.octet());
            case Kind::wide_character: {
                char16_t value{};
                decode(in_, value);
                return to_utf8({&value, 1});
            }
            case Kind::int8:
            case Kind::int16:
            case Kind::int32:
            case Kind::int64:
                return static_cast<std::int64_t>(decode_integer(in_, type.kind));
            case Kind::float32:
                return read_number<float>();
            case Kind::float64:
                return read_number<double>();
            case Kind::float128:
                return read_long_double();
            case Kind::string:
                return read_string(type);
            case Kind::wide_string: {
                std::u16string value;
                ccdr::assign(value, in_.wide_string(ccdr::highest_count(type.bound)));
                return to_utf8(value);
            }
            case Kind::fixed:
                return read_fixed(type);
            case Kind::any:
                return read_any();
            case Kind::type_code:
                return read_type_code();
            case Kind::object:
                return read_reference();
            case Kind::enumeration:
                return read_enumerator(*type.definition);
            case Kind::bitmask:
                return read_flags(*type.definition);
            case Kind::structure:
                return nested(type, [&] { return read_members(type.definition->members); });
            case Kind::choice:
                return nested(type, [&] { return read_union(*type.definition); });
            case Kind::sequence:
            case Kind::array:
                return read_elements(type);
            case Kind::map:
                return read_map(type);
            case Kind::native:
                in_.fail();
                return {};
            default:
                return decode_integer(in_, type.kind);
        }
    }

    template <typename Read>
    Json nested(const Type& type, Read read_it) {
        if (!type.definition->is_recursive) return read_it();
        const ccdr::Nesting nesting{in_};
        return nesting ? read_it() : Json{};
    }

    template <typename Float>
    Json read_number() {
        Float value{};
        decode(in_, value);
        return number_json(value);
    }

    /// As a text: a number of JSON has not so many digits.
    Json read_long_double() {
        long double value{};
        decode(in_, value);
        return std::isfinite(value) ? Json(shortest(value))
                                    : number_json(static_cast<double>(value));
    }

    Json read_string(const Type& type) {
        const std::string_view text = in_.string();
        if (type.bound != 0 && text.size() > type.bound) in_.fail();
        return std::string{text};
    }

    Json read_fixed(const Type& type) {
        std::array<std::uint8_t, 31> buffer{};
        const auto number = std::span{buffer}.first(type.digits);
        const bool is_negative = fixed_digits::decode(in_, number);
        return fixed_digits::to_string(number, type.scale, is_negative);
    }

    Json read_enumerator(const Definition& definition) {
        const std::uint32_t number = in_.variable_unsigned(0xFFFFFFFF);
        for (const Enumerator& each : definition.enumerators) {
            if (each.number == number) return each.name;
        }
        in_.fail();
        return {};
    }

    Json read_flags(const Definition& definition) {
        std::uint64_t bits = decode_integer(in_, kind_of_bitmask(definition));
        if ((bits & ~(~std::uint64_t{0} >> (64 - definition.bit_bound))) != 0) in_.fail();
        std::string text;
        for (const Flag& each : definition.flags) {
            const std::uint64_t bit = std::uint64_t{1} << each.position;
            if ((bits & bit) == 0) continue;
            text += (text.empty() ? "" : "|") + each.name;
            bits &= ~bit;
        }
        if (bits != 0 || text.empty()) text += (text.empty() ? "" : "|") + std::to_string(bits);
        return text;
    }

    Json read_reference() {
        core::Reference reference;
        core::decode(in_, reference);
        if (reference.kind == core::Reference::Kind::nil) return "nil";
        return core::to_string(reference);
    }

    Json read_members(const std::vector<Member>& members) {
        Json value = Json::object();
        for (const Member& each : members) {
            inside('.' + each.name, [&] { value[each.name] = read(each.type); });
            if (!in_.ok()) break;
        }
        return value;
    }

    Json read_union(const Definition& definition) {
        Json value = Json::object();
        ccdr::Decoder again = in_;
        inside("._d", [&] { value["_d"] = read(definition.discriminator); });
        if (!in_.ok()) return value;
        const Member* const selected =
            selected_member(definition, decode_label(again, definition.discriminator.kind));
        if (selected != nullptr) {
            inside('.' + selected->name, [&] { value[selected->name] = read(selected->type); });
        }
        return value;
    }

    Json read_elements(const Type& type) {
        std::size_t count = type.bound;
        if (type.kind == Kind::sequence) {
            count =
                in_.count(takes_no_octets(*type.element) ? 0 : 1, ccdr::highest_count(type.bound));
        }
        Json value = Json::array();
        for (std::size_t i = 0; i < count && in_.ok(); ++i) {
            inside('[' + std::to_string(i) + ']', [&] { value.push_back(read(*type.element)); });
        }
        return value;
    }

    Json read_map(const Type& type) {
        const std::size_t count = in_.count(1, ccdr::highest_count(type.bound));
        Json value = Json::object();
        std::set<std::vector<std::uint8_t>> keys;
        for (std::size_t i = 0; i < count && in_.ok(); ++i) {
            inside('[' + std::to_string(i) + ']', [&] {
                const Bytes before = in_.rest();
                const Json key = read(*type.key);
                if (!in_.ok()) return;
                const Bytes octets = before.first(before.size() - in_.remaining());
                if (!keys.emplace(octets.begin(), octets.end()).second) return in_.fail();
                // The object's own emplace() would look for the key again, among all of them.
                value.get_ref<Json::object_t&>().emplace_back(
                    key.is_string() ? key.get<std::string>() : key.dump(), read(*type.element));
            });
        }
        return value;
    }

    Json read_type_code() {
        TypeCode code;
        decode(in_, code);
        if (const auto type = find_type(code, model_)) return type->name;
        return hex(code.octets());
    }

    Json read_any() {
        const ccdr::Nesting nesting{in_};
        if (!nesting) return {};
        TypeCode code;
        decode(in_, code);
        if (!in_.ok()) return {};
        if (code.kind() == TCKind::tk_null) return nullptr;
        const auto type = find_type(code, model_);
        if (!type) {
            const Bytes value = ccdr::read_value(in_, code.octets());
            return {{"typecode", hex(code.octets())}, {"octets", hex(value)}};
        }
        Json value;
        inside(".value", [&] { value = read(*type); });
        return {{"type", type->name}, {"value", std::move(value)}};
    }

    ccdr::Decoder in_;
    const Model& model_;
    std::string path_;
    std::string failed_at_;
    std::size_t octetless_values_ = 0;
};

Result<NamedValues, std::string> finish(const ValueReader& reader, NamedValues values) {
    const std::string error = reader.error();
    if (!error.empty()) return Failure{error};
    return values;
}

}  // namespace

std::string hex(Bytes octets) {
    std::string text;
    text.reserve(2 * octets.size());
    for (const std::uint8_t octet : octets) {
        text += digits[octet >> 4];
        text += digits[octet & 0xF];
    }
    return text;
}

Result<NamedValues, std::string> decode_results(const Operation& operation, Bytes body,
                                                const Model& model) {
    ValueReader reader{body, model};
    NamedValues values;
    if (operation.result) values.emplace_back("result", reader.read(*operation.result, "result"));
    for (const Parameter& each : operation.parameters) {
        if (each.direction == Direction::in) continue;
        values.emplace_back(each.name, reader.read(each.type, each.name));
    }
    return finish(reader, std::move(values));
}

Result<NamedValues, std::string> decode_arguments(const Operation& operation, Bytes parameters,
                                                  const Model& model) {
    ValueReader reader{parameters, model};
    NamedValues values;
    for (const Parameter& each : operation.parameters) {
        if (each.direction == Direction::out) continue;
        values.emplace_back(each.name, reader.read(each.type, each.name));
    }
    return finish(reader, std::move(values));
}

Result<NamedValues, std::string> decode_members(const Definition& exception, Bytes octets,
                                                const Model& model) {
    ValueReader reader{octets, model};
    NamedValues values;
    for (const Member& each : exception.members) {
        values.emplace_back(each.name, reader.read(each.type, each.name));
    }
    return finish(reader, std::move(values));
}

std::string to_text(const Json& value) {
    const std::string json = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string text;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const auto octet = static_cast<std::uint8_t>(json[i]);
        constexpr std::uint8_t delete_key = 0x7F;
        // The control characters behind those of ASCII are C2 80 to C2 9F. All of these stand only
        // in quotes.
        const bool is_control = octet == 0xC2 && static_cast<std::uint8_t>(json[i + 1]) < 0xA0;
        if (!is_control && octet != delete_key) {
            text += json[i];
            continue;
        }
        const auto code = is_control ? static_cast<std::uint8_t>(json[++i]) : octet;
        text += "\\u00";
        text += digits[code >> 4];
        text += digits[code & 0xF];
    }
    return text;
}

std::string to_text(const NamedValues& values) {
    std::string text = "{";
    std::string_view separator;
    for (const auto& [name, value] : values) {
        text += separator;
        text += name + ": " + to_text(value);
        separator = ", ";
    }
    return text + '}';
}

}  // namespace canorb::console
