#include <string>
#include <vector>

#include "idlc/emit/pieces.hpp"
#include "idlc/emit/text.hpp"

namespace canorb::idlc::emit {

namespace {

using model::Direction;

const model::Interface& body_of(const model::Definition& interface) {
    return std::get<model::Interface>(interface.body);
}

/// The return value, then inout and out parameters.
std::vector<const model::Type*> results_of(const model::Operation& operation) {
    std::vector<const model::Type*> results;
    if (operation.result) results.push_back(&*operation.result);
    for (const model::Parameter& parameter : operation.parameters) {
        if (parameter.direction != Direction::in) results.push_back(&parameter.type);
    }
    return results;
}

std::string future_type(const model::Operation& operation, const Names& names,
                        const Context& context) {
    std::vector<std::string> types;
    for (const model::Type* type : results_of(operation)) {
        types.push_back(names.type(*type, context));
    }
    const std::string type = types.empty()       ? "void"
                             : types.size() == 1 ? types.front()
                                                 : "std::tuple<" + join(types, ", ") + '>';
    return "canorb::Future<" + type + '>';
}

/// What is sent, all of it as in parameters.
std::vector<model::Parameter> sent_parameters(const model::Operation& operation) {
    std::vector<model::Parameter> sent;
    for (model::Parameter parameter : operation.parameters) {
        if (parameter.direction == Direction::out) continue;
        parameter.direction = Direction::in;
        sent.push_back(std::move(parameter));
    }
    return sent;
}

std::vector<std::string> declared_parameters(const model::Operation& operation, const Names& names,
                                             Context context) {
    std::vector<std::string> declared;
    for (const model::Parameter& parameter : sent_parameters(operation)) {
        declared.push_back(names.parameter(parameter, context));
        // It hides what it is called like from the ones behind it.
        context.hidden.push_back(identifier(parameter.name));
    }
    return declared;
}

/// "canorb::Future<float> sendp_speed(std::uint16_t channel) const", with `before` and `after`
/// around. `scope` is put before the name.
std::string future_signature(const model::Operation& operation, const Names& names,
                             const Context& result_context, const Context& context,
                             const std::string& before, const std::string& scope,
                             const std::string& after) {
    return wrap(before + future_type(operation, names, result_context) + ' ' + scope + "sendp_" +
                    names.asynchronous(operation) + '(',
                join(declared_parameters(operation, names, context), ", ") + ") const" + after);
}

std::string callback_signature(const model::Operation& operation, const Names& names,
                               Context context, const std::string& before, const std::string& scope,
                               const std::string& after) {
    const std::string callback = local_name("callback", operation);
    std::vector<std::string> parameters{future_type(operation, names, context) + "::Callback " +
                                        callback};
    context.hidden.push_back(callback);
    for (std::string& each : declared_parameters(operation, names, context)) {
        parameters.push_back(std::move(each));
    }
    return wrap(
        before + "canorb::PendingCall " + scope + "sendc_" + names.asynchronous(operation) + '(',
        join(parameters, ", ") + ") const" + after);
}

constexpr std::string_view definition_piece = R"(
$future$
    $return$
}
$callback$
    return this->sendp_$name$($values$).then(std::move($function$));
}
)";

std::string definition(const model::Definition& interface, const model::Operation& operation,
                       const Names& names) {
    const std::string class_name = names.own(interface);
    const std::string scope = class_name + "::";
    Context inside = in_stub(interface);
    std::vector<std::string> values;
    std::vector<std::string> arguments{
        "*this", class_name + "_operations::" + operation_constant(operation)};
    for (const model::Parameter& parameter : sent_parameters(operation)) {
        inside.hidden.push_back(identifier(parameter.name));
        values.push_back(identifier(parameter.name));
        arguments.push_back(coded(parameter.type, identifier(parameter.name)));
    }
    std::vector<std::string> returned;
    for (const model::Type* type : results_of(operation)) {
        returned.push_back(coded_type(*type, names.type(*type, inside)));
    }
    std::vector<std::string> raised;
    for (const model::Definition* exception : operation.raises) {
        raised.push_back(names.spell(*exception, inside));
    }
    const std::string exceptions =
        raised.empty() ? "" : ", canorb::Raises<" + join(raised, ", ") + '>';
    return fill(definition_piece,
                {{"future", future_signature(operation, names, beside(interface),
                                             in_stub(interface), "inline ", scope, " {")},
                 {"return", wrap("return canorb::send_request<canorb::Returns<" +
                                     join(returned, ", ") + '>' + exceptions + ">(",
                                 join(arguments, ", ") + ");")},
                 {"callback",
                  callback_signature(operation, names, in_stub(interface), "inline ", scope, " {")},
                 {"name", names.asynchronous(operation)},
                 {"values", join(values, ", ")},
                 {"function", local_name("callback", operation)}});
}

}  // namespace

std::string asynchronous_members(const model::Definition& interface, const Names& names) {
    const Context context = in_stub(interface);
    std::string text;
    for (const model::Operation& operation : body_of(interface).operations) {
        if (operation.oneway) continue;
        if (text.empty()) text = "\n// The same calls with a future, or with a callback.\n";
        text += future_signature(operation, names, context, context, "", "", ";\n") +
                callback_signature(operation, names, context, "", "", ";\n");
    }
    return indent(text);
}

std::string asynchronous_definitions(const model::Definition& interface, const Names& names) {
    std::string text;
    for (const model::Operation& operation : body_of(interface).operations) {
        if (operation.oneway) continue;
        text += (text.empty() ? "" : "\n") + definition(interface, operation, names);
    }
    return text;
}

}  // namespace canorb::idlc::emit
