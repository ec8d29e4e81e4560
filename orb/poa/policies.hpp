#pragma once

#include <cstdint>

namespace canorb {

// CORBA 2.6, 11.3.7. What has only one value here is not listed: ORB_CTRL_MODEL,
// IMPLICIT_ACTIVATION (where ids are the system's), USE_ACTIVE_OBJECT_MAP_ONLY, RETAIN.

/// Whether the keys of a POA's objects outlive the process.
enum class LifespanPolicy : std::uint8_t {
    transient,   ///< after a restart a key may name another object
    persistent,  ///< the application gives each object the same id in every run; needs user_id
};

/// Whether a servant may be behind several objects of a POA.
enum class IdUniquenessPolicy : std::uint8_t { unique_id, multiple_id };

/// Who chooses the ids of a POA's objects.
enum class IdAssignmentPolicy : std::uint8_t {
    system_id,  ///< the ORB: 1024 to 2047, counting up, none twice in a run
    user_id,    ///< the application: 1 to 1023
};

/// The policies that can be chosen; the defaults are CORBA's.
struct PoaPolicies {
    LifespanPolicy lifespan = LifespanPolicy::transient;
    IdUniquenessPolicy id_uniqueness = IdUniquenessPolicy::unique_id;
    IdAssignmentPolicy id_assignment = IdAssignmentPolicy::system_id;

    friend bool operator==(const PoaPolicies&, const PoaPolicies&) = default;
};

/// The state of a POA manager (CORBA 2.6, 11.3.2): what happens to requests for the objects of its
/// POAs.
enum class PoaManagerState : std::uint8_t {
    holding,     ///< they wait, as many as fit; the others are answered TRANSIENT
    active,      ///< they are served
    discarding,  ///< they are answered TRANSIENT
    inactive,    ///< they are answered OBJ_ADAPTER, for ever
};

}  // namespace canorb
