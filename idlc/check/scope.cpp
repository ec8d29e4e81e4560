#include "idlc/check/scope.hpp"

#include <algorithm>
#include <utility>

namespace canorb::idlc::check {

namespace {

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

std::vector<const Symbol*> find_outwards(const Scope& scope, const ast::ScopedName& name) {
    const Scope* from = &scope;
    while (name.global && from->parent() != nullptr) from = from->parent();
    for (const Scope* at = from; at != nullptr; at = at->parent()) {
        std::vector<const Symbol*> found = at->visible(name.parts.front().text);
        if (!found.empty()) return found;
    }
    return {};
}

}  // namespace

std::string lower_case(std::string_view name) {
    std::string lower{name};
    for (char& c : lower) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return lower;
}

std::size_t distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i);
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row[b.size()];
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
    std::string key = lower_case(symbol.name);
    if (key == lower_case(name_)) {
        diagnostics.error(symbol.where, symbol.name == name_
                                            ? quote(symbol.name) +
                                                  " is the name of the scope that it is declared in"
                                            : quote(symbol.name) + " differs only in case from " +
                                                  quote(name_) + ", which it is declared in");
        return nullptr;
    }
    const auto used = used_.find(key);
    if (used != used_.end()) {
        const std::string& before = used->second.text;
        diagnostics.error(symbol.where,
                          before == symbol.name
                              ? quote(symbol.name) +
                                    " cannot be declared here: the name was already used here "
                                    "with another meaning"
                              : quote(symbol.name) + " differs only in case from " + quote(before) +
                                    ", which was already used here");
        diagnostics.note(used->second.where, "used here");
        return nullptr;
    }
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

void Scope::use(const ast::Identifier& name) {
    if (own(name.text) == nullptr) used_.emplace(lower_case(name.text), name);
}

void Scope::expect(const ast::Identifier& name) {
    expected_.emplace(name.text, name.where);
}

std::optional<Location> Scope::declared_later(const ast::Identifier& name) const {
    for (const Scope* at = this; at != nullptr; at = at->parent_) {
        const auto found = at->expected_.find(name.text);
        if (found != at->expected_.end() && found->second > name.where) return found->second;
    }
    return std::nullopt;
}

std::string Scope::similar(std::string_view name) const {
    std::string best;
    // The time it takes grows with the square of the length.
    constexpr std::size_t longest = 64;
    if (name.size() > longest) return best;
    // One letter of three may be wrong.
    std::size_t least = name.size() / 3 + 1;
    for (const Scope* at = this; at != nullptr; at = at->parent_) {
        std::vector<const Scope*> scopes = at->ancestors_;
        scopes.push_back(at);
        for (const Scope* scope : scopes) {
            for (const auto& [key, symbol] : scope->symbols_) {
                if (symbol.kind == Symbol::Kind::other || symbol.kind == Symbol::Kind::operation ||
                    symbol.kind == Symbol::Kind::annotation) {
                    continue;
                }
                if (key.size() > longest) continue;
                const std::size_t changes = distance(lower_case(name), key);
                if (changes == 0 || changes >= least) continue;
                least = changes;
                best = symbol.name;
            }
        }
    }
    return best;
}

const Symbol* resolve(const Scope& scope, const ast::ScopedName& name, std::string_view what,
                      Diagnostics& diagnostics) {
    if (name.parts.empty()) return nullptr;
    std::vector<const Symbol*> found = find_outwards(scope, name);
    const Symbol* symbol = nullptr;
    for (std::size_t i = 0; i < name.parts.size(); ++i) {
        const ast::Identifier& part = name.parts[i];
        const Scope* looked_in = &scope;
        if (i > 0) {
            if (symbol->scope == nullptr) {
                diagnostics.error(part.where, quote(symbol->name) + " has no members to name");
                diagnostics.note(symbol->where, "declared here");
                return nullptr;
            }
            looked_in = symbol->scope;
            found = looked_in->visible(part.text);
        }
        if (found.empty()) {
            const std::optional<Location> later = looked_in->declared_later(part);
            const std::string near = later ? std::string{} : looked_in->similar(part.text);
            diagnostics.error(part.where,
                              "there is no " + std::string{what} + ' ' + quote(part.text) +
                                  (i == 0 ? "" : " in " + quote(symbol->name)) +
                                  (near.empty() ? "" : "; did you mean " + quote(near) + '?'));
            if (later) diagnostics.note(*later, "it is declared only here, behind its use");
            return nullptr;
        }
        symbol = choose(found, part, diagnostics);
        if (symbol == nullptr) return nullptr;
    }
    return symbol;
}

bool is_declared(const Scope& scope, const ast::ScopedName& name) {
    return !name.parts.empty() && !find_outwards(scope, name).empty();
}

}  // namespace canorb::idlc::check
