#include <algorithm>
#include <string>
#include <vector>

#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"
#include "idlc/emit/type_pieces.hpp"

namespace canorb::idlc::emit {

namespace {

using Members = std::vector<model::Member>;

/// `head` and the entries in braces: on one line where that is short and there are no comments.
template <typename Entry>
std::string enumeration(const std::string& head, const std::vector<Entry>& entries,
                        const std::vector<std::string>& written) {
    const bool commented = std::any_of(entries.begin(), entries.end(),
                                       [](const Entry& entry) { return !entry.comment.empty(); });
    const std::string one_line = head + (written.empty() ? "" : ' ' + join(written, ", ") + ' ');
    if (!commented && one_line.size() + 2 <= line_width) return one_line + "};\n";
    std::string lines;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        lines += comment(entries[i].comment) + written[i] + ",\n";
    }
    return head + '\n' + indent(lines) + "};\n";
}

std::string enum_declaration(const model::Enum& body, const std::string& name) {
    std::vector<std::string> written;
    std::uint32_t next = 0;
    for (const model::Enumerator& enumerator : body.enumerators) {
        const bool is_next = enumerator.number == next;
        written.push_back(identifier(enumerator.name) +
                          (is_next ? "" : " = " + std::to_string(enumerator.number)));
        next = enumerator.number + 1;
    }
    return enumeration("enum class " + name + " : std::uint32_t {", body.enumerators, written);
}

std::string bitmask_declaration(const model::Definition& definition, const model::Bitmask& body,
                                const std::string& name) {
    const unsigned bits = body.bit_bound;
    const unsigned width = bits <= 8 ? 8 : bits <= 16 ? 16 : bits <= 32 ? 32 : 64;
    std::vector<std::string> written;
    for (const model::Flag& flag : body.flags) {
        const std::string one = flag.position < 31 ? "1" : flag.position == 31 ? "1U" : "1ULL";
        written.push_back(identifier(flag.name) + " = " + one + " << " +
                          std::to_string(flag.position));
    }
    const Context context = beside(definition);
    const bool in_class =
        context.around != nullptr && !std::holds_alternative<model::Module>(context.around->body);
    return enumeration("enum class " + name + " : std::uint" + std::to_string(width) + "_t {",
                       body.flags, written) +
           (in_class ? "friend " : "") + "canorb::BitmaskBits<" + std::to_string(bits) +
           "> bitmask_bits(const " + name + "*);\n";
}

std::string member_declarations(const model::Definition& definition, const Members& members,
                                const Names& names, const Context& context) {
    std::string text;
    for (const model::Member& member : members) {
        const std::string name = member_name(definition, member);
        const std::string initial = initial_value(member, names, context);
        const std::string declared =
            initial.empty() ? names.variable(member.type, name, context)
                            : names.type(member.type, context) + ' ' + name + " = " + initial + ';';
        text += comment(member.comment) + declared + '\n';
    }
    return text;
}

constexpr std::string_view struct_piece = R"(
struct $head$ {
    $body$
    friend bool operator==(const $name$&, const $name$&) = default;
};
)";

std::string struct_declaration(const model::Definition& definition, const model::Struct& body,
                               const Names& names, const std::string& name) {
    std::string head = name;
    if (body.base != nullptr) {
        const bool is_behind = name != names.own(definition);
        const Context context = is_behind ? around_codec(definition) : beside(definition);
        head += " : " + names.spell(*body.base, context);
    }
    model::Type type;
    type.kind = model::TypeKind::named;
    type.definition = &definition;
    std::string inner = model::takes_no_octets(type) ? "using _takes_no_octets = void;\n" : "";
    inner += nested_declarations(body.definitions, names);
    inner += member_declarations(definition, body.members, names, inside(definition));
    if (!inner.empty()) inner += '\n';
    return fill(struct_piece, {{"head", head}, {"body", inner}, {"name", names.own(definition)}});
}

constexpr std::string_view exception_piece = R"(
class $head$ final : public canorb::UserException {
  public:
    $types$
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

std::string exception_constructors(const model::Definition& definition, const Members& members,
                                   const Names& names, const Context& context) {
    if (members.empty()) return {};
    const std::string name = names.own(definition);
    std::vector<std::string> parameters;
    std::vector<std::string> initializers;
    for (const model::Member& member : members) {
        const std::string own = member_name(definition, member);
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
    const std::string begin = (members.size() == 1 ? "explicit " : "") + name + '(';
    std::string constructor =
        begin + folded(parameters, begin.size(), std::string(begin.size(), ' ')) + ')';
    const std::string one_line = ": " + join(initializers, ", ") + " {}";
    const bool fits = constructor.find('\n') == std::string::npos &&
                      constructor.size() + one_line.size() < line_width;
    constructor += fits ? ' ' + one_line : "\n    : " + folded(initializers, 6, "      ") + " {}";
    return fill(constructors_piece, {{"name", name}, {"constructor", constructor}});
}

std::string exception_declaration(const model::Definition& definition, const model::Exception& body,
                                  const Names& names, const std::string& name) {
    const Context context = inside(definition);
    const std::string members = member_declarations(definition, body.members, names, context);
    return fill(exception_piece,
                {{"head", name},
                 {"types", nested_declarations(body.definitions, names)},
                 {"id", definition.repository_id},
                 {"constructors", exception_constructors(definition, body.members, names, context)},
                 {"members", body.members.empty() ? "" : '\n' + members}});
}

std::string constant_declaration(const model::Definition& definition,
                                 const model::Constant& constant, const Names& names,
                                 const std::string& name) {
    const Context context = beside(definition);
    const bool in_class = context.kind == Context::Kind::in_stub;
    const model::TypeKind kind = model::resolved(constant.type).kind;
    const std::string type = kind == model::TypeKind::string ? "std::string_view"
                             : kind == model::TypeKind::wide_string
                                 ? "std::u16string_view"
                                 : names.type(constant.type, context);
    const std::string value = names.value(constant.value, constant.type, context);
    return wrap(std::string{in_class ? "static" : "inline"} + " constexpr " + type + ' ' + name +
                    " =",
                ' ' + value + ";") +
           '\n';
}

std::string declaration(const model::Definition& definition, const Names& names,
                        const std::string& name) {
    if (const auto* body = std::get_if<model::Enum>(&definition.body)) {
        return enum_declaration(*body, name);
    }
    if (const auto* body = std::get_if<model::Bitmask>(&definition.body)) {
        return bitmask_declaration(definition, *body, name);
    }
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) {
        return struct_declaration(definition, *body, names, name);
    }
    if (std::holds_alternative<model::Union>(definition.body)) {
        return union_declaration(definition, names, name);
    }
    if (const auto* body = std::get_if<model::Exception>(&definition.body)) {
        return exception_declaration(definition, *body, names, name);
    }
    if (const auto* body = std::get_if<model::Alias>(&definition.body)) {
        return "using " + name + " = " + names.type(body->type, beside(definition)) + ";\n";
    }
    if (const auto* body = std::get_if<model::Constant>(&definition.body)) {
        return constant_declaration(definition, *body, names, name);
    }
    return {};
}

}  // namespace

std::string member_name(const model::Definition& definition, const model::Member& member) {
    // What the class of an exception has already.
    const bool is_taken =
        std::holds_alternative<model::Exception>(definition.body) && member.name == "repository_id";
    return is_taken ? "_cxx_" + member.name : identifier(member.name);
}

Context inside(const model::Definition& definition) {
    Context context{Context::Kind::in_namespace, &definition};
    for (const model::Member* member : all_members(definition)) {
        context.hidden.push_back(member_name(definition, *member));
    }
    if (const auto* body = std::get_if<model::Struct>(&definition.body)) {
        // What a base struct declares in place is found first.
        for (const model::Definition* base = body->base; base != nullptr;
             base = std::get<model::Struct>(base->body).base) {
            for (const model::Definition* nested :
                 std::get<model::Struct>(base->body).definitions) {
                context.hidden.push_back(identifier(nested->name));
            }
        }
    } else if (const auto* choice = std::get_if<model::Union>(&definition.body)) {
        for (const model::UnionCase& one : choice->cases) {
            context.hidden.push_back(identifier(one.member.name));
        }
        for (const char* used : {"value", "discriminator", "Stream"}) {
            context.hidden.emplace_back(used);
        }
    } else {
        for (const char* inherited : {"UserException", "Exception", "what"}) {
            context.hidden.emplace_back(inherited);
        }
    }
    return context;
}

std::string nested_declarations(const model::Definitions& definitions, const Names& names) {
    std::string text;
    for (const model::Definition* definition : definitions) {
        text += type_declaration(*definition, names, names.own(*definition)) + '\n';
    }
    return text;
}

std::string initial_value(const model::Member& member, const Names& names, const Context& context) {
    if (member.default_value) return names.value(*member.default_value, member.type, context);
    const model::Type& known = model::resolved(member.type);
    if (known.kind != model::TypeKind::named) return {};
    const auto* body = std::get_if<model::Enum>(&known.definition->body);
    if (body == nullptr || body->enumerators[body->default_index].number == 0) return {};
    return names.value(model::EnumeratorValue{known.definition, body->default_index}, member.type,
                       context);
}

std::string folded(const std::vector<std::string>& parts, std::size_t taken,
                   const std::string& margin) {
    std::string text;
    std::size_t column = taken;
    for (const std::string& part : parts) {
        const bool is_first = &part == &parts.front();
        if (!is_first && column + part.size() + 3 > line_width - 4) {
            text += ",\n" + margin;
            column = margin.size();
        } else if (!is_first) {
            text += ", ";
            column += 2;
        }
        text += part;
        column += part.size();
    }
    return text;
}

std::string type_declaration(const model::Definition& definition, const Names& names,
                             const std::string& name) {
    std::string text = declaration(definition, names, name);
    if (text.empty()) return {};
    const std::string from = place(definition.provenance);
    const bool is_line = text.find('\n') == text.size() - 1;
    if (is_line && definition.comment.empty()) {
        text.pop_back();
        return remarked(text, from);
    }
    return "// " + from + '\n' + comment(definition.comment) + text;
}

}  // namespace canorb::idlc::emit
