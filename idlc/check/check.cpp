#include "idlc/check/check.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

model::Model build_model(const ast::File& file, const Source& source, Diagnostics& diagnostics) {
    return Checker{source, diagnostics}.run(file);
}

Checker::Checker(const Source& source, Diagnostics& diagnostics)
    : source_(source), diagnostics_(diagnostics) {
    model_.main_file = source.main_file();
    model_.includes = source.includes();
}

model::Model Checker::run(const ast::File& file) {
    Scope& global = new_scope(Scope::Kind::module, nullptr, "");
    declarations(file.declarations, {global, nullptr, model_.definitions});
    check_interfaces_defined();
    check_waits();
    check_generated_names();
    return std::move(model_);
}

void Checker::declarations(const std::vector<ast::Declaration>& list, const Place& place) {
    for (const ast::Declaration& declaration : list) {
        if (diagnostics_.full()) return;
        if (!std::holds_alternative<ast::Interface>(declaration.body)) {
            ignore_annotations(declaration);
        }
        std::visit([&](const auto& body) { declare(declaration, body, place); }, declaration.body);
    }
}

void Checker::declare(const ast::Declaration& declaration, const ast::Module& module,
                      const Place& place) {
    Symbol* symbol = place.scope.own(declaration.name.text);
    if (symbol == nullptr || symbol->kind != Symbol::Kind::module ||
        symbol->name != declaration.name.text) {
        Symbol opened;
        opened.name = declaration.name.text;
        opened.where = declaration.name.where;
        opened.kind = Symbol::Kind::module;
        symbol = place.scope.declare(std::move(opened), diagnostics_);
        if (symbol == nullptr) return;
        symbol->scope = &new_scope(Scope::Kind::module, &place.scope, declaration.name.text);
    }
    // Each opening of a module is a definition of its own: the order of the file is kept.
    model::Definition& definition = new_definition(declaration, place);
    if (symbol->definition == nullptr) symbol->definition = &definition;
    declarations(module.declarations, {*symbol->scope, &definition,
                                       definition.body.emplace<model::Module>().definitions});
}

void Checker::declare(const ast::Declaration& declaration, const ast::Constant& constant,
                      const Place& place) {
    const std::optional<model::Type> type = this->type(constant.type, place.scope);
    std::optional<model::Value> value;
    if (type) value = this->value(constant.value, model::resolved(*type), place.scope);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::constant, place);
    if (definition == nullptr || !value) return;
    definition->body = model::Constant{*type, *value};
}

void Checker::declare(const ast::Declaration& declaration, const ast::Enum& enumeration,
                      const Place& place) {
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition == nullptr) return;
    model::Enum body;
    for (const ast::Enumerator& enumerator : enumeration.enumerators) {
        // An enumerator's name belongs to the scope around the enum.
        Symbol symbol;
        symbol.name = enumerator.name.text;
        symbol.where = enumerator.name.where;
        symbol.kind = Symbol::Kind::enumerator;
        symbol.definition = definition;
        symbol.enumerator = body.enumerators.size();
        place.scope.declare(std::move(symbol), diagnostics_);
        body.enumerators.push_back({enumerator.name.text, enumerator.comment});
    }
    definition->body = std::move(body);
}

void Checker::declare(const ast::Declaration& declaration, const ast::Struct& structure,
                      const Place& place) {
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition == nullptr) return;
    definition->body = model::Struct{};
    incomplete_.insert(definition);
    std::vector<model::Member> list = members(structure.members, place.scope, *definition);
    incomplete_.erase(definition);
    definition->body = model::Struct{std::move(list)};
}

void Checker::declare(const ast::Declaration& declaration, const ast::Exception& exception,
                      const Place& place) {
    model::Definition* definition = declare_name(declaration, Symbol::Kind::exception, place);
    if (definition == nullptr) return;
    definition->body = model::Exception{members(exception.members, place.scope, *definition)};
}

void Checker::declare(const ast::Declaration& declaration, const ast::Alias& alias,
                      const Place& place) {
    std::optional<model::Type> type = this->type(alias.type, place.scope);
    if (type) type = array(*std::move(type), alias.dimensions, place.scope);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition == nullptr) return;
    // What has no type of its own stands for something, so that its uses are not reported too.
    definition->body = model::Alias{type.value_or(model::Type{})};
}

std::vector<model::Member> Checker::members(const std::vector<ast::Member>& list, Scope& around,
                                            const model::Definition& owner) {
    Scope& scope = new_scope(Scope::Kind::members, &around, owner.name);
    std::vector<model::Member> members;
    for (const ast::Member& member : list) {
        std::optional<model::Type> type = this->type(member.type, scope);
        if (type) type = array(*std::move(type), member.dimensions, scope);
        if (type) require_complete(*type, member.type.where, owner);
        Symbol symbol;
        symbol.name = member.name.text;
        symbol.where = member.name.where;
        scope.declare(std::move(symbol), diagnostics_);
        if (type) members.push_back({*std::move(type), member.name.text, member.comment});
    }
    return members;
}

void Checker::check_interfaces_defined() {
    for (const auto& [definition, where] : forward_) {
        if (incomplete_.count(definition) == 0) continue;
        diagnostics_.error(where, "the interface " + quote(definition->name) +
                                      " is declared, but not defined in this file or in one that "
                                      "it includes");
    }
}

void Checker::check_generated_names() {
    for (const Scope& scope : scopes_) {
        if (scope.kind() != Scope::Kind::interface) continue;
        for (const std::string_view suffix : model::generated_suffixes) {
            const std::string name = scope.name() + std::string{suffix};
            const Symbol* symbol = scope.parent()->own(name);
            if (symbol == nullptr || symbol->name != name) continue;
            diagnostics_.error(symbol->where, quote(name) +
                                                  " is needed for what is generated for "
                                                  "the interface " +
                                                  quote(scope.name()));
        }
    }
}

model::Definition& Checker::new_definition(const ast::Declaration& declaration,
                                           const Place& place) {
    model_.storage.push_back(std::make_unique<model::Definition>());
    model::Definition& definition = *model_.storage.back();
    definition.name = declaration.name.text;
    definition.parent = place.parent;
    definition.repository_id = model::scoped_name(definition);
    for (std::size_t at = 0; (at = definition.repository_id.find("::", at)) != std::string::npos;) {
        definition.repository_id.replace(at, 2, "/");
    }
    definition.repository_id = "IDL:" + definition.repository_id + ":1.0";
    definition.provenance = provenance(declaration.name.where);
    definition.comment = declaration.comment;
    definition.in_main_file = source_.in_main_file(declaration.name.where);
    place.definitions.push_back(&definition);
    return definition;
}

model::Definition* Checker::declare_name(const ast::Declaration& declaration, Symbol::Kind kind,
                                         const Place& place) {
    Symbol symbol;
    symbol.name = declaration.name.text;
    symbol.where = declaration.name.where;
    symbol.kind = kind;
    Symbol* declared = place.scope.declare(std::move(symbol), diagnostics_);
    if (declared == nullptr) return nullptr;
    declared->definition = &new_definition(declaration, place);
    return declared->definition;
}

Scope& Checker::new_scope(Scope::Kind kind, Scope* parent, const std::string& name) {
    return scopes_.emplace_back(kind, parent, name);
}

model::Provenance Checker::provenance(Location where) const {
    const Position position = source_.position(where);
    return {position.file, position.line};
}

void Checker::ignore_annotations(const ast::Declaration& declaration, std::string_view known) {
    for (const ast::Annotation& annotation : declaration.annotations) {
        if (annotation.name.text == known) continue;
        if (annotation.name.text == "first_operation") {
            diagnostics_.error(annotation.name.where,
                               "@first_operation belongs before the definition of an interface");
        } else {
            diagnostics_.warning(annotation.name.where,
                                 "the annotation @" + annotation.name.text + " is ignored");
        }
    }
}

}  // namespace canorb::idlc::check
