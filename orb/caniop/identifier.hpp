#pragma once

#include <cstdint>
#include <optional>

#include "orb/base/ids.hpp"
#include "orb/caniop/format.hpp"

namespace canorb::caniop {

/// The three fields of a CANIOP frame's 11-bit CAN identifier (doc/wire/caniop.md, "Identifier").
/// A plain value; build it when it is used, because a node's number may change.
struct Identifier {
    bool peer_to_peer = false;  ///< else a group message
    std::uint8_t receiver = 0;  ///< RxNodeId 0..30, or RxGroupId 0..31
    std::uint8_t sender = 0;    ///< TxNodeId 0..31, where 31 is a node without a number

    /// Precondition: both are valid numbers.
    static constexpr Identifier to_node(NodeId receiver, NodeId sender) {
        return {true, receiver.value(), sender.value()};
    }

    /// Precondition: both are valid numbers.
    static constexpr Identifier to_group(GroupId receiver, NodeId sender) {
        return {false, receiver.value(), sender.value()};
    }

    /// Nothing for what CANIOP never sends: 0x7E0..0x7FF (peer to peer to node 31) and more than
    /// 11 bits.
    static constexpr std::optional<Identifier> from_can_id(std::uint32_t can_id) {
        if (can_id > format::identifier_mask) return std::nullopt;
        const Identifier identifier{
            (can_id & format::protocol_bit) != 0,
            static_cast<std::uint8_t>((can_id & format::receiver_mask) >> format::receiver_shift),
            static_cast<std::uint8_t>(can_id & format::sender_mask)};
        if (identifier.peer_to_peer && identifier.receiver == format::no_node) return std::nullopt;
        return identifier;
    }

    constexpr std::uint32_t can_id() const {
        return (peer_to_peer ? format::protocol_bit : 0U) |
               (static_cast<std::uint32_t>(receiver) << format::receiver_shift) | sender;
    }

    friend bool operator==(const Identifier&, const Identifier&) = default;
};

}  // namespace canorb::caniop
