#include "tools/console/arguments.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "orb/ccdr/format.hpp"
#include "orb/ccdr/nesting.hpp"
#include "orb/giop/message.hpp"
#include "tools/console/integers.hpp"
#include "tools/console/literal.hpp"
#include "tools/console/simple_values.hpp"
#include "tools/console/type_codes.hpp"

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
            case Kind::any:
                return write_any(type, value);
            case Kind::type_code:
                return write_type_code(type, value);
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
                if (const auto problem = write_simple(out_, type, value)) fail(type, *problem);
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
            inside('[' + in_quotes(key) + ']', [&, &name = key, &element = part] {
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
        const auto found = name.is_text() ? model_.find_type(name.text) : std::nullopt;
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
    return Failure{in_quotes(text) + " is not JSON, which is accepted here: " + parsed.error()};
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
