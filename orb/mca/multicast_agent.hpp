#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "orb/base/ids.hpp"
#include "orb/base/interface_info.hpp"

namespace canorb::mca {

/// A member of a group: an active object of this ORB.
struct Member {
    ObjectIndex index;
    const InterfaceInfo* interface;  ///< its most derived one
};

/// The multicast agent of one ORB: which local objects are in which groups. Membership is known
/// here only; there is no registry on the bus.
///
/// Invariants:
///  * groups() is the private group list: the groups with a member, lowest first;
///  * the members of a group have at least one interface in common besides CORBA::Object.
class MulticastAgent {
  public:
    /// False when it shares no interface with the members there. Joining twice is joining once.
    [[nodiscard]] bool join(GroupId group, const Member& member);
    /// No effect when it is no member.
    void leave(GroupId group, ObjectIndex index);
    void leave_all(ObjectIndex index);

    bool is_member(GroupId group, ObjectIndex index) const;
    bool has_members(GroupId group) const { return !members(group).empty(); }
    /// In the order of their joining.
    std::span<const Member> members(GroupId group) const;
    std::span<const GroupId> groups() const { return groups_; }

    /// The most derived interface that all members have; null for a group without members.
    const InterfaceInfo* common_interface(GroupId group) const;

  private:
    void update_groups();

    std::array<std::vector<Member>, GroupId::highest + std::size_t{1}> members_;
    std::vector<GroupId> groups_;
};

}  // namespace canorb::mca
