#include <algorithm>
#include <utility>

#include "idlc/check/checker.hpp"

namespace canorb::idlc::check {

namespace {

std::string joined(const std::string& prefix, const std::string& name) {
    return prefix.empty() ? name : prefix + '/' + name;
}

/// "A/B" of "A::B".
std::string slashed(std::string name) {
    for (std::size_t at = 0; (at = name.find("::", at)) != std::string::npos;) {
        name.replace(at, 2, "/");
    }
    return name;
}

/// "major.minor", each of 16 bits.
bool is_version(std::string_view text) {
    const std::size_t point = text.find('.');
    if (point == std::string_view::npos) return false;
    const auto is_number = [](std::string_view digits) {
        if (digits.empty() || digits.size() > 5) return false;
        unsigned number = 0;
        for (const char c : digits) {
            if (c < '0' || c > '9') return false;
            number = number * 10 + static_cast<unsigned>(c - '0');
        }
        return number <= 0xFFFF;
    };
    return is_number(text.substr(0, point)) && is_number(text.substr(point + 1));
}

}  // namespace

const std::string& Checker::prefix_at(Location where, const Place& place) const {
    if (place.prefix.by_file.empty()) return place.prefix.around;
    const auto found = place.prefix.by_file.find(source_.position(where).file);
    return found == place.prefix.by_file.end() ? place.prefix.around : found->second;
}

std::string Checker::prefix_inside(const ast::Declaration& declaration, const Place& place) const {
    const Symbol* own = place.scope.own(declaration.name.text);
    const auto given = type_prefixes_.find(own == nullptr ? nullptr : own->scope);
    if (given != type_prefixes_.end()) return given->second;
    return joined(prefix_at(declaration.name.where, place), declaration.name.text);
}

void Checker::declare(const ast::Declaration& declaration, const ast::IdDirective& directive,
                      const Place& place) {
    using Kind = ast::IdDirective::Kind;
    if (directive.kind == Kind::prefix) {
        place.prefix.by_file[source_.position(declaration.name.where).file] = directive.text;
        return;
    }
    const Symbol* symbol = resolve(place.scope, directive.name, "declaration", diagnostics_);
    if (symbol == nullptr) return;
    if (directive.kind == Kind::type_prefix) return set_prefix(directive, *symbol, place);
    const bool has_id = symbol->definition != nullptr && symbol->kind != Symbol::Kind::enumerator;
    // Nobody asks for the ids of operations.
    if (!has_id) return;
    set_id(declaration, directive, *symbol->definition);
}

void Checker::set_prefix(const ast::IdDirective& directive, const Symbol& symbol,
                         const Place& place) {
    if (symbol.scope == nullptr || symbol.definition == nullptr) {
        diagnostics_.error(directive.name.where(),
                           "a typeprefix is of a module, interface, struct, union or exception");
        diagnostics_.note(symbol.where, quote(symbol.name) + " is declared here");
        return;
    }
    // All that is declared in it, before the directive or behind: ids are made of the names from
    // there on.
    const std::string around = slashed(model::scoped_name(*symbol.definition));
    const std::string prefix = joined(directive.text, around);
    for (const auto& definition : model_.storage) {
        const std::string name = slashed(model::scoped_name(*definition));
        const bool inside = name == around || name.starts_with(around + '/');
        const bool whole_id_given =
            given_ids_.count(definition.get()) > given_versions_.count(definition.get());
        if (!inside || whole_id_given) continue;
        std::string& id = definition->repository_id;
        id = "IDL:" + joined(directive.text, name) + id.substr(id.rfind(':'));
    }
    type_prefixes_[symbol.scope] = prefix;
    if (&place.scope == symbol.scope) place.prefix.around = prefix;
}

void Checker::set_id(const ast::Declaration& declaration, const ast::IdDirective& directive,
                     model::Definition& definition) {
    std::string id = directive.text;
    if (directive.kind == ast::IdDirective::Kind::version) {
        if (!is_version(directive.text)) {
            diagnostics_.error(declaration.name.where,
                               "a version is two numbers up to 65535 with a point between: 1.2");
            return;
        }
        id = definition.repository_id.substr(0, definition.repository_id.rfind(':') + 1) +
             directive.text;
    }
    if (id.find(':') == std::string::npos) {
        diagnostics_.warning(declaration.name.where,
                             quote(id) +
                                 " is an odd repository id: others begin with their "
                                 "format, \"IDL:\"");
    }
    const auto [given, first] = given_ids_.emplace(&definition, declaration.name.where);
    if (!first && id != definition.repository_id) {
        diagnostics_.error(declaration.name.where,
                           "the repository id of " + quote(definition.name) + " is " +
                               quote(definition.repository_id) + " already");
        diagnostics_.note(given->second, "given here");
        return;
    }
    if (first && directive.kind == ast::IdDirective::Kind::version) {
        given_versions_.insert(&definition);
    }
    definition.repository_id = std::move(id);
}

}  // namespace canorb::idlc::check
