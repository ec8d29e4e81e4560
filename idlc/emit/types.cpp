#include <algorithm>
#include <string>
#include <vector>

#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"

namespace canorb::idlc::emit {

namespace {

using Members = std::vector<model::Member>;

std::string enum_declaration(const model::Definition& definition, const model::Enum& body,
                             const Names& names) {
    std::vector<std::string> enumerators;
    bool commented = false;
    for (const model::Enumerator& enumerator : body.enumerators) {
        enumerators.push_back(identifier(enumerator.name));
        commented = commented || !enumerator.comment.empty();
    }
    const std::string head = "enum class " + names.own(definition) + " : std::uint32_t {";
    const std::string one_line = head + ' ' + join(enumerators, ", ") + " };\n";
    if (!commented && one_line.size() <= line_width) return one_line;
    std::string lines;
    for (std::size_t i = 0; i < enumerators.size(); ++i) {
        lines += comment(body.enumerators[i].comment) + enumerators[i] + ",\n";
    }
    return head + '\n' + indent(lines) + "};\n";
}

std::string member_declarations(const Members& members, const Names& names, Context context) {
    for (const model::Member& member : members) context.hidden.push_back(identifier(member.name));
    std::string text;
    for (const model::Member& member : members) {
        text += comment(member.comment) +
                names.variable(member.type, identifier(member.name), context) + '\n';
    }
    return text;
}

constexpr std::string_view struct_piece = R"(
struct $name$ {
    $members$

    friend bool operator==(const $name$&, const $name$&) = default;
};
)";

constexpr std::string_view exception_piece = R"(
class $name$ final : public canorb::UserException {
  public:
    static constexpr std::string_view repository_id = "$id$";

    $constructors$
    std::string_view _repository_id() const noexcept override { return repository_id; }
    $members$
};
)";

constexpr std::string_view constructors_piece = R"(
$name$() = default;
$constructor$
)";

std::string exception_constructors(const std::string& name, const Members& members,
                                   const Names& names, const Context& context) {
    if (members.empty()) return {};
    std::vector<std::string> parameters;
    std::vector<std::string> initializers;
    for (const model::Member& member : members) {
        const std::string own = identifier(member.name);
        std::string parameter = member.name + "_value";
        while (std::any_of(members.begin(), members.end(),
                           [&](const model::Member& other) { return other.name == parameter; })) {
            parameter += '_';
        }
        parameters.push_back(names.type(member.type, context) + ' ' + parameter);
        initializers.push_back(model::is_scalar(member.type)
                                   ? own + '(' + parameter + ')'
                                   : own + "(std::move(" + parameter + "))");
    }
    const std::string explicit_keyword = members.size() == 1 ? "explicit " : "";
    std::string constructor = explicit_keyword + name + '(' + join(parameters, ", ") + ')';
    const std::string initialized = ": " + join(initializers, ", ") + " {}";
    const bool fits = constructor.size() + initialized.size() < line_width;
    constructor += (fits ? " " : "\n    ") + initialized;
    return fill(constructors_piece, {{"name", name}, {"constructor", constructor}});
}

std::string exception_declaration(const model::Definition& definition, const model::Exception& body,
                                  const Names& names) {
    const std::string name = names.own(definition);
    const std::string members = member_declarations(body.members, names, beside(definition));
    Context context = beside(definition);
    for (const model::Member& member : body.members) {
        context.hidden.push_back(identifier(member.name));
    }
    return fill(exception_piece,
                {{"name", name},
                 {"id", definition.repository_id},
                 {"constructors", exception_constructors(name, body.members, names, context)},
                 {"members", body.members.empty() ? "" : '\n' + members}});
}

std::string constant_declaration(const model::Definition& definition,
                                 const model::Constant& constant, const Names& names) {
    const Context context = beside(definition);
    const bool in_class = context.kind == Context::Kind::in_stub;
    const model::TypeKind kind = model::resolved(constant.type).kind;
    const std::string type = kind == model::TypeKind::string ? "std::string_view"
                             : kind == model::TypeKind::wide_string
                                 ? "std::u16string_view"
                                 : names.type(constant.type, context);
    return std::string{in_class ? "static" : "inline"} + " constexpr " + type + ' ' +
           names.own(definition) + " = " + names.value(constant.value, constant.type, context) +
           ";\n";
}

std::string declaration(const model::Definition& definition, const Names& names) {
    if (const auto* body = std::get_if<model::Enum>(&definition.body)) {
        return enum_declaration(definition, *body, names);
    }
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) {
        return fill(struct_piece,
                    {{"name", names.own(definition)},
                     {"members", member_declarations(body->members, names, beside(definition))}});
    }
    if (const auto* body = std::get_if<model::Exception>(&definition.body)) {
        return exception_declaration(definition, *body, names);
    }
    if (const auto* body = std::get_if<model::Alias>(&definition.body)) {
        return "using " + names.own(definition) + " = " +
               names.type(body->type, beside(definition)) + ";\n";
    }
    if (const auto* body = std::get_if<model::Constant>(&definition.body)) {
        return constant_declaration(definition, *body, names);
    }
    return {};
}

/// Where the codec of a definition is: in the namespace, also for types inside of an interface.
Context namespace_around(const model::Definition& definition) {
    const Context context = beside(definition);
    if (context.kind == Context::Kind::in_namespace) return context;
    return {Context::Kind::in_namespace, context.around->parent};
}

constexpr std::string_view codec_declaration_piece = R"(
void encode(canorb::ccdr::Encoder& out, $type$ value);
void decode(canorb::ccdr::Decoder& in, $name$& value);
)";

constexpr std::string_view enum_codec_piece = R"(
void encode(canorb::ccdr::Encoder& out, $name$ value) {
    const auto number = static_cast<std::uint32_t>(value);
    if (number > $highest$) return out.fail();
    out.variable_unsigned(number);
}

void decode(canorb::ccdr::Decoder& in, $name$& value) {
    value = static_cast<$name$>(in.variable_unsigned($highest$));
}
)";

constexpr std::string_view members_codec_piece = R"(
void encode(canorb::ccdr::Encoder& out, const $name$& value) {
    $encodes$
}

void decode(canorb::ccdr::Decoder& in, $name$& value) {
    $decodes$
}
)";

constexpr std::string_view empty_codec_piece = R"(
void encode(canorb::ccdr::Encoder&, const $name$&) {}

void decode(canorb::ccdr::Decoder&, $name$&) {}
)";

constexpr std::string_view reference_codec_piece = R"(
void encode(canorb::ccdr::Encoder& out, const $name$& value) {
    encode(out, static_cast<const canorb::ObjectRef&>(value));
}

void decode(canorb::ccdr::Decoder& in, $name$& value) {
    canorb::ObjectRef reference;
    decode(in, reference);
    value = $name${reference};
}
)";

std::string members_codec(const std::string& name, const Members& members) {
    if (members.empty()) return fill(empty_codec_piece, {{"name", name}});
    std::string encodes;
    std::string decodes;
    for (const model::Member& member : members) {
        const std::string value = coded(member.type, "value." + identifier(member.name));
        encodes += "encode(out, " + value + ");\n";
        decodes += "decode(in, " + value + ");\n";
    }
    return fill(members_codec_piece, {{"name", name}, {"encodes", encodes}, {"decodes", decodes}});
}

std::string own_codec(const model::Definition& definition, const Names& names) {
    const std::string name = names.spell(definition, namespace_around(definition));
    if (const auto* body = std::get_if<model::Enum>(&definition.body)) {
        const std::string highest = std::to_string(body->enumerators.size() - 1);
        return fill(enum_codec_piece, {{"name", name}, {"highest", highest}});
    }
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) {
        return members_codec(name, body->members);
    }
    if (const auto* body = std::get_if<model::Exception>(&definition.body)) {
        return members_codec(name, body->members);
    }
    if (std::holds_alternative<model::Interface>(definition.body)) {
        return fill(reference_codec_piece, {{"name", name}});
    }
    return {};
}

}  // namespace

std::string type_declaration(const model::Definition& definition, const Names& names) {
    std::string text = declaration(definition, names);
    if (text.empty()) return {};
    const std::string from = place(definition.provenance);
    const bool is_line = text.find('\n') == text.size() - 1;
    if (is_line && definition.comment.empty()) {
        text.pop_back();
        return remarked(text, from);
    }
    return "// " + from + '\n' + comment(definition.comment) + text;
}

std::string codec_declaration(const model::Definition& definition, const Names& names) {
    std::string text;
    if (!own_codec(definition, names).empty()) {
        const std::string name = names.spell(definition, namespace_around(definition));
        const bool is_enum = std::holds_alternative<model::Enum>(definition.body);
        text = fill(codec_declaration_piece,
                    {{"name", name}, {"type", is_enum ? name : "const " + name + '&'}});
    }
    const auto* interface = std::get_if<model::Interface>(&definition.body);
    if (interface == nullptr) return text;
    for (const model::Definition* nested : interface->definitions) {
        text += codec_declaration(*nested, names);
    }
    return text;
}

std::string codec_definition(const model::Definition& definition, const Names& names) {
    std::string text = own_codec(definition, names);
    const auto* interface = std::get_if<model::Interface>(&definition.body);
    if (interface == nullptr) return text;
    for (const model::Definition* nested : interface->definitions) {
        const std::string codec = codec_definition(*nested, names);
        if (!codec.empty()) text += '\n' + codec;
    }
    return text;
}

}  // namespace canorb::idlc::emit
