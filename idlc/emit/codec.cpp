#include <algorithm>
#include <string>
#include <vector>

#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"
#include "idlc/emit/type_pieces.hpp"

namespace canorb::idlc::emit {

namespace {

/// The types that are declared in place within a struct, union or exception.
const model::Definitions& nested(const model::Definition& definition) {
    static const model::Definitions none;
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) return body->definitions;
    if (const auto* body = std::get_if<model::Union>(&definition.body)) return body->definitions;
    if (const auto* body = std::get_if<model::Exception>(&definition.body)) {
        return body->definitions;
    }
    return none;
}

constexpr std::string_view codec_declaration_piece = R"(
void encode(canorb::ccdr::Encoder& out, $type$ value);
void decode(canorb::ccdr::Decoder& in, $name$& value);
)";

constexpr std::string_view bitmask_piece = R"(
using canorb::operator|, canorb::operator&, canorb::operator^, canorb::operator~;
using canorb::operator|=, canorb::operator&=, canorb::operator^=;
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

constexpr std::string_view sparse_enum_codec_piece = R"(
void encode(canorb::ccdr::Encoder& out, $name$ value) {
    switch (value) {
        $cases$
            return out.variable_unsigned(static_cast<std::uint32_t>(value));
    }
    out.fail();
}

void decode(canorb::ccdr::Decoder& in, $name$& value) {
    value = static_cast<$name$>(in.variable_unsigned($highest$));
    switch (value) {
        $cases$
            return;
    }
    in.fail();
}
)";

std::string enum_codec(const model::Enum& body, const std::string& name) {
    std::uint32_t highest = 0;
    bool is_sparse = false;
    std::string cases;
    for (std::size_t i = 0; i < body.enumerators.size(); ++i) {
        const model::Enumerator& enumerator = body.enumerators[i];
        highest = std::max(highest, enumerator.number);
        is_sparse = is_sparse || enumerator.number != i;
        cases += "case " + name + "::" + identifier(enumerator.name) + ":\n";
    }
    return fill(is_sparse ? sparse_enum_codec_piece : enum_codec_piece,
                {{"name", name},
                 {"highest", std::to_string(highest) + (highest > 0x7FFFFFFF ? "U" : "")},
                 {"cases", cases}});
}

constexpr std::string_view members_codec_piece = R"(
void encode(canorb::ccdr::Encoder& out, const $name$& value) {
    $encode_nesting$
    $encodes$
}

void decode(canorb::ccdr::Decoder& in, $name$& value) {
    $decode_nesting$
    $decodes$
}
)";

constexpr std::string_view empty_codec_piece = R"(
void encode(canorb::ccdr::Encoder&, const $name$&) {}

void decode(canorb::ccdr::Decoder&, $name$&) {}
)";

std::string members_codec(const model::Definition& definition,
                          const std::vector<model::Member>& members, const Names& names) {
    const Context context = around_codec(definition);
    const std::string name = names.spell(definition, context);
    std::string encodes;
    std::string decodes;
    const auto* structure = std::get_if<model::Struct>(&definition.body);
    if (structure != nullptr && structure->base != nullptr) {
        const std::string base = names.spell(*structure->base, context);
        encodes = "encode(out, static_cast<const " + base + "&>(value));\n";
        decodes = "decode(in, static_cast<" + base + "&>(value));\n";
    }
    for (const model::Member& member : members) {
        const std::string value = coded(member.type, "value." + member_name(definition, member));
        encodes += "encode(out, " + value + ");\n";
        decodes += "decode(in, " + value + ");\n";
    }
    if (encodes.empty()) return fill(empty_codec_piece, {{"name", name}});
    const bool is_recursive = model::is_recursive(definition);
    return fill(members_codec_piece, {{"name", name},
                                      {"encode_nesting", is_recursive ? nesting("out") : ""},
                                      {"decode_nesting", is_recursive ? nesting("in") : ""},
                                      {"encodes", encodes},
                                      {"decodes", decodes}});
}

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

std::string own_codec(const model::Definition& definition, const Names& names) {
    if (!is_sendable(definition)) return {};
    const std::string name = names.spell(definition, around_codec(definition));
    if (const auto* body = std::get_if<model::Enum>(&definition.body)) {
        return enum_codec(*body, name);
    }
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) {
        return members_codec(definition, body->members, names);
    }
    if (const auto* body = std::get_if<model::Exception>(&definition.body)) {
        return members_codec(definition, body->members, names);
    }
    if (std::holds_alternative<model::Union>(definition.body)) {
        return union_codec(definition, names);
    }
    if (std::holds_alternative<model::Interface>(definition.body)) {
        return fill(reference_codec_piece, {{"name", name}});
    }
    return {};
}

std::string own_codec_declaration(const model::Definition& definition, const Names& names) {
    if (std::holds_alternative<model::Bitmask>(definition.body)) return fill(bitmask_piece, {});
    if (own_codec(definition, names).empty()) return {};
    const std::string name = names.spell(definition, around_codec(definition));
    const bool is_enum = std::holds_alternative<model::Enum>(definition.body);
    return fill(codec_declaration_piece,
                {{"name", name}, {"type", is_enum ? name : "const " + name + '&'}});
}

}  // namespace

Context around_codec(const model::Definition& definition) {
    Context context = in_namespace_of(definition);
    context.hidden = {"value", "number", "reference", "nesting", "Stream"};
    return context;
}

bool is_sendable(const model::Definition& definition) {
    model::Type type;
    type.kind = model::TypeKind::named;
    type.definition = &definition;
    return !model::is_local(type);
}

std::string nesting(const std::string& coder) {
    return "const canorb::ccdr::Nesting nesting{" + coder + "};\nif (!nesting) return;\n";
}

std::string codec_declaration(const model::Definition& definition, const Names& names) {
    std::string text;
    for (const model::Definition* one : nested(definition)) {
        text += codec_declaration(*one, names);
    }
    return text + own_codec_declaration(definition, names) + printing(definition, names) +
           type_code_function(definition, names);
}

std::string codec_definition(const model::Definition& definition, const Names& names) {
    std::string text;
    for (const model::Definition* one : nested(definition)) {
        const std::string codec = codec_definition(*one, names);
        if (!codec.empty()) text += codec + '\n';
    }
    const std::string own = own_codec(definition, names);
    if (own.empty() && !text.empty()) text.pop_back();
    return text + own;
}

}  // namespace canorb::idlc::emit
