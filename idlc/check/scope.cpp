#include "idlc/check/scope.hpp"

#include <algorithm>
#include <utility>

namespace canorb::idlc::check {

namespace {

std::string quote(std::string_view text) {
    return '\'' + std::string{text} + '\'';
}

/// The one symbol among `found` that `part` means; null, with a message, when there is none.
const Symbol* choose(const std::vector<const Symbol*>& found, const ast::Identifier& part,
                     Diagnostics& diagnostics) {
    if (found.size() > 1) {
        diagnostics.error(part.where, quote(part.text) + " is ambiguous: it is inherited twice");
        for (const Symbol* symbol : found) diagnostics.note(symbol->where, "declared here");
        return nullptr;
    }
    if (found.front()->name != part.text) {
        diagnostics.error(part.where, quote(part.text) + " differs only in case from " +
                                          quote(found.front()->name));
        diagnostics.note(found.front()->where, "declared here");
        return nullptr;
    }
    return found.front();
}

}  // namespace

std::string lower_case(std::string_view name) {
    std::string lower{name};
    for (char& c : lower) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return lower;
}

Symbol* Scope::declare(Symbol symbol, Diagnostics& diagnostics) {
    if (const Symbol* previous = own(symbol.name)) {
        diagnostics.error(symbol.where, previous->name == symbol.name
                                            ? quote(symbol.name) + " is already declared"
                                            : quote(symbol.name) + " differs only in case from " +
                                                  quote(previous->name));
        diagnostics.note(previous->where, "previously declared here");
        return nullptr;
    }
    if (lower_case(symbol.name) == lower_case(name_)) {
        diagnostics.error(symbol.where,
                          quote(symbol.name) + " is the name of the scope that it is declared in");
        return nullptr;
    }
    const auto used = used_.find(symbol.name);
    if (used != used_.end()) {
        diagnostics.error(symbol.where, quote(symbol.name) +
                                            " cannot be declared here: the name was already used "
                                            "here with another meaning");
        diagnostics.note(used->second, "used here");
        return nullptr;
    }
    std::string key = lower_case(symbol.name);
    return &symbols_.emplace(std::move(key), std::move(symbol)).first->second;
}

Symbol* Scope::own(std::string_view name) {
    const auto found = symbols_.find(lower_case(name));
    return found == symbols_.end() ? nullptr : &found->second;
}

const Symbol* Scope::own(std::string_view name) const {
    const auto found = symbols_.find(lower_case(name));
    return found == symbols_.end() ? nullptr : &found->second;
}

void Scope::add_base(const Scope& base) {
    const auto add = [&](const Scope* scope) {
        if (std::find(ancestors_.begin(), ancestors_.end(), scope) == ancestors_.end()) {
            ancestors_.push_back(scope);
        }
    };
    add(&base);
    for (const Scope* ancestor : base.ancestors_) add(ancestor);
}

std::vector<const Symbol*> Scope::visible(std::string_view name) const {
    if (const Symbol* symbol = own(name)) return {symbol};
    std::vector<const Scope*> scopes;
    for (const Scope* ancestor : ancestors_) {
        if (ancestor->own(name) != nullptr) scopes.push_back(ancestor);
    }
    std::vector<const Symbol*> found;
    for (const Scope* scope : scopes) {
        // A name that a derived interface declares anew hides the one in its base.
        const bool hidden = std::any_of(scopes.begin(), scopes.end(), [&](const Scope* other) {
            return std::find(other->ancestors_.begin(), other->ancestors_.end(), scope) !=
                   other->ancestors_.end();
        });
        if (!hidden) found.push_back(scope->own(name));
    }
    return found;
}

void Scope::use(const std::string& name, Location where) {
    // In a module C++ and users of IDL are at ease with it; elsewhere neither is.
    if (kind_ != Kind::module && own(name) == nullptr) used_.emplace(name, where);
}

const Symbol* resolve(Scope& scope, const ast::ScopedName& name, std::string_view what,
                      Diagnostics& diagnostics) {
    if (name.parts.empty()) return nullptr;
    Scope* from = &scope;
    if (name.global) {
        while (from->parent() != nullptr) from = from->parent();
    }
    std::vector<const Symbol*> found;
    for (Scope* at = from; at != nullptr && found.empty(); at = at->parent()) {
        found = at->visible(name.parts.front().text);
        // `attribute State state` and its like are at ease with each other: what is sought is never
        // an operation or a member.
        std::erase_if(found, [&](const Symbol* symbol) {
            const bool other =
                symbol->kind == Symbol::Kind::operation || symbol->kind == Symbol::Kind::other;
            return other && symbol->name != name.parts.front().text;
        });
    }
    if (!name.global && !found.empty()) {
        scope.use(name.parts.front().text, name.parts.front().where);
    }

    const Symbol* symbol = nullptr;
    for (std::size_t i = 0; i < name.parts.size(); ++i) {
        const ast::Identifier& part = name.parts[i];
        if (i > 0) {
            if (symbol->scope == nullptr) {
                diagnostics.error(part.where, quote(symbol->name) + " has no members to name");
                diagnostics.note(symbol->where, "declared here");
                return nullptr;
            }
            found = symbol->scope->visible(part.text);
        }
        if (found.empty()) {
            diagnostics.error(part.where, "there is no " + std::string{what} + ' ' +
                                              quote(part.text) +
                                              (i == 0 ? "" : " in " + quote(symbol->name)));
            return nullptr;
        }
        symbol = choose(found, part, diagnostics);
        if (symbol == nullptr) return nullptr;
    }
    return symbol;
}

}  // namespace canorb::idlc::check
