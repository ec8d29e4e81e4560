#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "idlc/ast.hpp"
#include "idlc/check/scope.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/model.hpp"
#include "idlc/source.hpp"

namespace canorb::idlc::check {

/// Walks the tree once, in order: IDL wants everything declared before it is used.
class Checker {
  public:
    Checker(const Source& source, Diagnostics& diagnostics);

    model::Model run(const ast::File& file);

  private:
    using Definitions = std::vector<const model::Definition*>;

    /// Where a declaration stands.
    struct Place {
        Scope& scope;
        const model::Definition* parent;
        Definitions& definitions;  ///< what its definition is appended to
    };

    // Declarations of modules and, but for the last three, interfaces: check.cpp.
    void declarations(const std::vector<ast::Declaration>& list, const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Constant& constant,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Enum& enumeration,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Struct& structure,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Exception& exception,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Alias& alias, const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Module& module,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::ForwardInterface& forward,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Interface& interface,
                 const Place& place);
    /// Of interfaces only, which handle them themselves.
    void declare(const ast::Declaration&, const ast::Attribute&, const Place&) {}
    void declare(const ast::Declaration&, const ast::Operation&, const Place&) {}

    std::vector<model::Member> members(const std::vector<ast::Member>& list, Scope& around,
                                       const model::Definition& owner);
    void check_interfaces_defined();
    void check_waits();
    void check_generated_names();

    model::Definition& new_definition(const ast::Declaration& declaration, const Place& place);
    /// The definition, with its name declared; null when the name is taken.
    model::Definition* declare_name(const ast::Declaration& declaration, Symbol::Kind kind,
                                    const Place& place);
    Scope& new_scope(Scope::Kind kind, Scope* parent, const std::string& name);
    model::Provenance provenance(Location where) const;
    /// Warns of annotations; the one that `known` names is left alone.
    void ignore_annotations(const ast::Declaration& declaration, std::string_view known = {});

    // Interfaces: interfaces.cpp.
    Symbol* interface_symbol(const ast::Declaration& declaration, const Place& place);
    void bases(const ast::Interface& interface, Scope& scope, model::Interface& body);
    void check_inherited_names(const ast::Declaration& declaration, const model::Interface& body);
    bool check_inherited_ids(const ast::Declaration& declaration, const model::Interface& body);
    void body(const ast::Interface& interface, Scope& scope, model::Definition& definition);
    void operation(const ast::Declaration& declaration, const ast::Operation& operation,
                   Scope& scope, model::Interface& body);
    void check_oneway(const ast::Declaration& declaration, const ast::Operation& operation);
    void attribute(const ast::Declaration& declaration, const ast::Attribute& attribute,
                   Scope& scope, model::Interface& body);
    void declare_operation(const ast::Declaration& declaration, Scope& scope);
    Definitions raises(const std::vector<ast::ScopedName>& names, Scope& scope);
    void number_operations(const ast::Declaration& declaration, Scope& scope,
                           model::Interface& body);
    std::optional<unsigned> first_operation(const ast::Declaration& declaration, Scope& scope);

    // Types and values: types.cpp.
    std::optional<model::Type> type(const ast::Type& written, Scope& scope);
    std::optional<model::Type> named_type(const ast::Type& written, Scope& scope);
    std::optional<model::Type> array(model::Type element,
                                     const std::vector<ast::Expression>& dimensions, Scope& scope);
    std::optional<std::uint32_t> bound(const ast::Expression& expression, Scope& scope);
    std::optional<model::Value> value(const ast::Expression& expression, const model::Type& type,
                                      Scope& scope);
    std::optional<model::Value> named_value(const ast::ScopedName& name, Scope& scope);
    /// For a member of `owner`: notes the interfaces that must be defined before `owner` is
    /// complete, and reports those that it cannot wait for.
    void require_complete(const model::Type& type, Location where, const model::Definition& owner);
    bool is_complete(const model::Definition& definition) const;

    /// A struct or exception, and an interface defined behind it that it contains references to.
    struct Wait {
        const model::Definition* owner;
        const model::Definition* needed;
        Location where;
    };

    const Source& source_;
    Diagnostics& diagnostics_;
    model::Model model_;
    std::deque<Scope> scopes_;
    /// Interfaces that are declared only, and structs and exceptions while their members are read.
    std::set<const model::Definition*> incomplete_;
    std::vector<Wait> waits_;
    /// Where forward declared interfaces were declared first.
    std::vector<std::pair<const model::Definition*, Location>> forward_;
    /// Where each operation of the interface being read was declared, in the order of its ids.
    std::vector<Location> operation_places_;
};

inline std::string quote(std::string_view text) {
    return '\'' + std::string{text} + '\'';
}

}  // namespace canorb::idlc::check
