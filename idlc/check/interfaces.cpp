#include <algorithm>
#include <map>
#include <utility>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

namespace {

/// 0xF8 and above are the ORB's own (doc/wire/giop.md).
constexpr unsigned highest_operation = 0xF7;

}  // namespace

Symbol* Checker::interface_symbol(const ast::Declaration& declaration, model::InterfaceKind kind,
                                  const Place& place) {
    const std::string& name = declaration.name.text;
    Symbol* known = place.scope.own(name);
    if (known != nullptr && known->name == name && known->definition != nullptr &&
        incomplete_.count(known->definition) != 0) {
        if (const auto* body = std::get_if<model::Interface>(&known->definition->body)) {
            if (body->kind == kind) return known;
            diagnostics_.error(declaration.name.where,
                               quote(name) +
                                   " is declared with another of 'local', 'abstract' and "
                                   "neither than before");
            diagnostics_.note(known->where, "previously declared here");
            return nullptr;
        }
    }
    Symbol* declared = declare_composite(declaration, model::Interface{kind, {}, {}, {}},
                                         Scope::Kind::interface, place);
    if (declared != nullptr) interface_scopes_.emplace(declared->definition, declared->scope);
    return declared;
}

void Checker::declare(const ast::Declaration& declaration, const ast::ForwardInterface& forward,
                      const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    const auto kind = static_cast<model::InterfaceKind>(forward.kind);
    const Symbol* known = place.scope.own(declaration.name.text);
    if (known != nullptr && known->name == declaration.name.text && known->definition != nullptr &&
        known->kind == Symbol::Kind::type) {
        const auto* body = std::get_if<model::Interface>(&known->definition->body);
        if (body != nullptr && body->kind == kind) return;  // said before, which is no error
    }
    const Symbol* symbol = interface_symbol(declaration, kind, place);
    if (symbol == nullptr) return;
    forward_.emplace_back(symbol->definition, declaration.name.where);
    new_definition(declaration, place).body = model::Forward{symbol->definition};
}

void Checker::declare(const ast::Declaration& declaration, const ast::Interface& interface,
                      const Place& place) {
    check_annotations(declaration.annotations, {"first_operation"}, place.scope);
    Symbol* symbol =
        interface_symbol(declaration, static_cast<model::InterfaceKind>(interface.kind), place);
    if (symbol == nullptr) return;
    symbol->where = declaration.name.where;
    open_composite(declaration, *symbol, place);
    model::Definition& definition = *symbol->definition;
    auto& body = std::get<model::Interface>(definition.body);
    bases(interface, *symbol->scope, body);
    check_inherited_names(declaration, body);
    Prefix prefix{prefix_inside(declaration, place)};
    this->body(interface, body, {*symbol->scope, &definition, body.definitions, prefix});
    // A local interface is never called by number.
    if (body.kind != model::InterfaceKind::local && check_inherited_ids(declaration, body)) {
        number_operations(declaration, *symbol->scope, body);
    }
    open_.erase(&definition);
    incomplete_.erase(&definition);
}

void Checker::bases(const ast::Interface& interface, Scope& scope, model::Interface& body) {
    for (const ast::ScopedName& name : interface.bases) {
        const Symbol* symbol = resolve(*scope.parent(), name, "interface", diagnostics_);
        if (symbol == nullptr) continue;
        const model::Definition* base = interface_of(*symbol);
        if (base == nullptr) {
            diagnostics_.error(name.where(), quote(symbol->name) + " is not an interface");
            diagnostics_.note(symbol->where, "declared here");
        } else if (incomplete_.count(base) != 0) {
            diagnostics_.error(name.where(),
                               quote(symbol->name) + " must be defined before it can be inherited");
            diagnostics_.note(symbol->where, "only declared here");
        } else if (std::find(body.bases.begin(), body.bases.end(), base) != body.bases.end()) {
            diagnostics_.error(name.where(), quote(symbol->name) + " is already a base");
        } else if (is_base_of_kind(name, *symbol, *base, body)) {
            body.bases.push_back(base);
            scope.add_base(*interface_scopes_.at(base));
        }
    }
}

const model::Definition* Checker::interface_of(const Symbol& symbol) const {
    if (symbol.definition == nullptr || symbol.kind != Symbol::Kind::type) return nullptr;
    model::Type type;
    type.kind = model::TypeKind::named;
    type.definition = symbol.definition;
    const model::Type& known = model::resolved(type);
    const bool is_interface = known.kind == model::TypeKind::named &&
                              std::holds_alternative<model::Interface>(known.definition->body);
    return is_interface ? known.definition : nullptr;
}

bool Checker::is_base_of_kind(const ast::ScopedName& name, const Symbol& symbol,
                              const model::Definition& base, const model::Interface& body) {
    const model::InterfaceKind kind = std::get<model::Interface>(base.body).kind;
    std::string problem;
    if (kind == model::InterfaceKind::local && body.kind != model::InterfaceKind::local) {
        problem = " is local: only local interfaces can inherit it";
    } else if (kind != model::InterfaceKind::abstract &&
               body.kind == model::InterfaceKind::abstract) {
        problem = " is not abstract: an abstract interface inherits only such";
    } else {
        return true;
    }
    diagnostics_.error(name.where(), quote(symbol.name) + problem);
    diagnostics_.note(symbol.where, "declared here");
    return false;
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
        add_obstacle(
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

void Checker::number_operations(const ast::Declaration& declaration, Scope& scope,
                                model::Interface& body) {
    std::map<unsigned, model::InheritedOperation> taken;
    for (const model::InheritedOperation& entry : model::inherited_operations(body)) {
        taken.emplace(entry.operation->id, entry);
    }
    const unsigned after_bases = taken.empty() ? 0 : taken.rbegin()->first + 1;
    unsigned id = annotation_number(declaration.annotations, "first_operation", 0,
                                    highest_operation, *scope.parent())
                      .value_or(after_bases);
    for (std::size_t i = 0; i < body.operations.size(); ++i, ++id) {
        model::Operation& operation = body.operations[i];
        if (id > highest_operation) {
            add_obstacle(operation_places_[i], quote(operation.name) + " would get operation id " +
                                                   std::to_string(id) + ", and the highest is " +
                                                   std::to_string(highest_operation));
            return;
        }
        const auto other = taken.find(id);
        if (other != taken.end()) {
            add_obstacle(operation_places_[i],
                         quote(operation.name) + " would get operation id " + std::to_string(id) +
                             ", which is that of the inherited " +
                             quote(model::scoped_name(*other->second.interface) +
                                   "::" + other->second.operation->name) +
                             "; @first_operation must be at least " + std::to_string(after_bases));
            return;
        }
        operation.id = static_cast<std::uint8_t>(id);
    }
}

}  // namespace canorb::idlc::check
