#include <algorithm>
#include <string>
#include <vector>

#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"
#include "idlc/structure.hpp"

namespace canorb::idlc::emit {

namespace {

using model::Direction;

const model::Interface& body_of(const model::Definition& interface) {
    return std::get<model::Interface>(interface.body);
}

constexpr std::string_view info_piece = R"(
/// What stubs and skeletons share about $id$.
$bases$
$constant$
)";

std::string interface_info(const model::Definition& interface, const Names& names) {
    const std::string name = names.own(interface);
    std::vector<std::string> bases;
    for (const model::Definition* base : body_of(interface).bases) {
        bases.push_back('&' + names.spell(*base, beside(interface)) + "Interface");
    }
    const std::string array =
        wrap("inline constexpr const canorb::InterfaceInfo* " + name + "Bases[] = {",
             join(bases, ", ") + "};");
    const std::string constant =
        wrap("inline constexpr canorb::InterfaceInfo " + name + "Interface{",
             '"' + interface.repository_id + "\", " + (bases.empty() ? "{}" : name + "Bases") +
                 ", " + hexadecimal(structural_hash(interface)) + "};");
    return fill(info_piece, {{"id", interface.repository_id},
                             {"bases", bases.empty() ? "" : array},
                             {"constant", constant}});
}

// The copy functions are declared so that there are none that move: compilers warn of virtual
// bases that would be moved from twice.
constexpr std::string_view class_piece = R"(
$info$

// $place$
$comment$
class $name$ : $bases$ {
  public:
    static constexpr const canorb::InterfaceInfo& _interface = $name$Interface;
$types$

    $name$() = default;  // nil
    explicit $name$(const canorb::ObjectRef& reference) : canorb::ObjectRef(reference) {}
    $name$(const $name$&) = default;
    $name$& operator=(const $name$&) = default;

    /// A copy whose calls end after `timeout`.
    $name$ with_timeout(canorb::Duration timeout) const;
    /// A copy that calls `callback` when a call through it is on the bus.
    $name$ with_sent(canorb::SentCallback callback) const;
$operations$$asynchronous$};
)";

std::string stub_bases(const model::Definition& interface, const Names& names) {
    std::vector<std::string> bases;
    for (const model::Definition* base : body_of(interface).bases) {
        bases.push_back("public virtual " + names.spell(*base, beside(interface)));
    }
    return bases.empty() ? "public virtual canorb::ObjectRef" : join(bases, ", ");
}

std::string stub_members(const model::Definition& interface, const Names& names) {
    const Context context = in_stub(interface);
    std::string text;
    for (const model::Operation& operation : body_of(interface).operations) {
        // A line between what has a comment and what is before it.
        if (text.empty() || !operation.comment.empty()) text += '\n';
        text +=
            comment(operation.comment) +
            remarked(signature(operation, names, context, context) + " const;",
                     place(operation.provenance) + ", operation " + std::to_string(operation.id) +
                         raised_remark(operation, names, context));
    }
    return indent(text);
}

std::string operation_info(const model::Definition& interface, const model::Operation& operation,
                           const Names& names) {
    std::string text = "inline constexpr canorb::OperationInfo " + operation_constant(operation) +
                       "{\n    .declared_in = &" + names.own(interface) +
                       "Interface, .id = " + std::to_string(operation.id) + ", .name = \"" +
                       model::wire_name(operation) + '"';
    if (operation.oneway) text += ", .oneway = true";
    if (model::groupable(operation)) text += ", .groupable = true";
    return text + "};\n";
}

constexpr std::string_view call_piece = R"(
$signature$ const {
    canorb::ClientCall $call${*this, $operation$};
    $call$.write($arguments$);
    $call$.invoke$exceptions$();
    $declare$
    $call$.read($results$);
    $return$
}
)";

std::string call(const model::Definition& interface, const model::Operation& operation,
                 const Names& names) {
    const std::string class_name = names.own(interface);
    Context inside = in_stub(interface);
    std::vector<std::string> arguments;
    std::vector<std::string> results;
    const std::string result = local_name("result", operation);
    for (const model::Parameter& parameter : operation.parameters) {
        inside.hidden.push_back(identifier(parameter.name));
    }
    if (operation.result) results.push_back(coded(*operation.result, result));
    for (const model::Parameter& parameter : operation.parameters) {
        const std::string value = coded(parameter.type, identifier(parameter.name));
        if (parameter.direction != Direction::out) arguments.push_back(value);
        if (parameter.direction != Direction::in) results.push_back(value);
    }
    std::vector<std::string> exceptions;
    for (const model::Definition* exception : operation.raises) {
        exceptions.push_back(names.spell(*exception, inside));
    }
    const std::string declare =
        operation.result ? names.variable(*operation.result, result, inside) : "";
    return fill(call_piece,
                {{"signature", signature(operation, names, beside(interface), in_stub(interface),
                                         class_name + "::")},
                 {"call", local_name("call", operation)},
                 {"operation", class_name + "_operations::" + operation_constant(operation)},
                 {"arguments", join(arguments, ", ")},
                 {"exceptions", exceptions.empty() ? "" : '<' + join(exceptions, ", ") + '>'},
                 {"declare", declare},
                 {"results", join(results, ", ")},
                 {"return", operation.result ? "return " + result + ';' : ""}});
}

constexpr std::string_view copies_piece = R"(
$name$ $name$::with_timeout(canorb::Duration timeout) const {
    return $name${canorb::ObjectRef::with_timeout(timeout)};
}

$name$ $name$::with_sent(canorb::SentCallback callback) const {
    return $name${canorb::ObjectRef::with_sent(std::move(callback))};
}
)";

}  // namespace

std::string nested_types(const model::Definition& interface, const std::vector<Step>& steps,
                         const Names& names) {
    std::string text;
    for (const model::Definition* nested : body_of(interface).definitions) {
        const bool waits = std::any_of(steps.begin(), steps.end(), [&](const Step& step) {
            return step.definition == nested && step.kind == Step::Kind::behind;
        });
        const std::string name = names.own(*nested);
        const bool is_struct = std::holds_alternative<model::Struct>(nested->body);
        text += '\n' + (waits ? (is_struct ? "struct " : "class ") + name + ";\n"
                              : type_declaration(*nested, names, name));
    }
    return indent(text);
}

std::string raised_remark(const model::Operation& operation, const Names& names,
                          const Context& context) {
    std::vector<std::string> parts;
    for (const model::Definition* exception : operation.raises) {
        parts.push_back(names.spell(*exception, context));
    }
    return parts.empty() ? "" : ", raises " + join(parts, ", ");
}

std::string signature(const model::Operation& operation, const Names& names,
                      const Context& result_context, const Context& parameter_context,
                      const std::string& scope) {
    std::vector<std::string> parameters;
    for (const model::Parameter& parameter : operation.parameters) {
        Context context = parameter_context;
        // A parameter hides what it is called like from the ones behind it.
        for (const model::Parameter& earlier : operation.parameters) {
            if (&earlier == &parameter) break;
            context.hidden.push_back(identifier(earlier.name));
        }
        parameters.push_back(names.parameter(parameter, context));
    }
    return (operation.result ? names.type(*operation.result, result_context) : "void") + ' ' +
           scope + identifier(operation.name) + '(' + join(parameters, ", ") + ')';
}

std::string operation_constant(const model::Operation& operation) {
    return operation.kind == model::OperationKind::operation ? identifier(operation.name)
                                                             : model::wire_name(operation);
}

std::string local_name(const std::string& wanted, const model::Operation& operation) {
    const bool taken =
        std::any_of(operation.parameters.begin(), operation.parameters.end(),
                    [&](const model::Parameter& parameter) { return parameter.name == wanted; });
    return taken ? '_' + wanted : wanted;
}

std::string stub_declaration(const model::Definition& interface, const std::vector<Step>& steps,
                             const Names& names) {
    return fill(class_piece, {{"info", interface_info(interface, names)},
                              {"place", place(interface.provenance)},
                              {"comment", comment(interface.comment)},
                              {"name", names.own(interface)},
                              {"bases", stub_bases(interface, names)},
                              {"types", nested_types(interface, steps, names)},
                              {"operations", stub_members(interface, names)},
                              {"asynchronous", asynchronous_members(interface, names)}});
}

std::string operations(const model::Definition& interface, const Names& names) {
    std::string text;
    for (const model::Operation& operation : body_of(interface).operations) {
        text += operation_info(interface, operation, names);
    }
    if (text.empty()) return {};
    return "namespace " + names.own(interface) + "_operations {\n" + text + "}  // namespace " +
           names.own(interface) + "_operations\n";
}

std::string stub_definition(const model::Definition& interface, const Names& names) {
    std::string text = fill(copies_piece, {{"name", names.own(interface)}});
    for (const model::Operation& operation : body_of(interface).operations) {
        text += '\n' + call(interface, operation, names);
    }
    return text;
}

}  // namespace canorb::idlc::emit
