#include <algorithm>
#include <map>
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

std::string servant_name(const model::Definition& interface, const Names& names,
                         const Context& context) {
    return names.spell(interface, context) + "Servant";
}

constexpr std::string_view class_piece = R"(
// $place$
$comment$
class $name$Servant : $bases$ {
  public:
    const canorb::InterfaceInfo& _interface_info() const override { return $name$Interface; }
    void _dispatch(canorb::ServerCall& call) override;
$operations$};
)";

std::string servant_bases(const model::Definition& interface, const Names& names) {
    std::vector<std::string> bases;
    for (const model::Definition* base : body_of(interface).bases) {
        bases.push_back("public virtual " + servant_name(*base, names, beside(interface)));
    }
    return bases.empty() ? "public virtual canorb::Servant" : join(bases, ", ");
}

std::string servant_members(const model::Definition& interface, const Names& names) {
    const Context context = in_servant(interface);
    std::string text;
    for (const model::Operation& operation : body_of(interface).operations) {
        const std::string remark =
            place(operation.provenance) + raised_remark(operation, names, context);
        // A line between what has a comment and what is before it.
        if (text.empty() || !operation.comment.empty()) text += '\n';
        text +=
            comment(operation.comment) +
            remarked("virtual " + signature(operation, names, context, context) + " = 0;", remark);
    }
    return indent(text);
}

constexpr std::string_view dispatch_piece = R"(
void $name$Servant::_dispatch(canorb::ServerCall& $call$) {
    switch ($call$.operation()) {
        $cases$
        default:
            $inherited$
    }
}
)";

constexpr std::string_view no_operations_piece = R"(
void $name$Servant::_dispatch(canorb::ServerCall&) {}
)";

constexpr std::string_view only_inherited_piece = R"(
void $name$Servant::_dispatch(canorb::ServerCall& call) { $base$::_dispatch(call); }
)";

constexpr std::string_view case_piece = R"(
case $operation$.id: {
    $oneway$
    $locals$
    if (!$call$.read($arguments$)) return;
    $invoke$
    return;
}
)";

constexpr std::string_view try_piece = R"(
try {
    $invoke$
$handlers$
}
)";

/// What one case of the switch is made of.
struct Case {
    std::string locals;
    std::vector<std::string> read;       ///< in and inout, as they are decoded
    std::vector<std::string> arguments;  ///< all
    std::vector<std::string> results;    ///< result, inout and out, as they are encoded
};

/// One operation's part of _dispatch(), whose parameter is `call`.
class CaseWriter {
  public:
    CaseWriter(const model::Definition& interface, const model::Operation& operation,
               const Names& names, std::string call)
        : interface_(interface), operation_(operation), names_(names), call_(std::move(call)) {
        for (const model::Parameter& parameter : operation.parameters) {
            context_.hidden.push_back(identifier(parameter.name));
        }
    }

    std::string text() const {
        const Case parts = this->parts();
        const std::string constant =
            names_.own(interface_) + "_operations::" + operation_constant(operation_);
        return fill(case_piece, {{"operation", constant},
                                 {"oneway", operation_.oneway ? call_ + ".oneway();" : ""},
                                 {"locals", parts.locals},
                                 {"call", call_},
                                 {"arguments", join(parts.read, ", ")},
                                 {"invoke", invoke(parts)}});
    }

  private:
    Case parts() const {
        Case parts;
        if (operation_.result) {
            parts.results.push_back(coded(*operation_.result, local_name("result", operation_)));
        }
        // A local hides what it is called like from the ones behind it.
        Context context = in_servant(interface_);
        for (const model::Parameter& parameter : operation_.parameters) {
            const std::string name = identifier(parameter.name);
            const std::string value = coded(parameter.type, name);
            parts.locals += names_.variable(parameter.type, name, context) + '\n';
            context.hidden.push_back(name);
            parts.arguments.push_back(name);
            if (parameter.direction != Direction::out) parts.read.push_back(value);
            if (parameter.direction != Direction::in) parts.results.push_back(value);
        }
        return parts;
    }

    std::string invoke(const Case& parts) const {
        const std::string name = identifier(operation_.name);
        const std::string result = local_name("result", operation_);
        const auto& locals = context_.hidden;
        const bool hidden = name == call_ || name == result ||
                            std::find(locals.begin(), locals.end(), name) != locals.end();
        std::string statement =
            (hidden ? "this->" : "") + name + '(' + join(parts.arguments, ", ") + ");\n";
        if (operation_.result) {
            statement = "const " + names_.type(*operation_.result, context_) + ' ' + result +
                        " = " + statement;
        }
        if (!operation_.oneway) {
            statement += call_ + ".reply(" + join(parts.results, ", ") + ");\n";
        }
        return operation_.raises.empty() ? statement : with_handlers(statement);
    }

    std::string with_handlers(const std::string& statement) const {
        const std::string exception = local_name("exception", operation_);
        std::string handlers;
        for (const model::Definition* raised : operation_.raises) {
            handlers += "} catch (const " + names_.spell(*raised, context_) + "& " + exception +
                        ") {\n    " + call_ + ".raise(" + exception + ");\n";
        }
        return fill(try_piece, {{"invoke", statement}, {"handlers", handlers}});
    }

    const model::Definition& interface_;
    const model::Operation& operation_;
    const Names& names_;
    std::string call_;
    Context context_ = in_servant(interface_);  ///< with all locals
};

/// The ids that an interface answers, inherited ones included, with the operation's full name.
std::map<unsigned, std::string> answered(const model::Definition& interface) {
    std::map<unsigned, std::string> ids;
    const model::Interface& body = body_of(interface);
    for (const model::InheritedOperation& entry : model::inherited_operations(body)) {
        ids.emplace(entry.operation->id, model::scoped_name(*entry.interface) +
                                             "::" + model::wire_name(*entry.operation));
    }
    for (const model::Operation& own : body.operations) {
        ids.emplace(own.id, model::scoped_name(interface) + "::" + model::wire_name(own));
    }
    return ids;
}

/// With several bases: the cases that pass each base its operations.
std::string inherited_cases(const model::Definition& interface, const Names& names,
                            const std::string& call) {
    const model::Interface& body = body_of(interface);
    if (body.bases.size() < 2) return {};
    std::map<unsigned, std::string> handled;
    std::string text;
    for (const model::Definition* base : body.bases) {
        std::string labels;
        for (const auto& [id, name] : answered(*base)) {
            if (!handled.emplace(id, name).second) continue;
            labels += "case " + std::to_string(id) + ":  // " + name + '\n';
        }
        if (labels.empty()) continue;
        text += labels + "    " + servant_name(*base, names, in_servant(interface)) +
                "::_dispatch(" + call + ");\n    return;\n";
    }
    return text;
}

}  // namespace

std::string servant_declaration(const model::Definition& interface, const Names& names) {
    return fill(class_piece, {{"place", place(interface.provenance)},
                              {"comment", comment(interface.comment)},
                              {"name", names.own(interface)},
                              {"bases", servant_bases(interface, names)},
                              {"operations", servant_members(interface, names)}});
}

std::string servant_definition(const model::Definition& interface, const Names& names) {
    const std::string name = names.own(interface);
    const model::Interface& body = body_of(interface);
    const std::string base = body.bases.size() == 1
                                 ? servant_name(*body.bases.front(), names, in_servant(interface))
                                 : "";
    std::string call = "call";
    for (const model::Operation& operation : body.operations) {
        if (local_name(call, operation) != call) call = local_name(call, operation);
    }
    std::string cases;
    for (const model::Operation& operation : body.operations) {
        cases += CaseWriter{interface, operation, names, call}.text();
    }
    cases += inherited_cases(interface, names, call);
    if (cases.empty() && !base.empty()) {
        return fill(only_inherited_piece, {{"name", name}, {"base", base}});
    }
    if (cases.empty()) return fill(no_operations_piece, {{"name", name}});
    return fill(dispatch_piece,
                {{"name", name},
                 {"call", call},
                 {"cases", cases},
                 {"inherited", base.empty() ? "return;" : base + "::_dispatch(" + call + ");"}});
}

}  // namespace canorb::idlc::emit
