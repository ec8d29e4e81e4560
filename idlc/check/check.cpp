#include "idlc/check/check.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

namespace {

constexpr unsigned most_flags = 64;
constexpr unsigned most_enum_bits = 32;

model::Type unsigned_long() {
    model::Type type;
    type.kind = model::TypeKind::uint32;
    return type;
}

}  // namespace

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
    Prefix prefix;
    declarations(file.declarations, {global, nullptr, model_.definitions, prefix});
    check_interfaces_defined();
    check_structs_defined();
    check_generated_names();
    return std::move(model_);
}

void Checker::declarations(const std::vector<ast::Declaration>& list, const Place& place) {
    for (const ast::Declaration& declaration : list) place.scope.expect(declaration.name);
    for (const ast::Declaration& declaration : list) {
        if (diagnostics_.full()) return;
        std::visit([&](const auto& body) { declare(declaration, body, place); }, declaration.body);
    }
}

void Checker::declare(const ast::Declaration& declaration, const ast::Module& module,
                      const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
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
    Prefix prefix{prefix_inside(declaration, place)};
    declarations(module.declarations,
                 {*symbol->scope, &definition, definition.body.emplace<model::Module>().definitions,
                  prefix});
}

void Checker::declare(const ast::Declaration& declaration, const ast::Constant& constant,
                      const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    std::optional<model::Type> type = this->type(constant.type, place.scope);
    std::optional<model::Value> value;
    if (type) value = this->value(constant.value, *type, place.scope);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::constant, place);
    if (definition == nullptr || !value) return;
    if (const auto* fixed = std::get_if<model::FixedValue>(&*value)) {
        // The value alone says how many digits a fixed constant has.
        type->kind = model::TypeKind::fixed;
        type->digits = fixed->digits();
        type->scale = fixed->scale();
    }
    definition->body = model::Constant{*type, *value};
}

void Checker::declare(const ast::Declaration& declaration, const ast::Enum& enumeration,
                      const Place& place) {
    check_annotations(declaration.annotations, {"bit_bound"}, place.scope);
    const unsigned bits =
        annotation_number(declaration.annotations, "bit_bound", 1, most_enum_bits, place.scope)
            .value_or(most_enum_bits);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition == nullptr) return;
    model::Enum body;
    std::map<std::uint32_t, std::string> numbers;
    std::uint64_t next = 0;
    bool has_default = false;
    for (const ast::Enumerator& enumerator : enumeration.enumerators) {
        check_annotations(enumerator.annotations, {"value", "default_literal"}, place.scope);
        // An enumerator's name belongs to the scope around the enum.
        Symbol symbol;
        symbol.name = enumerator.name.text;
        symbol.where = enumerator.name.where;
        symbol.kind = Symbol::Kind::enumerator;
        symbol.definition = definition;
        symbol.enumerator = body.enumerators.size();
        place.scope.declare(std::move(symbol), diagnostics_);
        if (annotation_flag(enumerator.annotations, "default_literal")) {
            if (has_default) {
                diagnostics_.error(enumerator.name.where, "an enum has one @default_literal");
            }
            has_default = true;
            body.default_index = body.enumerators.size();
        }
        const auto given =
            annotation_value(enumerator.annotations, "value", unsigned_long(), place.scope);
        if (given) next = std::get<std::uint64_t>(*given);
        if (next >> bits != 0) {
            diagnostics_.error(enumerator.name.where, quote(enumerator.name.text) + " is number " +
                                                          std::to_string(next) +
                                                          ", which does not fit into the enum's " +
                                                          std::to_string(bits) + " bits");
        }
        const auto number = static_cast<std::uint32_t>(next++);
        const auto [at, fresh] = numbers.emplace(number, enumerator.name.text);
        if (!fresh) {
            diagnostics_.error(enumerator.name.where, quote(enumerator.name.text) + " and " +
                                                          quote(at->second) + " are both number " +
                                                          std::to_string(number));
        }
        body.enumerators.push_back({enumerator.name.text, number, enumerator.comment});
    }
    definition->body = std::move(body);
}

void Checker::declare(const ast::Declaration& declaration, const ast::Bitmask& bitmask,
                      const Place& place) {
    check_annotations(declaration.annotations, {"bit_bound"}, place.scope);
    const unsigned bits =
        annotation_number(declaration.annotations, "bit_bound", 1, most_flags, place.scope)
            .value_or(32);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition == nullptr) return;
    // Unlike an enum's, the names of flags are in a scope of their own.
    Scope& scope = new_scope(Scope::Kind::members, &place.scope, declaration.name.text);
    place.scope.own(declaration.name.text)->scope = &scope;
    model::Bitmask body;
    body.bit_bound = static_cast<std::uint8_t>(bits);
    std::map<unsigned, std::string> taken;
    unsigned next = 0;
    for (const ast::Enumerator& flag : bitmask.flags) {
        check_annotations(flag.annotations, {"position"}, place.scope);
        next = annotation_number(flag.annotations, "position", 0, bits - 1, place.scope)
                   .value_or(next);
        if (next >= bits) {
            diagnostics_.error(flag.name.where, quote(flag.name.text) + " is flag " +
                                                    std::to_string(next) + ", and the bitmask " +
                                                    "has " + std::to_string(bits) + " bits");
        }
        const auto [at, fresh] = taken.emplace(next, flag.name.text);
        if (!fresh) {
            diagnostics_.error(flag.name.where, quote(flag.name.text) + " and " +
                                                    quote(at->second) + " both are flag " +
                                                    std::to_string(next));
        }
        Symbol symbol;
        symbol.name = flag.name.text;
        symbol.where = flag.name.where;
        symbol.kind = Symbol::Kind::enumerator;
        symbol.definition = definition;
        symbol.enumerator = body.flags.size();
        scope.declare(std::move(symbol), diagnostics_);
        body.flags.push_back({flag.name.text, static_cast<std::uint8_t>(next), flag.comment});
        ++next;
    }
    definition->body = std::move(body);
}

void Checker::declare(const ast::Declaration& declaration, const ast::Alias& alias,
                      const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    std::optional<model::Type> type = this->type(alias.type, place.scope);
    // A sequence of a type that is only declared is what forward declarations are for.
    if (type && type->kind == model::TypeKind::named &&
        !require_complete(*type, alias.type.where)) {
        type.reset();
    }
    if (type) type = array(*std::move(type), alias.dimensions, place.scope);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition == nullptr) return;
    // What has no type of its own stands for something, so that its uses are not reported too.
    definition->body = model::Alias{type.value_or(model::Type{})};
}

void Checker::declare(const ast::Declaration& declaration, const ast::Native&, const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition != nullptr) definition->body = model::Unusable{"native"};
}

void Checker::declare(const ast::Declaration& declaration, const ast::ValueType&,
                      const Place& place) {
    // What other files declare is in nobody's way, until somebody uses it.
    if (source_.in_main_file(declaration.name.where)) {
        diagnostics_.error(declaration.name.where,
                           "valuetypes are not supported (see doc/idl-support.md)");
    }
    const Symbol* known = place.scope.own(declaration.name.text);
    if (known != nullptr && known->name == declaration.name.text && known->definition != nullptr &&
        std::holds_alternative<model::Unusable>(known->definition->body)) {
        return;  // forward declared before
    }
    model::Definition* definition = declare_name(declaration, Symbol::Kind::type, place);
    if (definition != nullptr) definition->body = model::Unusable{"a valuetype"};
}

void Checker::declare(const ast::Declaration& declaration, const ast::AnnotationType&,
                      const Place& place) {
    Symbol symbol;
    symbol.name = '@' + declaration.name.text;
    symbol.where = declaration.name.where;
    symbol.kind = Symbol::Kind::annotation;
    place.scope.declare(std::move(symbol), diagnostics_);
}

void Checker::check_interfaces_defined() {
    for (const auto& [definition, where] : forward_) {
        if (incomplete_.count(definition) == 0) continue;
        if (!std::holds_alternative<model::Interface>(definition->body)) continue;
        diagnostics_.warning(where, "the interface " + quote(definition->name) +
                                        " is declared, but not defined in this file or in one "
                                        "that it includes");
        add_obstacle(where, "C++ needs the definition of the interface " + quote(definition->name));
    }
}

void Checker::check_structs_defined() {
    for (const auto& [definition, where] : forward_) {
        if (incomplete_.count(definition) == 0) continue;
        if (std::holds_alternative<model::Interface>(definition->body)) continue;
        diagnostics_.error(where, quote(definition->name) + " is declared, but never defined");
    }
}

void Checker::check_generated_names() {
    for (const Scope& scope : scopes_) {
        if (scope.kind() != Scope::Kind::interface) continue;
        for (const std::string_view suffix : model::generated_suffixes) {
            const std::string name = scope.name() + std::string{suffix};
            const Symbol* symbol = scope.parent()->own(name);
            if (symbol == nullptr || symbol->name != name) continue;
            add_obstacle(symbol->where, quote(name) +
                                            " is needed for what is generated for the interface " +
                                            quote(scope.name()));
        }
    }
}

void Checker::add_obstacle(Location where, std::string problem) {
    if (source_.in_main_file(where)) model_.obstacles.push_back({where, std::move(problem)});
}

model::Definition& Checker::new_definition(const ast::Declaration& declaration,
                                           const Place& place) {
    model_.storage.push_back(std::make_unique<model::Definition>());
    model::Definition& definition = *model_.storage.back();
    definition.name = declaration.name.text;
    definition.parent = place.parent;
    definition.repository_id = "IDL:" + prefix_inside(declaration, place) + ":1.0";
    definition.provenance = provenance(declaration.name.where);
    definition.comment = declaration.comment;
    definition.in_main_file = source_.in_main_file(declaration.name.where);
    place.definitions.push_back(&definition);
    return definition;
}

model::Definition* Checker::declare_name(const ast::Declaration& declaration, Symbol::Kind kind,
                                         const Place& place) {
    check_hides_no_operation(declaration, place.scope);
    Symbol symbol;
    symbol.name = declaration.name.text;
    symbol.where = declaration.name.where;
    symbol.kind = kind;
    Symbol* declared = place.scope.declare(std::move(symbol), diagnostics_);
    if (declared == nullptr) return nullptr;
    declared->definition = &new_definition(declaration, place);
    return declared->definition;
}

Symbol* Checker::declare_composite(const ast::Declaration& declaration,
                                   decltype(model::Definition::body) body, Scope::Kind kind,
                                   const Place& place) {
    // The definition joins the list of its place where it is complete.
    Definitions nowhere;
    model::Definition* definition = declare_name(
        declaration, Symbol::Kind::type, {place.scope, place.parent, nowhere, place.prefix});
    if (definition == nullptr) return nullptr;
    definition->body = std::move(body);
    Symbol* symbol = place.scope.own(declaration.name.text);
    symbol->scope = &new_scope(kind, &place.scope, declaration.name.text);
    incomplete_.insert(definition);
    return symbol;
}

Scope& Checker::new_scope(Scope::Kind kind, Scope* parent, const std::string& name) {
    return scopes_.emplace_back(kind, parent, name);
}

model::Provenance Checker::provenance(Location where) const {
    const Position position = source_.position(where);
    return {position.file, position.line};
}

}  // namespace canorb::idlc::check
