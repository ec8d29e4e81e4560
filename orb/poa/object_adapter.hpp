#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "orb/base/ids.hpp"
#include "orb/base/result.hpp"
#include "orb/poa/servant.hpp"

namespace canorb::poa {

enum class ActivationError : std::uint8_t {
    object_already_active,   ///< the index is in use
    servant_already_active,  ///< UNIQUE_ID: the servant has an index
    index_out_of_range,      ///< not 1..1023
    exhausted,               ///< no index left
};

/// The active object map of one ORB: object index -> servant. It owns no servant.
///
/// Invariants:
///  * a servant is behind at most one index (UNIQUE_ID);
///  * an index that the adapter chose is not given out again, so a reference to a deactivated
///    object never reaches another one within a run.
class ObjectAdapter {
  public:
    ObjectAdapter();

    /// SYSTEM_ID: the next index, counting up from 1024.
    Result<ObjectIndex, ActivationError> activate(Servant& servant);
    /// USER_ID: `index`, 1..1023.
    Result<ObjectIndex, ActivationError> activate_with_id(ObjectIndex index, Servant& servant);
    /// False when nothing is active there.
    [[nodiscard]] bool deactivate(ObjectIndex index);

    /// Null when nothing is active there.
    Servant* find(ObjectIndex index) const;

  private:
    bool is_active(const Servant& servant) const;

    std::vector<Servant*> servants_;  // by object index
    ObjectIndex next_system_index_ = first_system_index;
};

}  // namespace canorb::poa
