#include "orb/caniop/filters.hpp"

#include <algorithm>
#include <cassert>

#include "orb/caniop/format.hpp"

namespace canorb::caniop {
namespace {

constexpr std::uint32_t receiver_field_mask = format::protocol_bit | format::receiver_mask;

void add_node_filter(FilterSet& filters, std::optional<NodeId> self) {
    if (!self) return;
    assert(self->is_valid());
    const Identifier identifier = Identifier::to_node(*self, NodeId{0});
    filters.add({.mask = receiver_field_mask, .value = identifier.can_id(), .data_only = true});
}

}  // namespace

FilterSet exact_filters(std::optional<NodeId> self, std::span<const GroupId> groups) {
    std::uint32_t wanted = 0;
    for (const GroupId group : groups) {
        assert(group.value() <= GroupId::highest);
        wanted |= 1U << group.value();
    }
    FilterSet filters;
    add_node_filter(filters, self);
    for (std::uint8_t group = 0; group <= GroupId::highest; ++group) {
        if ((wanted >> group & 1U) == 0) continue;
        const Identifier identifier = Identifier::to_group(GroupId{group}, NodeId{0});
        filters.add({.mask = receiver_field_mask, .value = identifier.can_id(), .data_only = true});
    }
    return filters;
}

FilterSet mask_filters(std::optional<NodeId> self, std::span<const GroupId> groups) {
    FilterSet filters;
    add_node_filter(filters, self);
    if (groups.empty()) return filters;
    std::uint32_t ones_in_all = format::receiver_mask;
    std::uint32_t zeros_in_all = format::receiver_mask;
    for (const GroupId group : groups) {
        const std::uint32_t field = Identifier::to_group(group, NodeId{0}).can_id();
        ones_in_all &= field;
        zeros_in_all &= ~field;
    }
    filters.add({.mask = format::protocol_bit | ones_in_all | zeros_in_all, .value = ones_in_all});
    return filters;
}

can::Filter duplicate_node_filter(NodeId self) {
    return {.mask = format::sender_mask, .value = self.value(), .data_only = true};
}

std::variant<Identifier, Counter> admit(const can::Frame& frame, std::optional<NodeId> self,
                                        std::span<const GroupId> groups) {
    if (frame.extended || frame.remote || frame.error) return Counter::frames_not_caniop;
    const std::optional<Identifier> identifier = Identifier::from_can_id(frame.id);
    if (!identifier || identifier->sender == format::no_node) return Counter::frames_not_caniop;
    if (self && identifier->sender == self->value()) return Counter::frames_of_duplicate_node;
    if (identifier->peer_to_peer) {
        if (!self || identifier->receiver != self->value()) return Counter::frames_for_other_nodes;
    } else if (std::find(groups.begin(), groups.end(), GroupId{identifier->receiver}) ==
               groups.end()) {
        return Counter::frames_of_other_groups;
    }
    return *identifier;
}

}  // namespace canorb::caniop
