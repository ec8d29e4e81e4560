#pragma once

#include <canorb/node.hpp>

#include "orb/runtime/orb_impl.hpp"

namespace canorb::services {

/// The management object of one node, <canorb/node.idl>: what others may know of the ORB.
///
/// A page takes one allocation, all else none.
class NodeObject final : public NodeServant {
  public:
    /// `orb` outlives it.
    explicit NodeObject(runtime::OrbImpl& orb) : orb_(orb), started_(orb.now()) {}

    Node::NodeIdentity identity() override;
    std::uint64_t uptime_ms() override;
    Node::ActiveObjects active_objects(Node::ObjectIndex first, std::uint16_t max) override;
    Node::LocalGroups local_groups(Node::GroupNumber first, std::uint16_t max) override;
    Node::MemberIndices group_members(Node::GroupNumber group, Node::ObjectIndex first,
                                      std::uint16_t max) override;
    Node::NamedCounters counters(std::uint16_t first, std::uint16_t max) override;
    Node::ControllerStatus controller() override;
    void restart() override;

  private:
    runtime::OrbImpl& orb_;
    const TimePoint started_;
};

}  // namespace canorb::services
