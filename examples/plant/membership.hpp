#pragma once

#include <canorb/orb.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "panel.hpp"

namespace plant {

/// What is worth a line in a log.
using Log = std::function<void(std::string_view)>;

/// Every node of the plant has one object, with this index: corbaloc:caniop:11/1 is sensor 11.
inline constexpr canorb::ObjectIndex object_index = 1;

/// The groups that one object is a member of, as people join and leave them.
class Membership {
  public:
    /// `orb` must outlive this object.
    Membership(canorb::Orb& orb, canorb::ObjectRef object, Log log);

    /// Says the group's reference, which a controller needs. Throws std::invalid_argument when
    /// it is a member.
    void join(canorb::GroupId group);
    /// Throws std::invalid_argument when it is none.
    void leave(canorb::GroupId group);
    bool in_any() const { return !groups_.empty(); }

    /// "groups 2 5", or that there are none.
    PanelLine line() const;

  private:
    canorb::Orb& orb_;
    canorb::ObjectRef object_;
    Log log_;
    std::vector<canorb::GroupId> groups_;  ///< ascending
};

}  // namespace plant
