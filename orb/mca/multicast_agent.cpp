#include "orb/mca/multicast_agent.hpp"

#include <algorithm>

namespace canorb::mca {
namespace {

/// The most derived of `interface` and its bases that all members have; null where there is none.
const InterfaceInfo* most_derived_common(const InterfaceInfo& interface,
                                         std::span<const Member> members) {
    const bool common = std::all_of(members.begin(), members.end(), [&](const Member& member) {
        return member.interface->is_a(interface.repository_id);
    });
    if (common) return &interface;
    const InterfaceInfo* best = nullptr;
    for (const InterfaceInfo* base : interface.bases) {
        const InterfaceInfo* found = most_derived_common(*base, members);
        if (found != nullptr && (best == nullptr || found->is_a(best->repository_id))) best = found;
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
