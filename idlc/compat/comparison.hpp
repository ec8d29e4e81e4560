#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "idlc/compat.hpp"

namespace canorb::idlc::compat {

inline constexpr Rule all_rules[] = {
    // interfaces
    {"interface-removed", Severity::breaks},
    {"interface-added", Severity::safe},
    {"interface-kind-changed", Severity::breaks},
    {"repository-id-changed", Severity::breaks},
    {"repository-id-kept", Severity::careful},
    {"base-removed", Severity::breaks},
    {"base-added", Severity::safe},
    // operations
    {"operation-added", Severity::safe},
    {"oneway-operation-added", Severity::careful},
    {"operation-removed", Severity::breaks},
    {"operation-id-changed", Severity::breaks},
    {"operation-id-reused", Severity::breaks},
    {"operation-renamed", Severity::careful},
    {"operation-moved", Severity::careful},
    {"oneway-changed", Severity::breaks},
    {"no-longer-groupable", Severity::careful},
    {"result-changed", Severity::breaks},
    {"parameter-added", Severity::breaks},
    {"parameter-removed", Severity::breaks},
    {"parameters-reordered", Severity::breaks},
    {"parameter-renamed", Severity::careful},
    {"parameter-direction-changed", Severity::breaks},
    {"parameter-type-changed", Severity::breaks},
    {"exception-added", Severity::careful},
    {"exception-removed", Severity::careful},
    // types
    {"type-id-changed", Severity::careful},
    {"type-replaced", Severity::careful},
    {"reference-type-changed", Severity::careful},
    {"integer-widened", Severity::careful},
    {"integer-narrowed", Severity::careful},
    {"bound-raised", Severity::careful},
    {"bound-lowered", Severity::careful},
    {"enumerator-appended", Severity::careful},
    {"enumerator-inserted", Severity::breaks},
    {"enumerator-removed", Severity::breaks},
    {"enumerators-reordered", Severity::breaks},
    {"enumerator-renamed", Severity::careful},
    {"flag-added", Severity::safe},
    {"flag-removed", Severity::careful},
    {"flag-moved", Severity::breaks},
    {"flag-renamed", Severity::careful},
    {"bit-bound-changed", Severity::breaks},
    {"member-appended", Severity::breaks},
    {"member-inserted", Severity::breaks},
    {"member-removed", Severity::breaks},
    {"members-reordered", Severity::breaks},
    {"member-renamed", Severity::careful},
    {"member-type-changed", Severity::breaks},
    {"discriminator-changed", Severity::breaks},
    {"union-label-added", Severity::breaks},
    {"union-case-appended", Severity::careful},
    {"union-label-removed", Severity::breaks},
    {"union-label-moved", Severity::breaks},
    {"union-default-added", Severity::breaks},
    {"union-default-removed", Severity::breaks},
    // constants
    {"constant-changed", Severity::careful},
};

/// A rule by its name: one that there is not does not compile.
struct RuleName {
    consteval RuleName(const char* name) : rule(find(name)) {}  // NOLINT: meant to convert

    const Rule* rule;

  private:
    static consteval const Rule* find(std::string_view name) {
        for (const Rule& each : all_rules) {
            if (each.name == name) return &each;
        }
        throw std::invalid_argument("no such rule");
    }
};

/// Who receives values: which side finds out when they are not what it expects.
struct Flow {
    bool to_server = false;
    bool to_client = false;

    friend bool operator==(const Flow&, const Flow&) = default;
};

/// Where both versions have something that may differ.
struct Site {
    std::string name;  ///< "parameter 'x' of Devices::Motor::start"
    const model::Provenance& old_place;
    const model::Provenance& new_place;
    Flow flow;
    RuleName changed;  ///< what it is when the type is another one
};

/// What became of a list of which each entry has a name and its place is what counts.
struct Alignment {
    bool reordered = false;
    std::vector<std::pair<std::size_t, std::size_t>> both;
    std::vector<std::size_t> removed;
    std::vector<std::size_t> added;
};

Alignment align(const std::vector<std::string>& old_names,
                const std::vector<std::string>& new_names);

/// What happens at who receives: "an old server answers MARSHAL (completed NO)".
std::string refuses(std::string_view age, Flow flow);

/// Its own and those that it inherits, by id.
std::vector<model::InheritedOperation> all_operations(const model::Definition& interface);
void collect_bases(const model::Definition& interface, model::Definitions& into);
bool is_local_interface(const model::Definition& interface);

class Comparison {
  public:
    Comparison(const model::Model& old_version, const model::Model& new_version);

    std::vector<Finding> run();

  private:
    using Definition = model::Definition;
    using Type = model::Type;

    void add(RuleName rule, const model::Provenance* old_place, const model::Provenance* new_place,
             std::string text);
    void add(RuleName rule, const Site& site, std::string text) {
        add(rule, &site.old_place, &site.new_place, std::move(text));
    }
    void add(RuleName rule, const Definition& old_one, const Definition& new_one,
             std::string text) {
        add(rule, &old_one.provenance, &new_one.provenance, std::move(text));
    }

    const Definition* match(const Definition& old_one) const;
    bool matched(const Definition& old_one, const Definition& new_one) const {
        return match(old_one) == &new_one;
    }
    Flow flow(const Definition& old_one, const Definition& new_one) const;
    void note_flows(const model::Definitions& definitions);
    void note_flow(const Type& type, Flow flow);
    void note_flow(const Definition& definition, Flow flow);
    void note_kept_ids();

    void compare(const Definition& old_one, const Definition& new_one);

    // interfaces
    void interface(const Definition& old_one, const Definition& new_one);
    void bases(const Definition& old_one, const Definition& new_one);
    void operations(const Definition& old_one, const Definition& new_one);
    void operation(const Definition& new_interface, const model::InheritedOperation& old_one,
                   const std::vector<model::InheritedOperation>& old_all,
                   const std::vector<model::InheritedOperation>& new_all);
    void signature(const model::InheritedOperation& old_one,
                   const model::InheritedOperation& new_one);
    void parameters(const model::InheritedOperation& old_one,
                    const model::InheritedOperation& new_one);
    void exceptions(const model::InheritedOperation& old_one,
                    const model::InheritedOperation& new_one);

    // types
    void type(const Type& old_type, const Type& new_type, const Site& site);
    bool same_octets(const Type& old_type, const Type& new_type);
    bool same_octets(const Definition& old_one, const Definition& new_one);
    void type_id(const Definition& old_one, const Definition& new_one);
    void enumeration(const Definition& old_one, const Definition& new_one);
    void bitmask(const Definition& old_one, const Definition& new_one);
    void members(const Definition& old_one, const Definition& new_one,
                 const std::vector<const model::Member*>& old_members,
                 const std::vector<const model::Member*>& new_members);
    void choice(const Definition& old_one, const Definition& new_one);
    void member(const Definition& old_one, const Definition& new_one, const model::Member& from,
                const model::Member& to);
    void constant(const Definition& old_one, const Definition& new_one);

    std::vector<const Definition*> old_;  ///< all, at any depth, in the order of the file
    std::vector<const Definition*> new_;
    std::map<std::string, const Definition*> new_by_id_;  ///< without version
    std::map<std::string, const Definition*> new_by_name_;
    std::map<const Definition*, Flow> flows_;
    std::vector<Finding> findings_;
    /// The new versions of what has a finding that breaks, itself or what it declares.
    std::set<const Definition*> broken_;
    const Definition* comparing_ = nullptr;
    /// Pairs that same_octets() is about to compare: recursive types come back to them.
    std::set<std::pair<const Definition*, const Definition*>> assumed_same_;
};

}  // namespace canorb::idlc::compat
