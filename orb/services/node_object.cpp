#include "orb/services/node_object.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

namespace canorb::services {
namespace {

Node::RepositoryId type_id(const InterfaceInfo& interface) {
    Node::RepositoryId id;
    if (!id.assign(interface.repository_id)) id.clear();  // half an id would be another one
    return id;
}

Node::ActiveObject describe(ObjectIndex index, const InterfaceInfo& interface) {
    return {index, type_id(interface), interface.structural_hash};
}

/// The lowest index from `first` among the members.
std::optional<ObjectIndex> next_member(std::span<const mca::Member> members, std::size_t first) {
    std::optional<ObjectIndex> next;
    for (const mca::Member& member : members) {
        if (member.index >= first && (!next || member.index < *next)) next = member.index;
    }
    return next;
}

Node::MemberIndices lowest_members(std::span<const mca::Member> members, ObjectIndex first,
                                   std::size_t max) {
    Node::MemberIndices page;
    const std::size_t most = std::min(max, page.capacity());
    for (auto next = next_member(members, first); next && page.size() < most;
         next = next_member(members, *next + std::size_t{1})) {
        page.push_back(*next);
    }
    return page;
}

Node::LocalGroup describe(const mca::MulticastAgent& agent, GroupId group) {
    const auto members = agent.members(group);
    return {group.value(), type_id(*agent.common_interface(group)),
            static_cast<std::uint16_t>(members.size()),
            lowest_members(members, 0, Node::MEMBERS_PER_PAGE)};
}

Node::ControllerState to_idl(can::ControllerState state) {
    switch (state) {
        case can::ControllerState::error_active:
            return Node::ControllerState::ERROR_ACTIVE;
        case can::ControllerState::error_passive:
            return Node::ControllerState::ERROR_PASSIVE;
        case can::ControllerState::bus_off:
            return Node::ControllerState::BUS_OFF;
        case can::ControllerState::stopped:
            break;
    }
    return Node::ControllerState::STOPPED;
}

}  // namespace

Node::NodeIdentity NodeObject::identity() {
    const OrbOptions& options = orb_.options();
    const auto node = orb_.node();
    if (!node)
        throw_system_exception(cause::object_of_another_node, "this node has no number any more");
    return {node->value(),     options.name,   options.vendor,
            options.product,   options.serial, options.software_version,
            options.boot_count};
}

std::uint64_t NodeObject::uptime_ms() {
    const auto up = std::chrono::duration_cast<std::chrono::milliseconds>(orb_.now() - started_);
    return static_cast<std::uint64_t>(up.count());
}

Node::ActiveObjects NodeObject::active_objects(Node::ObjectIndex first, std::uint16_t max) {
    Node::ActiveObjects page;
    const std::size_t most = std::min(max, Node::OBJECTS_PER_PAGE);
    page.reserve(most);
    orb_.inspect([&](const core::Engine& engine) {
        const poa::ObjectAdapter& adapter = engine.adapter();
        for (auto index = adapter.next_active(first); index && page.size() < most;
             index = adapter.next_active(static_cast<ObjectIndex>(*index + 1))) {
            page.push_back(describe(*index, adapter.find(*index)->_interface_info()));
        }
    });
    return page;
}

Node::LocalGroups NodeObject::local_groups(Node::GroupNumber first, std::uint16_t max) {
    Node::LocalGroups page;
    const std::size_t most = std::min(max, Node::GROUPS_PER_PAGE);
    page.reserve(most);
    orb_.inspect([&](const core::Engine& engine) {
        for (const GroupId group : engine.agent().groups()) {
            if (page.size() == most) break;
            if (group.value() >= first) page.push_back(describe(engine.agent(), group));
        }
    });
    return page;
}

Node::MemberIndices NodeObject::group_members(Node::GroupNumber group, Node::ObjectIndex first,
                                              std::uint16_t max) {
    const auto id = GroupId::from(group);
    if (!id) throw_system_exception(cause::bad_argument, "a group is 1 to 31");
    Node::MemberIndices page;
    orb_.inspect([&](const core::Engine& engine) {
        page = lowest_members(engine.agent().members(*id), first, max);
    });
    return page;
}

Node::NamedCounters NodeObject::counters(std::uint16_t first, std::uint16_t max) {
    const Counters counters = orb_.counters();
    Node::NamedCounters page;
    const std::size_t most = std::min(max, Node::COUNTERS_PER_PAGE);
    page.reserve(most);
    for (std::uint16_t i = first; i < counter_count && page.size() < most; ++i) {
        const auto counter = static_cast<Counter>(i);
        page.push_back({i, name(counter), counters[counter]});
    }
    return page;
}

Node::ControllerStatus NodeObject::controller() {
    const can::ErrorStatus status = orb_.error_status();
    return {to_idl(status.state), status.tec, status.rec};
}

void NodeObject::restart() {
    if (!orb_.request_restart()) throw_system_exception(cause::restart_not_allowed);
}

}  // namespace canorb::services
