#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/ids.hpp"
#include "orb/base/result.hpp"
#include "orb/poa/policies.hpp"
#include "orb/poa/servant.hpp"

namespace canorb::poa {

enum class ActivationError : std::uint8_t {
    object_already_active,   ///< the index is in use
    servant_already_active,  ///< UNIQUE_ID: the servant has an index in this POA
    index_out_of_range,      ///< not 1..1023
    not_from_this_poa,       ///< SYSTEM_ID: not an index that this POA was given
    wrong_policy,            ///< USER_ID: the POA chooses no index
    exhausted,               ///< no index left
};

enum class CreationError : std::uint8_t {
    already_exists,   ///< the parent has a child of that name
    invalid_policy,   ///< PERSISTENT without USER_ID
    manager_inactive  ///< the manager will never serve a request
};

/// Names a POA, or a POA manager, of one adapter; never used twice.
enum class PoaId : std::uint32_t {};
enum class ManagerId : std::uint32_t {};

inline constexpr PoaId root_poa{0};
inline constexpr ManagerId root_manager{0};

/// What is to be done with a request for an object.
enum class Admission : std::uint8_t {
    dispatch,
    hold,        ///< its POA manager is holding
    discard,     ///< its POA manager is discarding
    inactive,    ///< its POA manager is inactive
    not_active,  ///< there is no such object
};

/// The POAs of one ORB, and its active object map: object index -> servant. It owns no servant.
///
/// Invariants:
///  * in a POA with UNIQUE_ID a servant is behind at most one index;
///  * an index that the adapter chose is not given out again, so a reference to a deactivated
///    object never reaches another one within a run;
///  * an active object's POA is not destroyed: destroy() wants its objects deactivated before;
///  * an inactive manager stays inactive.
class ObjectAdapter {
  public:
    /// With the root POA and its manager, which is active.
    ObjectAdapter();

    // ---- the tree

    /// Without a manager the POA gets a new one, which is holding.
    Result<PoaId, CreationError> create(PoaId parent, std::string_view name,
                                        std::optional<ManagerId> manager,
                                        const PoaPolicies& policies);
    /// The POA and all below it. Precondition: their objects are deactivated.
    void destroy(PoaId poa);
    bool exists(PoaId poa) const { return record(poa).exists; }
    /// Whether it is, or is below, `ancestor`.
    bool is_within(PoaId poa, PoaId ancestor) const;

    std::optional<PoaId> find_child(PoaId parent, std::string_view name) const;
    std::vector<PoaId> children(PoaId parent) const;
    const std::string& name(PoaId poa) const { return record(poa).name; }
    /// Nothing: the root has none.
    std::optional<PoaId> parent(PoaId poa) const;
    const PoaPolicies& policies(PoaId poa) const { return record(poa).policies; }

    // ---- managers

    ManagerId manager(PoaId poa) const { return record(poa).manager; }
    PoaManagerState state(ManagerId manager) const {
        return managers_[static_cast<std::size_t>(manager)];
    }
    /// False when it is inactive: it stays so.
    [[nodiscard]] bool set_state(ManagerId manager, PoaManagerState state);

    // ---- objects

    /// SYSTEM_ID: the next index, counting up from 1024.
    Result<ObjectIndex, ActivationError> activate(PoaId poa, Servant& servant);
    /// USER_ID: `index`, 1..1023, which the root POA takes, too. SYSTEM_ID: one that this POA was
    /// given before.
    Result<ObjectIndex, ActivationError> activate_with_id(PoaId poa, ObjectIndex index,
                                                          Servant& servant);
    /// SYSTEM_ID: an index for an object that is to be activated later.
    Result<ObjectIndex, ActivationError> reserve(PoaId poa);
    /// Whether activate_with_id() of this POA would take the index were it not in use.
    std::optional<ActivationError> check_index(PoaId poa, ObjectIndex index) const;
    /// The object with the reserved index 0, which is in no POA and always served.
    void activate_management_object(Servant& servant) {
        entries_[management_object_index].servant = &servant;
    }
    /// False when nothing is active there.
    [[nodiscard]] bool deactivate(ObjectIndex index);

    /// Null when nothing is active there.
    Servant* find(ObjectIndex index) const;
    /// The POA of the object that is or was there; nothing where there never was one.
    std::optional<PoaId> poa_of(ObjectIndex index) const;
    /// The first index in this POA that the servant is behind.
    std::optional<ObjectIndex> index_of(PoaId poa, const Servant& servant) const;

    Admission admission(ObjectIndex index) const;
    /// The lowest index from `first` where something is active.
    std::optional<ObjectIndex> next_active(ObjectIndex first) const;

  private:
    struct Record {
        std::string name;
        PoaId parent{};
        ManagerId manager{};
        PoaPolicies policies{};
        bool exists = true;
    };
    struct Entry {
        Servant* servant = nullptr;
        std::optional<PoaId> poa{};
    };

    const Record& record(PoaId poa) const { return poas_[static_cast<std::size_t>(poa)]; }
    Result<ObjectIndex, ActivationError> put(PoaId poa, ObjectIndex index, Servant& servant);
    bool is_taken(PoaId poa, const Servant& servant) const;

    std::vector<Record> poas_;               // by PoaId
    std::vector<PoaManagerState> managers_;  // by ManagerId
    std::vector<Entry> entries_;             // by object index
    ObjectIndex next_system_index_ = first_system_index;
};

}  // namespace canorb::poa
