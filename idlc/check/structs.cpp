#include <algorithm>
#include <utility>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

namespace {

/// How many values the discriminator has; nothing for more than anybody writes labels for.
std::optional<std::uint64_t> values_of(const model::Type& discriminator) {
    switch (discriminator.kind) {
        case model::TypeKind::boolean:
            return 2;
        case model::TypeKind::character:
        case model::TypeKind::octet:
        case model::TypeKind::int8:
        case model::TypeKind::uint8:
            return 256;
        case model::TypeKind::int16:
        case model::TypeKind::uint16:
        case model::TypeKind::wide_character:
            return 65536;
        case model::TypeKind::named:
            return std::get<model::Enum>(discriminator.definition->body).enumerators.size();
        default:
            return std::nullopt;
    }
}

/// The n-th value of the discriminator, the most natural ones first.
model::Value value_of(const model::Type& discriminator, std::uint64_t n) {
    switch (discriminator.kind) {
        case model::TypeKind::boolean:
            return n != 0;
        case model::TypeKind::character:
            return static_cast<char>(n);
        case model::TypeKind::wide_character:
            return static_cast<char16_t>(n);
        case model::TypeKind::int8:
            return std::int64_t{static_cast<std::int8_t>(n)};
        case model::TypeKind::int16:
            return std::int64_t{static_cast<std::int16_t>(n)};
        case model::TypeKind::int32:
        case model::TypeKind::int64:
            return static_cast<std::int64_t>(n);
        case model::TypeKind::named:
            return model::EnumeratorValue{discriminator.definition, static_cast<std::size_t>(n)};
        default:
            return n;
    }
}

}  // namespace

template <typename Body>
Symbol* Checker::composite_symbol(const ast::Declaration& declaration, const Place& place) {
    Symbol* known = place.scope.own(declaration.name.text);
    if (known != nullptr && known->name == declaration.name.text && known->definition != nullptr &&
        incomplete_.count(known->definition) != 0 && open_.count(known->definition) == 0 &&
        std::holds_alternative<Body>(known->definition->body)) {
        return known;
    }
    return declare_composite(declaration, Body{}, Scope::Kind::members, place);
}

void Checker::open_composite(const ast::Declaration& declaration, const Symbol& symbol,
                             const Place& place) {
    model::Definition& definition = *symbol.definition;
    // It may have been declared in another opening of its module, or in an included file.
    definition.parent = place.parent;
    definition.provenance = provenance(declaration.name.where);
    definition.comment = declaration.comment;
    definition.in_main_file = source_.in_main_file(declaration.name.where);
    place.definitions.push_back(&definition);
    open_.insert(&definition);
}

template <typename Body>
void Checker::declare_forward(const ast::Declaration& declaration, const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    const Symbol* known = place.scope.own(declaration.name.text);
    if (known != nullptr && known->name == declaration.name.text && known->definition != nullptr &&
        std::holds_alternative<Body>(known->definition->body)) {
        return;  // said before, which is no error
    }
    const Symbol* symbol = composite_symbol<Body>(declaration, place);
    if (symbol == nullptr) return;
    forward_.emplace_back(symbol->definition, declaration.name.where);
    new_definition(declaration, place).body = model::Forward{symbol->definition};
}

void Checker::declare(const ast::Declaration& declaration, const ast::ForwardStruct&,
                      const Place& place) {
    declare_forward<model::Struct>(declaration, place);
}

void Checker::declare(const ast::Declaration& declaration, const ast::ForwardUnion&,
                      const Place& place) {
    declare_forward<model::Union>(declaration, place);
}

void Checker::declare(const ast::Declaration& declaration, const ast::Struct& structure,
                      const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    Symbol* symbol = composite_symbol<model::Struct>(declaration, place);
    if (symbol == nullptr) return;
    open_composite(declaration, *symbol, place);
    model::Definition& definition = *symbol->definition;
    model::Struct body;
    if (structure.base) {
        body.base = base_struct(*structure.base, place.scope);
        if (body.base != nullptr) {
            symbol->scope->add_base(*find(place.scope, *structure.base, "struct")->scope);
        }
    }
    Prefix prefix{prefix_inside(declaration, place)};
    body.members =
        members(structure.members, {*symbol->scope, &definition, body.definitions, prefix});
    definition.body = std::move(body);
    open_.erase(&definition);
    incomplete_.erase(&definition);
}

const model::Definition* Checker::base_struct(const ast::ScopedName& name, Scope& scope) {
    const Symbol* symbol = find(scope, name, "struct");
    if (symbol == nullptr) return nullptr;
    if (symbol->definition == nullptr || symbol->kind != Symbol::Kind::type ||
        !std::holds_alternative<model::Struct>(symbol->definition->body)) {
        diagnostics_.error(name.where(), quote(symbol->name) + " is not a struct");
        diagnostics_.note(symbol->where, "declared here");
        return nullptr;
    }
    if (incomplete_.count(symbol->definition) != 0) {
        diagnostics_.error(name.where(),
                           quote(symbol->name) + " must be defined before it can be inherited");
        diagnostics_.note(symbol->where, "only declared here");
        return nullptr;
    }
    return symbol->definition;
}

void Checker::declare(const ast::Declaration& declaration, const ast::Exception& exception,
                      const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    model::Definition* definition = declare_name(declaration, Symbol::Kind::exception, place);
    if (definition == nullptr) return;
    Scope& scope = new_scope(Scope::Kind::members, &place.scope, declaration.name.text);
    place.scope.own(declaration.name.text)->scope = &scope;
    model::Exception body;
    Prefix prefix{prefix_inside(declaration, place)};
    body.members = members(exception.members, {scope, definition, body.definitions, prefix});
    definition->body = std::move(body);
}

std::vector<model::Member> Checker::members(const std::vector<ast::Member>& list,
                                            const Place& place) {
    std::vector<model::Member> members;
    for (const ast::Member& written : list) {
        if (auto member = this->member(written, place)) members.push_back(*std::move(member));
    }
    return members;
}

std::optional<model::Member> Checker::member(const ast::Member& member, const Place& place) {
    check_annotations(member.annotations, {"default"}, place.scope);
    declarations(member.declared, place);
    std::optional<model::Type> type = this->type(member.type, place.scope);
    if (type && !require_complete(*type, member.type.where)) type.reset();
    if (type) type = array(*std::move(type), member.dimensions, place.scope);
    for (const Symbol* inherited : place.scope.visible(member.name.text)) {
        if (place.scope.own(member.name.text) != nullptr) break;
        diagnostics_.error(member.name.where,
                           quote(member.name.text) + " is already a member of a base struct");
        diagnostics_.note(inherited->where, "previously declared here");
        return std::nullopt;
    }
    Symbol symbol;
    symbol.name = member.name.text;
    symbol.where = member.name.where;
    place.scope.declare(std::move(symbol), diagnostics_);
    if (!type) return std::nullopt;
    model::Member checked{*type, member.name.text, member.comment, {}};
    checked.default_value = annotation_value(member.annotations, "default", *type, place.scope);
    return checked;
}

std::optional<model::Type> Checker::discriminator(const ast::Type& written, Scope& scope) {
    const std::optional<model::Type> type = this->type(written, scope);
    if (!type) return std::nullopt;
    const model::Type& known = model::resolved(*type);
    switch (known.kind) {
        case model::TypeKind::boolean:
        case model::TypeKind::character:
        case model::TypeKind::wide_character:
        case model::TypeKind::octet:
        case model::TypeKind::int8:
        case model::TypeKind::uint8:
        case model::TypeKind::int16:
        case model::TypeKind::uint16:
        case model::TypeKind::int32:
        case model::TypeKind::uint32:
        case model::TypeKind::int64:
        case model::TypeKind::uint64:
            return type;
        case model::TypeKind::named:
            if (std::holds_alternative<model::Enum>(known.definition->body)) return type;
            break;
        default:
            break;
    }
    diagnostics_.error(written.where,
                       "a union is switched by an integer, character, boolean, octet or enum");
    return std::nullopt;
}

void Checker::declare(const ast::Declaration& declaration, const ast::Union& choice,
                      const Place& place) {
    check_annotations(declaration.annotations, {}, place.scope);
    Symbol* symbol = composite_symbol<model::Union>(declaration, place);
    if (symbol == nullptr) return;
    open_composite(declaration, *symbol, place);
    model::Definition& definition = *symbol->definition;
    Prefix prefix{prefix_inside(declaration, place)};
    model::Union body;
    const Place inside{*symbol->scope, &definition, body.definitions, prefix};
    declarations(choice.declared, inside);
    check_annotations(choice.discriminator_annotations, {}, *symbol->scope);
    const std::optional<model::Type> type = discriminator(choice.discriminator, *symbol->scope);
    if (type) {
        body.discriminator = *type;
        cases(choice, body, inside);
        check_labels(declaration, body);
    }
    definition.body = std::move(body);
    open_.erase(&definition);
    incomplete_.erase(&definition);
}

void Checker::cases(const ast::Union& choice, model::Union& body, const Place& place) {
    std::vector<std::pair<model::Value, Location>> seen;
    std::optional<Location> default_label;
    for (const ast::UnionCase& written : choice.cases) {
        model::UnionCase one;
        for (const ast::UnionLabel& label : written.labels) {
            if (!label.value) {
                if (default_label) {
                    diagnostics_.error(label.where, "a union has one default at most");
                    diagnostics_.note(*default_label, "the other one is here");
                }
                default_label = label.where;
                one.is_default = true;
                continue;
            }
            const auto value = this->value(*label.value, body.discriminator, place.scope);
            if (!value) continue;
            const auto twice = std::find_if(
                seen.begin(), seen.end(), [&](const auto& other) { return other.first == *value; });
            if (twice != seen.end()) {
                diagnostics_.error(label.where, "this label is already there");
                diagnostics_.note(twice->second, "here");
                continue;
            }
            seen.emplace_back(*value, label.where);
            one.labels.push_back(*value);
        }
        if (auto member = this->member(written.member, place)) {
            one.member = *std::move(member);
            body.cases.push_back(std::move(one));
        }
    }
}

void Checker::check_labels(const ast::Declaration& declaration, model::Union& body) {
    const model::Type& discriminator = model::resolved(body.discriminator);
    std::vector<model::Value> labels;
    for (const model::UnionCase& one : body.cases) {
        labels.insert(labels.end(), one.labels.begin(), one.labels.end());
    }
    const std::optional<std::uint64_t> values = values_of(discriminator);
    if (!values || labels.size() < *values) {
        std::uint64_t n = 0;
        while (std::find(labels.begin(), labels.end(), value_of(discriminator, n)) !=
               labels.end()) {
            ++n;
        }
        body.unlabelled = value_of(discriminator, n);
        return;
    }
    const auto with_default = std::find_if(body.cases.begin(), body.cases.end(),
                                           [](const auto& one) { return one.is_default; });
    if (with_default == body.cases.end()) return;
    diagnostics_.error(declaration.name.where,
                       "the default of " + quote(declaration.name.text) +
                           " is never selected: the other cases have all values of its switch");
}

}  // namespace canorb::idlc::check
