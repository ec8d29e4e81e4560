#pragma once

#include <cstddef>
#include <cstdint>

/// The numbers of CANIOP's wire format, as doc/wire/caniop.md describes it.
namespace canorb::caniop::format {

// The 11-bit identifier: Protocol, RxNodeId or RxGroupId, TxNodeId.
inline constexpr std::uint32_t identifier_mask = 0x7FF;
inline constexpr std::uint32_t protocol_bit = 0x400;  ///< 1: peer to peer, 0: group
inline constexpr std::uint32_t receiver_mask = 0x3E0;
inline constexpr unsigned receiver_shift = 5;
inline constexpr std::uint32_t sender_mask = 0x01F;

/// As TxNodeId: a node without a number, which only network management sends. Never a receiver
/// peer to peer: 0x7F0..0x7FF are not allowed on CAN 2.0 controllers.
inline constexpr std::uint8_t no_node = 31;

// Frames of a message.
inline constexpr std::uint8_t continuation_bit = 0x80;  ///< of the first octet; 0: a first frame
inline constexpr std::uint8_t sequence_mask = 0x7F;
inline constexpr std::size_t sequence_modulus = 128;
inline constexpr std::size_t sequence_octets = 1;  ///< before a continuation frame's message octets

/// The longest message that message_size can tell: itself, what is before it, and 65535.
inline constexpr std::size_t longest_message = 65538;

}  // namespace canorb::caniop::format
