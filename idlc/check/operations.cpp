#include <algorithm>
#include <utility>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

namespace {

/// Whether a value of the exception cannot be sent.
bool is_local_exception(const model::Definition& exception) {
    const auto* body = std::get_if<model::Exception>(&exception.body);
    return body != nullptr &&
           std::any_of(body->members.begin(), body->members.end(),
                       [](const model::Member& member) { return model::is_local(member.type); });
}

}  // namespace

void Checker::body(const ast::Interface& interface, model::Interface& body, const Place& place) {
    operation_places_.clear();
    for (const ast::Declaration& member : interface.body) place.scope.expect(member.name);
    for (const ast::Declaration& member : interface.body) {
        if (diagnostics_.full()) return;
        if (const auto* operation = std::get_if<ast::Operation>(&member.body)) {
            this->operation(member, *operation, place.scope, body);
        } else if (const auto* attribute = std::get_if<ast::Attribute>(&member.body)) {
            this->attribute(member, *attribute, place.scope, body);
        } else {
            std::visit([&](const auto& what) { declare(member, what, place); }, member.body);
        }
    }
}

void Checker::declare_operation(const ast::Declaration& declaration, Scope& scope) {
    for (const Symbol* inherited : scope.visible(declaration.name.text)) {
        if (inherited->kind != Symbol::Kind::operation || scope.own(declaration.name.text))
            continue;
        diagnostics_.error(declaration.name.where,
                           quote(declaration.name.text) +
                               " is already an operation or attribute of a base interface");
        diagnostics_.note(inherited->where, "previously declared here");
        return;
    }
    Symbol symbol;
    symbol.name = declaration.name.text;
    symbol.where = declaration.name.where;
    symbol.kind = Symbol::Kind::operation;
    scope.declare(std::move(symbol), diagnostics_);
}

void Checker::check_hides_no_operation(const ast::Declaration& declaration, const Scope& scope) {
    if (scope.kind() != Scope::Kind::interface || scope.own(declaration.name.text) != nullptr) {
        return;
    }
    for (const Symbol* inherited : scope.visible(declaration.name.text)) {
        if (inherited->kind != Symbol::Kind::operation) continue;
        diagnostics_.error(declaration.name.where,
                           quote(declaration.name.text) +
                               (inherited->name == declaration.name.text
                                    ? " is already an operation or attribute of a base interface"
                                    : " differs only in case from the inherited operation " +
                                          quote(inherited->name)));
        diagnostics_.note(inherited->where, "previously declared here");
    }
}

std::optional<model::Type> Checker::operation_type(const ast::Type& written, bool local,
                                                   Scope& scope) {
    if (written.kind == ast::TypeKind::sequence || written.kind == ast::TypeKind::map ||
        (written.kind == ast::TypeKind::fixed && written.bound)) {
        diagnostics_.error(written.where,
                           "a type of an operation or attribute has a name: give this one a name "
                           "with typedef");
        return std::nullopt;
    }
    std::optional<model::Type> type = this->type(written, scope);
    if (!type || !require_complete(*type, written.where)) return std::nullopt;
    if (!local && model::is_local(*type)) {
        diagnostics_.error(written.where,
                           "a value of a local interface cannot be sent: only operations of local "
                           "interfaces can have it");
    }
    return type;
}

void Checker::operation(const ast::Declaration& declaration, const ast::Operation& operation,
                        Scope& scope, model::Interface& body) {
    check_annotations(declaration.annotations, {"oneway"}, scope);
    const bool local = body.kind == model::InterfaceKind::local;
    const bool oneway = operation.oneway || annotation_flag(declaration.annotations, "oneway");
    if (oneway) check_oneway(declaration, operation);
    model::Operation checked;
    checked.name = declaration.name.text;
    checked.oneway = oneway;
    checked.provenance = provenance(declaration.name.where);
    checked.comment = declaration.comment;
    if (operation.result) checked.result = operation_type(*operation.result, local, scope);
    parameters(operation, local, scope, checked);
    checked.raises = raises(operation.raises, local, scope);
    declare_operation(declaration, scope);
    body.operations.push_back(std::move(checked));
    operation_places_.push_back(declaration.name.where);
}

void Checker::parameters(const ast::Operation& operation, bool local, Scope& scope,
                         model::Operation& checked) {
    Scope& parameters = new_scope(Scope::Kind::members, &scope, "");
    for (const ast::Parameter& parameter : operation.parameters) {
        check_annotations(parameter.annotations, {}, scope);
        const std::optional<model::Type> type = operation_type(parameter.type, local, parameters);
        // Names used as types in the parameter list are used in the interface as well.
        if (parameter.type.kind == ast::TypeKind::name && !parameter.type.name.global) {
            scope.use(parameter.type.name.parts.front());
        }
        Symbol symbol;
        symbol.name = parameter.name.text;
        symbol.where = parameter.name.where;
        parameters.declare(std::move(symbol), diagnostics_);
        if (!type) continue;
        checked.parameters.push_back(
            {static_cast<model::Direction>(parameter.direction), *type, parameter.name.text});
    }
}

void Checker::check_oneway(const ast::Declaration& declaration, const ast::Operation& operation) {
    const std::string name = "the oneway operation " + quote(declaration.name.text);
    if (operation.result) {
        diagnostics_.error(operation.result->where, name + " cannot have a result");
    }
    for (const ast::Parameter& parameter : operation.parameters) {
        if (parameter.direction == ast::Direction::in) continue;
        diagnostics_.error(parameter.name.where, name + " can have 'in' parameters only");
    }
    if (!operation.raises.empty()) {
        diagnostics_.error(operation.raises.front().where(), name + " cannot raise exceptions");
    }
}

void Checker::attribute(const ast::Declaration& declaration, const ast::Attribute& attribute,
                        Scope& scope, model::Interface& body) {
    check_annotations(declaration.annotations, {}, scope);
    const bool local = body.kind == model::InterfaceKind::local;
    const std::optional<model::Type> type = operation_type(attribute.type, local, scope);
    model::Operation get;
    get.kind = model::OperationKind::get;
    get.name = declaration.name.text;
    get.provenance = provenance(declaration.name.where);
    get.comment = declaration.comment;
    get.raises = raises(attribute.get_raises, local, scope);
    get.result = type;
    model::Operation set = get;
    set.kind = model::OperationKind::set;
    set.result.reset();
    set.raises = raises(attribute.set_raises, local, scope);
    if (type) set.parameters.push_back({model::Direction::in, *type, "value"});

    declare_operation(declaration, scope);
    body.operations.push_back(std::move(get));
    operation_places_.push_back(declaration.name.where);
    if (attribute.readonly) return;
    body.operations.push_back(std::move(set));
    operation_places_.push_back(declaration.name.where);
}

model::Definitions Checker::raises(const std::vector<ast::ScopedName>& names, bool local,
                                   const Scope& scope) {
    Definitions exceptions;
    for (const ast::ScopedName& name : names) {
        const Symbol* symbol = resolve(scope, name, "exception", diagnostics_);
        if (symbol == nullptr || (symbol->kind == Symbol::Kind::exception && !symbol->definition)) {
            continue;
        }
        if (symbol->kind != Symbol::Kind::exception) {
            diagnostics_.error(name.where(), quote(symbol->name) + " is not an exception");
            diagnostics_.note(symbol->where, "declared here");
        } else if (std::find(exceptions.begin(), exceptions.end(), symbol->definition) !=
                   exceptions.end()) {
            diagnostics_.warning(name.where(), quote(symbol->name) + " is already in this clause");
        } else {
            if (!local && is_local_exception(*symbol->definition)) {
                diagnostics_.error(
                    name.where(),
                    quote(symbol->name) + " has a member of a local interface and cannot be sent");
            }
            exceptions.push_back(symbol->definition);
        }
    }
    return exceptions;
}

}  // namespace canorb::idlc::check
