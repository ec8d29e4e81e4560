#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "orb/can/frame.hpp"
#include "orb/can/frame_field.hpp"
#include "orb/can/frame_length.hpp"

namespace canorb::can {

/// A bit time of a frame on the bus.
struct FrameBit {
    std::uint8_t level = 1;  ///< 0 is dominant, 1 recessive
    FramePosition position;
    friend bool operator==(const FrameBit&, const FrameBit&) = default;
};

/// A classic frame bit by bit, from SOF to the end of EOF, as the bus shows it when the frame is
/// sent undisturbed and acknowledged: the ACK slot is dominant.
struct FrameBits {
    static constexpr std::size_t capacity = StuffedBits::capacity + frame_tail_bits;

    std::array<FrameBit, capacity> bits{};
    std::size_t size = 0;          ///< SOF to the end of EOF, stuff bits included
    std::uint32_t stuff_bits = 0;  ///< of them
    std::uint16_t crc = 0;         ///< the 15 bits of the CRC sequence

    const FrameBit* begin() const { return bits.data(); }
    const FrameBit* end() const { return bits.data() + size; }
    std::size_t size_with_intermission() const { return size + intermission_bits; }
};

/// `frame` is a classic data or remote frame (not `fd`, not `error`).
FrameBits frame_bits(const Frame& frame);

}  // namespace canorb::can
