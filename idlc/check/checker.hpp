#pragma once

#include <cstdint>
#include <deque>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
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
    using Definitions = model::Definitions;

    /// The prefix of repository ids: what stands before the name of a definition, "omg.org/M". A
    /// #pragma prefix counts for its own file only.
    struct Prefix {
        std::string around;
        std::map<std::string, std::string> by_file{};
    };

    /// Where a declaration stands.
    struct Place {
        Scope& scope;
        const model::Definition* parent;
        Definitions& definitions;  ///< what its definition is appended to
        Prefix& prefix;
    };

    // Declarations: check.cpp.
    void declarations(const std::vector<ast::Declaration>& list, const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Module& module,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Constant& constant,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Enum& enumeration,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Bitmask& bitmask,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Alias& alias, const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Native& native,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::ValueType& value,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::AnnotationType& annotation,
                 const Place& place);
    void check_interfaces_defined();
    void check_structs_defined();
    void check_generated_names();

    /// What stands in the way of code for the main file; others are compiled by themselves.
    void add_obstacle(Location where, std::string problem);
    model::Definition& new_definition(const ast::Declaration& declaration, const Place& place);
    /// The definition, with its name declared; null when the name is taken.
    model::Definition* declare_name(const ast::Declaration& declaration, Symbol::Kind kind,
                                    const Place& place);
    /// A struct, union or interface that is declared from now on, and not yet defined; null when
    /// the name is taken.
    Symbol* declare_composite(const ast::Declaration& declaration,
                              decltype(model::Definition::body) body, Scope::Kind kind,
                              const Place& place);
    Scope& new_scope(Scope::Kind kind, Scope* parent, const std::string& name);
    model::Provenance provenance(Location where) const;

    // Structs, exceptions and unions: structs.cpp.
    void declare(const ast::Declaration& declaration, const ast::Struct& structure,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Exception& exception,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Union& choice, const Place& place);
    void declare(const ast::Declaration& declaration, const ast::ForwardStruct&,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::ForwardUnion&, const Place& place);
    /// The symbol of a struct or union `Body` that is declared or defined here; null when the name
    /// is taken.
    template <typename Body>
    Symbol* composite_symbol(const ast::Declaration& declaration, const Place& place);
    template <typename Body>
    void declare_forward(const ast::Declaration& declaration, const Place& place);
    /// Notes that the definition of the symbol's struct or union begins here.
    void open_composite(const ast::Declaration& declaration, const Symbol& symbol,
                        const Place& place);
    const model::Definition* base_struct(const ast::ScopedName& name, Scope& scope);
    std::vector<model::Member> members(const std::vector<ast::Member>& list, const Place& place);
    std::optional<model::Member> member(const ast::Member& member, const Place& place);
    std::optional<model::Type> discriminator(const ast::Type& written, Scope& scope);
    void cases(const ast::Union& choice, model::Union& body, const Place& place);
    void check_labels(const ast::Declaration& declaration, model::Union& body);

    // Interfaces and their operations: interfaces.cpp, operations.cpp.
    void declare(const ast::Declaration& declaration, const ast::ForwardInterface& forward,
                 const Place& place);
    void declare(const ast::Declaration& declaration, const ast::Interface& interface,
                 const Place& place);
    /// Of interfaces only, which handle them themselves.
    void declare(const ast::Declaration&, const ast::Attribute&, const Place&) {}
    void declare(const ast::Declaration&, const ast::Operation&, const Place&) {}
    Symbol* interface_symbol(const ast::Declaration& declaration, model::InterfaceKind kind,
                             const Place& place);
    void bases(const ast::Interface& interface, Scope& scope, model::Interface& body);
    /// The interface that a name stands for, perhaps by way of typedefs; null: something else.
    const model::Definition* interface_of(const Symbol& symbol) const;
    bool is_base_of_kind(const ast::ScopedName& name, const Symbol& symbol,
                         const model::Definition& base, const model::Interface& body);
    void check_inherited_names(const ast::Declaration& declaration, const model::Interface& body);
    bool check_inherited_ids(const ast::Declaration& declaration, const model::Interface& body);
    void body(const ast::Interface& interface, model::Interface& body, const Place& place);
    void operation(const ast::Declaration& declaration, const ast::Operation& operation,
                   Scope& scope, model::Interface& body);
    void parameters(const ast::Operation& operation, bool local, Scope& scope,
                    model::Operation& checked);
    void check_oneway(const ast::Declaration& declaration, const ast::Operation& operation);
    void attribute(const ast::Declaration& declaration, const ast::Attribute& attribute,
                   Scope& scope, model::Interface& body);
    /// The type of a parameter, result or attribute; `local`: of a local interface.
    std::optional<model::Type> operation_type(const ast::Type& written, bool local, Scope& scope);
    void declare_operation(const ast::Declaration& declaration, Scope& scope);
    /// Reports a type or constant that has the name of an inherited operation.
    void check_hides_no_operation(const ast::Declaration& declaration, const Scope& scope);
    Definitions raises(const std::vector<ast::ScopedName>& names, bool local, const Scope& scope);
    void number_operations(const ast::Declaration& declaration, Scope& scope,
                           model::Interface& body);

    // Types and values: types.cpp.
    std::optional<model::Type> type(const ast::Type& written, Scope& scope);
    std::optional<model::Type> named_type(const ast::Type& written, Scope& scope);
    /// Reads bound, digits, scale, element and key; false when one of them is wrong.
    bool arguments(const ast::Type& written, model::Type& type, Scope& scope);
    bool is_key(const model::Type& type) const;
    std::optional<model::Type> array(model::Type element,
                                     const std::vector<ast::Expression>& dimensions, Scope& scope);
    std::optional<std::uint32_t> bound(const ast::Expression& expression, Scope& scope);
    std::optional<std::uint16_t> digits(const ast::Expression& expression, Scope& scope);
    std::optional<model::Value> value(const ast::Expression& expression, const model::Type& type,
                                      Scope& scope);
    std::optional<model::Value> named_value(const ast::ScopedName& name, Scope& scope);
    /// Reports a struct or union that the type contains, if it is not yet defined.
    bool require_complete(const model::Type& type, Location where);
    const Symbol* find(Scope& scope, const ast::ScopedName& name, std::string_view what);

    // Annotations: annotations.cpp.
    /// Reports annotations that belong elsewhere, and warns of those that nobody knows; those
    /// named in `acted_on` are left alone.
    void check_annotations(const std::vector<ast::Annotation>& annotations,
                           std::initializer_list<std::string_view> acted_on, Scope& scope);
    /// The value of the annotation called `name`, which has one argument of the type.
    std::optional<model::Value> annotation_value(const std::vector<ast::Annotation>& annotations,
                                                 std::string_view name, const model::Type& type,
                                                 Scope& scope);
    /// The same for a number, which must be within the limits.
    std::optional<unsigned> annotation_number(const std::vector<ast::Annotation>& annotations,
                                              std::string_view name, unsigned lowest,
                                              unsigned highest, Scope& scope);
    bool annotation_flag(const std::vector<ast::Annotation>& annotations, std::string_view name);

    // Repository ids: repository_ids.cpp.
    void declare(const ast::Declaration& declaration, const ast::IdDirective& directive,
                 const Place& place);
    const std::string& prefix_at(Location where, const Place& place) const;
    std::string prefix_inside(const ast::Declaration& declaration, const Place& place) const;
    void set_prefix(const ast::IdDirective& directive, const Symbol& symbol, const Place& place);
    void set_id(const ast::Declaration& declaration, const ast::IdDirective& directive,
                model::Definition& definition);

    const Source& source_;
    Diagnostics& diagnostics_;
    model::Model model_;
    std::deque<Scope> scopes_;
    /// Structs, unions and interfaces that are declared, and not yet defined to their end.
    std::set<const model::Definition*> incomplete_;
    /// Those of them whose definition has begun.
    std::set<const model::Definition*> open_;
    /// Where forward declared structs, unions and interfaces were declared first.
    std::vector<std::pair<const model::Definition*, Location>> forward_;
    /// Where repository ids were given by a directive.
    std::map<const model::Definition*, Location> given_ids_;
    /// Those of which the directive gave only the version.
    std::set<const model::Definition*> given_versions_;
    /// What the names of interfaces open: an alias of an interface can be inherited, too.
    std::map<const model::Definition*, Scope*> interface_scopes_;
    /// What the ids of scopes begin with that have a typeprefix.
    std::map<const Scope*, std::string> type_prefixes_;
    /// Where each operation of the interface being read was declared, in the order of its ids.
    std::vector<Location> operation_places_;
};

}  // namespace canorb::idlc::check
