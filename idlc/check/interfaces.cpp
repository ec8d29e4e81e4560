#include <algorithm>
#include <map>
#include <utility>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

namespace {

/// 0xF8 and above are the ORB's own (doc/wire/giop.md).
constexpr unsigned highest_operation = 0xF7;

}  // namespace

Symbol* Checker::interface_symbol(const ast::Declaration& declaration, const Place& place) {
    const std::string& name = declaration.name.text;
    Symbol* known = place.scope.own(name);
    if (known != nullptr && known->name == name && known->definition != nullptr &&
        incomplete_.count(known->definition) != 0 &&
        std::holds_alternative<model::Interface>(known->definition->body)) {
        return known;
    }
    Symbol symbol;
    symbol.name = name;
    symbol.where = declaration.name.where;
    symbol.kind = Symbol::Kind::type;
    Symbol* declared = place.scope.declare(std::move(symbol), diagnostics_);
    if (declared == nullptr) return nullptr;
    // The definition joins the list of its module when the interface itself is there.
    Definitions nowhere;
    declared->definition = &new_definition(declaration, {place.scope, place.parent, nowhere});
    declared->definition->body = model::Interface{};
    declared->scope = &new_scope(Scope::Kind::interface, &place.scope, name);
    incomplete_.insert(declared->definition);
    return declared;
}

void Checker::declare(const ast::Declaration& declaration, const ast::ForwardInterface&,
                      const Place& place) {
    const Symbol* known = place.scope.own(declaration.name.text);
    if (known != nullptr && known->name == declaration.name.text && known->definition != nullptr &&
        known->kind == Symbol::Kind::type &&
        std::holds_alternative<model::Interface>(known->definition->body)) {
        return;  // said before, which is no error
    }
    const Symbol* symbol = interface_symbol(declaration, place);
    if (symbol == nullptr) return;
    forward_.emplace_back(symbol->definition, declaration.name.where);
    new_definition(declaration, place).body = model::ForwardInterface{symbol->definition};
}

void Checker::declare(const ast::Declaration& declaration, const ast::Interface& interface,
                      const Place& place) {
    ignore_annotations(declaration, "first_operation");
    Symbol* symbol = interface_symbol(declaration, place);
    if (symbol == nullptr) return;
    symbol->where = declaration.name.where;
    model::Definition& definition = *symbol->definition;
    // It may have been declared in another opening of its module, or in an included file.
    definition.parent = place.parent;
    definition.provenance = provenance(declaration.name.where);
    definition.comment = declaration.comment;
    definition.in_main_file = source_.in_main_file(declaration.name.where);
    place.definitions.push_back(&definition);

    auto& body = std::get<model::Interface>(definition.body);
    bases(interface, *symbol->scope, body);
    check_inherited_names(declaration, body);
    this->body(interface, *symbol->scope, definition);
    if (check_inherited_ids(declaration, body)) {
        number_operations(declaration, *symbol->scope, body);
    }
    incomplete_.erase(&definition);
}

void Checker::bases(const ast::Interface& interface, Scope& scope, model::Interface& body) {
    for (const ast::ScopedName& name : interface.bases) {
        const Symbol* symbol = resolve(*scope.parent(), name, "interface", diagnostics_);
        if (symbol == nullptr) continue;
        if (symbol->definition == nullptr || symbol->kind != Symbol::Kind::type ||
            !std::holds_alternative<model::Interface>(symbol->definition->body)) {
            diagnostics_.error(name.where(), quote(symbol->name) + " is not an interface");
            diagnostics_.note(symbol->where, "declared here");
        } else if (incomplete_.count(symbol->definition) != 0) {
            diagnostics_.error(name.where(),
                               quote(symbol->name) + " must be defined before it can be inherited");
            diagnostics_.note(symbol->where, "only declared here");
        } else if (std::find(body.bases.begin(), body.bases.end(), symbol->definition) !=
                   body.bases.end()) {
            diagnostics_.error(name.where(), quote(symbol->name) + " is already a base");
        } else {
            body.bases.push_back(symbol->definition);
            scope.add_base(*symbol->scope);
        }
    }
}

void Checker::check_inherited_names(const ast::Declaration& declaration,
                                    const model::Interface& body) {
    std::map<std::string, model::InheritedOperation> seen;
    for (const model::InheritedOperation& entry : model::inherited_operations(body)) {
        const auto [at, fresh] = seen.emplace(lower_case(entry.operation->name), entry);
        if (fresh || at->second.interface == entry.interface) continue;
        diagnostics_.error(declaration.name.where,
                           quote(declaration.name.text) + " inherits two operations called " +
                               quote(entry.operation->name) + ", from " +
                               quote(model::scoped_name(*at->second.interface)) + " and " +
                               quote(model::scoped_name(*entry.interface)));
    }
}

bool Checker::check_inherited_ids(const ast::Declaration& declaration,
                                  const model::Interface& body) {
    std::map<unsigned, model::InheritedOperation> seen;
    for (const model::InheritedOperation& entry : model::inherited_operations(body)) {
        const auto [at, fresh] = seen.emplace(entry.operation->id, entry);
        if (fresh) continue;
        // Numbers above all that the first has, or inherits, are free for the second.
        const model::Definition& first = *at->second.interface;
        const auto& first_body = std::get<model::Interface>(first.body);
        unsigned free = 0;
        for (const model::Operation& own : first_body.operations) {
            free = std::max<unsigned>(free, own.id + 1U);
        }
        for (const model::InheritedOperation& inherited : model::inherited_operations(first_body)) {
            free = std::max<unsigned>(free, inherited.operation->id + 1U);
        }
        diagnostics_.error(
            declaration.name.where,
            "the bases of " + quote(declaration.name.text) + " both use operation id " +
                std::to_string(entry.operation->id) + ": " +
                quote(model::scoped_name(first) + "::" + at->second.operation->name) + " and " +
                quote(model::scoped_name(*entry.interface) + "::" + entry.operation->name) +
                "; write @first_operation(" + std::to_string(free) + ") before interface " +
                quote(model::scoped_name(*entry.interface)));
        return false;
    }
    return true;
}

void Checker::body(const ast::Interface& interface, Scope& scope, model::Definition& definition) {
    auto& body = std::get<model::Interface>(definition.body);
    operation_places_.clear();
    for (const ast::Declaration& member : interface.body) {
        if (diagnostics_.full()) return;
        ignore_annotations(member);
        if (const auto* operation = std::get_if<ast::Operation>(&member.body)) {
            this->operation(member, *operation, scope, body);
        } else if (const auto* attribute = std::get_if<ast::Attribute>(&member.body)) {
            this->attribute(member, *attribute, scope, body);
        } else {
            const Place place{scope, &definition, body.definitions};
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

void Checker::operation(const ast::Declaration& declaration, const ast::Operation& operation,
                        Scope& scope, model::Interface& body) {
    if (operation.oneway) check_oneway(declaration, operation);
    model::Operation checked;
    checked.name = declaration.name.text;
    checked.oneway = operation.oneway;
    checked.provenance = provenance(declaration.name.where);
    checked.comment = declaration.comment;
    if (operation.result) {
        checked.result = type(*operation.result, scope);
    }
    Scope& parameters = new_scope(Scope::Kind::members, &scope, "");
    for (const ast::Parameter& parameter : operation.parameters) {
        const std::optional<model::Type> type = this->type(parameter.type, parameters);
        // Names used as types in the parameter list are used in the interface as well.
        if (parameter.type.kind == ast::TypeKind::name && !parameter.type.name.global) {
            const ast::Identifier& used = parameter.type.name.parts.front();
            scope.use(used.text, used.where);
        }
        Symbol symbol;
        symbol.name = parameter.name.text;
        symbol.where = parameter.name.where;
        parameters.declare(std::move(symbol), diagnostics_);
        if (!type) continue;
        checked.parameters.push_back(
            {static_cast<model::Direction>(parameter.direction), *type, parameter.name.text});
    }
    checked.raises = raises(operation.raises, scope);
    declare_operation(declaration, scope);
    body.operations.push_back(std::move(checked));
    operation_places_.push_back(declaration.name.where);
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
    const std::optional<model::Type> type = this->type(attribute.type, scope);
    model::Operation get;
    get.kind = model::OperationKind::get;
    get.name = declaration.name.text;
    get.provenance = provenance(declaration.name.where);
    get.comment = declaration.comment;
    get.raises = raises(attribute.get_raises, scope);
    get.result = type;
    model::Operation set = get;
    set.kind = model::OperationKind::set;
    set.result.reset();
    set.raises = raises(attribute.set_raises, scope);
    if (type) set.parameters.push_back({model::Direction::in, *type, "value"});

    declare_operation(declaration, scope);
    body.operations.push_back(std::move(get));
    operation_places_.push_back(declaration.name.where);
    if (attribute.readonly) return;
    body.operations.push_back(std::move(set));
    operation_places_.push_back(declaration.name.where);
}

std::vector<const model::Definition*> Checker::raises(const std::vector<ast::ScopedName>& names,
                                                      Scope& scope) {
    Definitions exceptions;
    for (const ast::ScopedName& name : names) {
        const Symbol* symbol = resolve(scope, name, "exception", diagnostics_);
        if (symbol == nullptr) continue;
        if (symbol->kind != Symbol::Kind::exception) {
            diagnostics_.error(name.where(), quote(symbol->name) + " is not an exception");
            diagnostics_.note(symbol->where, "declared here");
        } else if (std::find(exceptions.begin(), exceptions.end(), symbol->definition) !=
                   exceptions.end()) {
            diagnostics_.error(name.where(), quote(symbol->name) + " is already in this clause");
        } else {
            exceptions.push_back(symbol->definition);
        }
    }
    return exceptions;
}

std::optional<unsigned> Checker::first_operation(const ast::Declaration& declaration,
                                                 Scope& scope) {
    std::optional<unsigned> first;
    for (const ast::Annotation& annotation : declaration.annotations) {
        if (annotation.name.text != "first_operation") continue;
        if (annotation.arguments.size() != 1 || first) {
            diagnostics_.error(annotation.name.where,
                               "@first_operation is written once, with one number");
            continue;
        }
        model::Type type;
        type.kind = model::TypeKind::uint32;
        const auto value = this->value(annotation.arguments.front(), type, *scope.parent());
        if (!value) continue;
        const std::uint64_t number = std::get<std::uint64_t>(*value);
        if (number > highest_operation) {
            diagnostics_.error(annotation.arguments.front().where,
                               "operation ids are at most " + std::to_string(highest_operation));
            continue;
        }
        first = static_cast<unsigned>(number);
    }
    return first;
}

void Checker::number_operations(const ast::Declaration& declaration, Scope& scope,
                                model::Interface& body) {
    std::map<unsigned, model::InheritedOperation> taken;
    for (const model::InheritedOperation& entry : model::inherited_operations(body)) {
        taken.emplace(entry.operation->id, entry);
    }
    const unsigned after_bases = taken.empty() ? 0 : taken.rbegin()->first + 1;
    unsigned id = first_operation(declaration, scope).value_or(after_bases);
    for (std::size_t i = 0; i < body.operations.size(); ++i, ++id) {
        model::Operation& operation = body.operations[i];
        if (id > highest_operation) {
            diagnostics_.error(operation_places_[i],
                               quote(operation.name) + " would get operation id " +
                                   std::to_string(id) + ", and the highest is " +
                                   std::to_string(highest_operation));
            return;
        }
        const auto other = taken.find(id);
        if (other != taken.end()) {
            diagnostics_.error(operation_places_[i],
                               quote(operation.name) + " would get operation id " +
                                   std::to_string(id) + ", which is that of the inherited " +
                                   quote(model::scoped_name(*other->second.interface) +
                                         "::" + other->second.operation->name) +
                                   "; @first_operation must be at least " +
                                   std::to_string(after_bases));
            return;
        }
        operation.id = static_cast<std::uint8_t>(id);
    }
}

}  // namespace canorb::idlc::check
