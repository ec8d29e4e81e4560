#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "idlc/ast.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/model.hpp"

namespace canorb::idlc::check {

class Scope;

inline std::string quote(std::string_view text) {
    return '\'' + std::string{text} + '\'';
}

/// What a name stands for.
struct Symbol {
    enum class Kind : std::uint8_t {
        module,
        type,
        constant,
        enumerator,  ///< or a flag of a bitmask
        exception,
        operation,   ///< or an attribute
        annotation,  ///< declared by @annotation; its name is "@name", so that it meets no other
        other,       ///< a member or a parameter
    };

    std::string name;  ///< as declared
    Location where;
    Kind kind = Kind::other;
    model::Definition* definition = nullptr;  ///< for an enumerator: its enum or bitmask
    std::size_t enumerator = 0;
    Scope* scope = nullptr;  ///< what its name opens: of modules, interfaces, structs, ...
};

/// The names of a module, an interface, a struct or a parameter list. IDL compares names without
/// regard to case, and forbids to use one in another case than it was declared in.
class Scope {
  public:
    enum class Kind : std::uint8_t { module, interface, members };

    Scope(Kind kind, Scope* parent, std::string name)
        : kind_(kind), parent_(parent), name_(std::move(name)) {}

    Kind kind() const { return kind_; }
    Scope* parent() const { return parent_; }
    const std::string& name() const { return name_; }
    /// Makes the names of an interface's base visible, with all that the base inherits.
    void add_base(const Scope& base);

    /// Reports and returns null when the name is taken.
    Symbol* declare(Symbol symbol, Diagnostics& diagnostics);

    /// In this very scope, any case; null when there is none.
    Symbol* own(std::string_view name);
    const Symbol* own(std::string_view name) const;

    /// In this scope or in the interfaces it inherits. Two different answers are both given.
    std::vector<const Symbol*> visible(std::string_view name) const;

    /// Notes that `name` was used here for something declared elsewhere: from then on it cannot be
    /// declared here with another meaning.
    void use(const ast::Identifier& name);

    /// Notes a declaration of this scope that is yet to be read, for messages on its use before.
    void expect(const ast::Identifier& name);
    /// Where this scope or one around it declares the name behind its use.
    std::optional<Location> declared_later(const ast::Identifier& name) const;

    /// The name that is most like this one, of those visible from here; empty when none is near.
    std::string similar(std::string_view name) const;

  private:
    Kind kind_;
    Scope* parent_;
    std::string name_;
    std::vector<const Scope*> ancestors_;  ///< direct or not, each once
    std::map<std::string, Symbol, std::less<>> symbols_;
    std::map<std::string, ast::Identifier, std::less<>> used_;
    std::map<std::string, Location, std::less<>> expected_;
};

std::string lower_case(std::string_view name);

/// How many letters must be changed, added or left out to make one of the other.
std::size_t distance(std::string_view a, std::string_view b);

/// Resolves a scoped name from within `scope`, outwards; null when it fails, which is reported.
/// `what` says what is looked for, "type". It is no use of the name: see Scope::use().
const Symbol* resolve(const Scope& scope, const ast::ScopedName& name, std::string_view what,
                      Diagnostics& diagnostics);

/// Whether the name's first part is declared by anybody, as seen from `scope`.
bool is_declared(const Scope& scope, const ast::ScopedName& name);

}  // namespace canorb::idlc::check
