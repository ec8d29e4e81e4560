#include "orb/mca/multicast_agent.hpp"

#include <algorithm>

namespace canorb::mca {
namespace {

/// The most derived of `best`, `interface` and its bases that all members have; of several that
/// derive from none of the others the first in declaration order. Null where there is none.
const InterfaceInfo* most_derived_common(const InterfaceInfo& interface,
                                         std::span<const Member> members,
                                         const InterfaceInfo* best = nullptr) {
    if (interface.repository_id == corba_object_id) return best;
    const bool common = std::all_of(members.begin(), members.end(), [&](const Member& member) {
        return member.interface->is_a(interface.repository_id);
    });
    if (common) {
        return best == nullptr || interface.is_a(best->repository_id) ? &interface : best;
    }
    for (const InterfaceInfo* base : interface.bases) {
        best = most_derived_common(*base, members, best);
    }
    return best;
}

}  // namespace

bool MulticastAgent::join(GroupId group, const Member& member) {
    if (is_member(group, member.index)) return true;
    if (most_derived_common(*member.interface, members(group)) == nullptr) return false;
    members_[group.value()].push_back(member);
    update_groups();
    return true;
}

void MulticastAgent::leave(GroupId group, ObjectIndex index) {
    std::erase_if(members_[group.value()], [&](const Member& m) { return m.index == index; });
    update_groups();
}

void MulticastAgent::leave_all(ObjectIndex index) {
    for (auto& members : members_) {
        std::erase_if(members, [&](const Member& m) { return m.index == index; });
    }
    update_groups();
}

bool MulticastAgent::is_member(GroupId group, ObjectIndex index) const {
    const auto all = members(group);
    return std::any_of(all.begin(), all.end(), [&](const Member& m) { return m.index == index; });
}

std::span<const Member> MulticastAgent::members(GroupId group) const {
    return members_[group.value()];
}

const InterfaceInfo* MulticastAgent::common_interface(GroupId group) const {
    const auto all = members(group);
    return all.empty() ? nullptr : most_derived_common(*all.front().interface, all);
}

void MulticastAgent::update_groups() {
    groups_.clear();
    for (std::uint8_t i = 0; i < members_.size(); ++i) {
        if (!members_[i].empty()) groups_.push_back(GroupId{i});
    }
}

}  // namespace canorb::mca
