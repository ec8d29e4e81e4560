#include <string>
#include <vector>

#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"
#include "idlc/emit/type_pieces.hpp"

namespace canorb::idlc::emit {

namespace {

const model::Union& body_of(const model::Definition& definition) {
    return std::get<model::Union>(definition.body);
}

/// Whether a value of the discriminator can select no member.
bool can_be_empty(const model::Union& body) {
    for (const model::UnionCase& one : body.cases) {
        if (one.is_default) return false;
    }
    return body.unlabelled.has_value();
}

// The alternatives of the std::variant are no member, which is 0, and the members from 1. It asks
// whether its first can be constructed when the class around may not be complete yet: a struct that
// is nested there, and has initializers, cannot yet.

/// Which alternative a value without a label selects.
std::size_t unlabelled_index(const model::Union& body) {
    for (std::size_t i = 0; i < body.cases.size(); ++i) {
        if (body.cases[i].is_default) return i + 1;
    }
    return 0;
}

/// A name for a parameter that is not the union's own.
std::string parameter(const std::string& wanted, const model::Definition& definition) {
    return definition.name == wanted ? wanted + '_' : wanted;
}

/// What the member is called in messages.
std::string full_name(const model::Definition& definition, const std::string& member) {
    return '"' + model::scoped_name(definition) + "::" + member + '"';
}

constexpr std::string_view switch_piece = R"(
switch ($discriminator$) {
    $cases$
    default:
        return $unlabelled$;
}
)";

/// The statement that returns which alternative `discriminator` selects.
std::string selection(const model::Definition& definition, const Names& names,
                      const Context& context) {
    const model::Union& body = body_of(definition);
    const std::string discriminator = parameter("discriminator", definition);
    const std::size_t unlabelled = unlabelled_index(body);
    std::string cases;
    // Compilers do not like a switch over a bool.
    std::size_t of_bool[] = {unlabelled, unlabelled};
    for (std::size_t i = 0; i < body.cases.size(); ++i) {
        const model::UnionCase& one = body.cases[i];
        if (one.is_default) continue;
        for (const model::Value& label : one.labels) {
            if (const bool* value = std::get_if<bool>(&label)) of_bool[*value ? 1 : 0] = i + 1;
            cases += "case " + names.value(label, body.discriminator, context) + ":\n";
        }
        cases += "    return " + std::to_string(i + 1) + ";\n";
    }
    if (model::resolved(body.discriminator).kind == model::TypeKind::boolean) {
        return "return " + discriminator + " ? " + std::to_string(of_bool[1]) + " : " +
               std::to_string(of_bool[0]) + ";\n";
    }
    return fill(switch_piece, {{"discriminator", discriminator},
                               {"cases", cases},
                               {"unlabelled", std::to_string(unlabelled)}});
}

constexpr std::string_view member_piece = R"(
$comment$
void $name$($type$ $value$) {
    _members.emplace<$index$>($moved$);
    _discriminator = $label$;
}
$labelled$
$readers$
)";

constexpr std::string_view labelled_piece = R"(
void $name$($type$ $value$, $discriminator_type$ $discriminator$) {
    canorb::check_selected(_selected_by($discriminator$) == $index$, $full_name$);
    _members.emplace<$index$>($moved$);
    _discriminator = $discriminator$;
}
)";

/// A function that returns the member.
std::string reader(const std::string& head, const std::string& value) {
    const std::string one_line = head + " { return " + value + "; }\n";
    if (one_line.size() + 4 <= line_width) return one_line;
    return head + " {\n    return " + value + ";\n}\n";
}

std::string member_functions(const model::Definition& definition, std::size_t index,
                             const Names& names, const Context& context) {
    const model::Union& body = body_of(definition);
    const model::UnionCase& one = body.cases[index];
    const std::string name = identifier(one.member.name);
    const std::string type = names.type(one.member.type, context);
    const bool is_scalar = model::is_scalar(one.member.type);
    const std::string value = parameter("value", definition);
    const std::string moved = is_scalar ? value : "std::move(" + value + ')';
    const model::Value& label = one.labels.empty() ? *body.unlabelled : one.labels.front();
    const std::string of_index = std::to_string(index + 1);
    const std::string full = full_name(definition, one.member.name);
    const bool has_choice = one.is_default || one.labels.size() > 1;
    const std::string labelled =
        has_choice
            ? fill(labelled_piece, {{"name", name},
                                    {"type", type},
                                    {"discriminator_type", names.type(body.discriminator, context)},
                                    {"discriminator", parameter("discriminator", definition)},
                                    {"index", of_index},
                                    {"full_name", full},
                                    {"value", value},
                                    {"moved", moved}})
            : "";
    const std::string member = "canorb::union_member<" + of_index + ">(_members, " + full + ')';
    const std::string read = is_scalar ? type : "const " + type + '&';
    return fill(member_piece, {{"comment", comment(one.member.comment)},
                               {"name", name},
                               {"type", type},
                               {"index", of_index},
                               {"value", value},
                               {"moved", moved},
                               {"label", names.value(label, body.discriminator, context)},
                               {"labelled", labelled},
                               {"readers", reader(read + ' ' + name + "() const", member) +
                                               reader(type + "& " + name + "()", member)}});
}

constexpr std::string_view empty_piece = R"(
/// No member.
void _default() {
    _members.emplace<0>();
    _discriminator = $label$;
}
)";

constexpr std::string_view friends_piece = R"(
friend void encode(canorb::ccdr::Encoder& out, const $name$& value);
friend void decode(canorb::ccdr::Decoder& in, $name$& value);
template <canorb::OutputStream Stream>
friend Stream& operator<<(Stream& out, const $name$& value) {
    return canorb::print_union(out, value._discriminator, value._members,
                               {$members$});
}
)";

std::string friends(const model::Definition& definition, const Names& names,
                    const Context& context) {
    if (!is_sendable(definition)) return {};
    std::vector<std::string> members;
    for (const model::UnionCase& one : body_of(definition).cases) {
        members.push_back('"' + one.member.name + '"');
    }
    const std::string margin(28, ' ');
    return fill(friends_piece, {{"name", names.spell(definition, context)},
                                {"members", folded(members, margin.size() + 4, "")}});
}

constexpr std::string_view union_piece = R"(
class $head$ {
  public:
    $types$
    $type$ _d() const { return _discriminator; }
    /// To another value that selects the same member; canorb::BAD_PARAM for all others.
    void _d($type$ $discriminator$) {
        canorb::check_selected(_selected_by($discriminator$) == _members.index(),
                               $d_name$);
        _discriminator = $discriminator$;
    }

    $members$
    friend bool operator==(const $name$&, const $name$&) = default;
    $friends$

  private:
    static constexpr std::size_t _selected_by($type$ $discriminator$) {
        $selection$
    }

    $type$ _discriminator = $first$;
    $storage$
};
)";

std::string storage(const model::Union& body, const Names& names, const Context& context) {
    std::vector<std::string> types{"std::monostate"};
    for (const model::UnionCase& one : body.cases) {
        types.push_back(names.type(one.member.type, context));
    }
    const std::string initial = initial_value(body.cases.front().member, names, context);
    return "std::variant<" + folded(types, 32, std::string(13, ' ')) +
           "> _members{std::in_place_index<1>" + (initial.empty() ? "" : ", " + initial) + "};";
}

constexpr std::string_view codec_piece = R"(
void encode(canorb::ccdr::Encoder& out, const $name$& value) {
    $encode_nesting$
    encode(out, value._discriminator);
    switch (value._members.index()) {
        $encodes$
        default:
            return$encode_default$;
    }
}

void decode(canorb::ccdr::Decoder& in, $name$& value) {
    $decode_nesting$
    decode(in, value._discriminator);
    switch ($name$::_selected_by(value._discriminator)) {
        $decodes$
        default:
            $decode_default$
    }
}
)";

}  // namespace

std::string union_declaration(const model::Definition& definition, const Names& names,
                              const std::string& name) {
    const model::Union& body = body_of(definition);
    const Context context = inside(definition);
    std::string members;
    for (std::size_t i = 0; i < body.cases.size(); ++i) {
        members += member_functions(definition, i, names, context) + '\n';
    }
    if (can_be_empty(body)) {
        const std::string label = names.value(*body.unlabelled, body.discriminator, context);
        members += fill(empty_piece, {{"label", label}}) + '\n';
    }
    const model::UnionCase& first = body.cases.front();
    const model::Value& label = first.labels.empty() ? *body.unlabelled : first.labels.front();
    return fill(union_piece, {{"head", name},
                              {"name", names.own(definition)},
                              {"types", nested_declarations(body.definitions, names)},
                              {"type", names.type(body.discriminator, context)},
                              {"discriminator", parameter("discriminator", definition)},
                              {"d_name", full_name(definition, "_d")},
                              {"members", members},
                              {"friends", friends(definition, names, context)},
                              {"selection", selection(definition, names, context)},
                              {"first", names.value(label, body.discriminator, context)},
                              {"storage", storage(body, names, context)}});
}

std::string union_codec(const model::Definition& definition, const Names& names) {
    const model::Union& body = body_of(definition);
    std::string encodes;
    std::string decodes;
    for (std::size_t i = 0; i < body.cases.size(); ++i) {
        const model::Type& type = body.cases[i].member.type;
        const std::string index = std::to_string(i + 1);
        const std::string head = "case " + index + ":\n    return ";
        encodes += head + "encode(out, " +
                   coded(type, "*std::get_if<" + index + ">(&value._members)") + ");\n";
        decodes +=
            head + "decode(in, " + coded(type, "value._members.emplace<" + index + ">()") + ");\n";
    }
    const bool is_recursive = model::is_recursive(definition);
    const bool can_be_empty = emit::can_be_empty(body);
    const std::string empty = "value._members.emplace<0>();";
    return fill(codec_piece, {{"name", names.spell(definition, around_codec(definition))},
                              {"encode_nesting", is_recursive ? nesting("out") : ""},
                              {"decode_nesting", is_recursive ? nesting("in") : ""},
                              {"encodes", encodes},
                              {"encode_default", can_be_empty ? "" : " out.fail()"},
                              {"decodes", decodes},
                              {"decode_default", can_be_empty ? empty : "return in.fail();"}});
}

}  // namespace canorb::idlc::emit
