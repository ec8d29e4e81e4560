#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "orb/can/frame.hpp"

namespace canorb::can {

/// The bits of a classic frame from SOF to the end of the CRC sequence as they are on the bus,
/// stuff bits included. 0 is dominant, 1 recessive.
struct StuffedBits {
    /// 118 bits of an extended frame with 8 octets, and a stuff bit for each 4 after the first.
    static constexpr std::size_t capacity = 118 + (118 - 1) / 4;

    std::array<std::uint8_t, capacity> bits{};
    std::size_t size = 0;
};

/// CRC delimiter, ACK slot, ACK delimiter and the 7 bits of EOF: never stuffed.
inline constexpr std::uint32_t frame_tail_bits = 10;

/// Between the end of EOF and the earliest SOF after it.
inline constexpr std::uint32_t intermission_bits = 3;

/// The CRC is the real CAN CRC-15. The reserved bits are sent dominant. `frame` is a classic data
/// or remote frame (not `fd`, not `error`).
StuffedBits stuffed_bits(const Frame& frame);

/// How long a classic frame occupies the bus, in bit times: SOF to the end of EOF with its exact
/// number of stuff bits, and 3 bits of intermission. 47..135 for standard data frames, 67..160
/// for extended ones.
std::uint32_t frame_length(const Frame& frame);

/// What bus arbitration compares, SOF first and as one number: the lower wins. Equal for two
/// frames only when they have the same identifier, kind and RTR bit.
std::uint32_t arbitration_field(const Frame& frame);

}  // namespace canorb::can
