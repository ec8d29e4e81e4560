#include "orb/can/frame_length.hpp"

#include <cassert>

#include "orb/can/frame_encoder.hpp"

namespace canorb::can {

StuffedBits stuffed_bits(const Frame& frame) {
    StuffedBits result;
    const auto append = [&result](std::uint8_t level, FramePosition) {
        assert(result.size < StuffedBits::capacity);
        result.bits[result.size++] = level;
    };
    static_cast<void>(FrameEncoder{append}.encode(frame));
    return result;
}

std::uint32_t frame_length(const Frame& frame) {
    return static_cast<std::uint32_t>(stuffed_bits(frame).size) + frame_tail_bits +
           intermission_bits;
}

std::uint32_t arbitration_field(const Frame& frame) {
    const std::uint32_t rtr = frame.remote ? 1 : 0;
    if (!frame.extended) return ((frame.id & 0x7FFU) << 21) | (rtr << 20);
    const std::uint32_t srr_ide = 0b11;
    return ((frame.id >> 18) << 21) | (srr_ide << 19) | ((frame.id & 0x3FFFFU) << 1) | rtr;
}

}  // namespace canorb::can
