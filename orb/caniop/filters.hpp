#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <variant>

#include "orb/base/counters.hpp"
#include "orb/base/ids.hpp"
#include "orb/can/frame.hpp"
#include "orb/caniop/identifier.hpp"

namespace canorb::caniop {

/// A list of acceptance filters, large enough for the node's own, one for every group, and the one
/// for duplicate nodes.
class FilterSet {
  public:
    static constexpr std::size_t capacity = 1 + (GroupId::highest + 1) + 1;

    void add(const can::Filter& filter) { filters_[size_++] = filter; }
    std::size_t size() const { return size_; }
    std::span<const can::Filter> span() const { return {filters_.data(), size_}; }

  private:
    std::array<can::Filter, capacity> filters_{};
    std::size_t size_ = 0;
};

/// The filters for a controller with a filter list: one for the node (none without a number), then
/// one for each group, lowest first. Nothing else passes. The masks cover Protocol and receiver;
/// every sender passes, remote and extended frames do not.
FilterSet exact_filters(std::optional<NodeId> self, std::span<const GroupId> groups);

/// The filters for a BasicCAN controller with two mask-and-match registers: one for the node
/// (none without a number), one for all groups together (none without groups). Groups where this
/// node is no member may pass the second: admit() refuses their frames.
/// The formula is that of doc/wire/caniop.md, "Acceptance filters".
FilterSet mask_filters(std::optional<NodeId> self, std::span<const GroupId> groups);

/// One more filter, for a controller with room to spare: all frames whose sender has this node's
/// own number, whoever they are for. A controller does not receive what it sends itself, so they
/// are those of another node with the same number, which admit() tells.
can::Filter duplicate_node_filter(NodeId self);

/// Decides on one received frame before reassembly: its identifier, or the counter that names why
/// it is not for this node:
///  - frames_not_caniop: no standard data frame, an identifier that CANIOP never sends, or a
///    sender without a number (reserved for network management);
///  - frames_of_duplicate_node: the sender has this node's own number, whoever the receiver is;
///  - frames_for_other_nodes, frames_of_other_groups: the controller's filters were wider.
/// It decides only; the caller counts.
std::variant<Identifier, Counter> admit(const can::Frame& frame, std::optional<NodeId> self,
                                        std::span<const GroupId> groups);

}  // namespace canorb::caniop
