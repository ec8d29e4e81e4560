#include "orb/can/frame_bits.hpp"

#include <cassert>

#include "orb/can/frame_encoder.hpp"

namespace canorb::can {

FrameBits frame_bits(const Frame& frame) {
    FrameBits result;
    const auto append = [&result](std::uint8_t level, FramePosition position) {
        assert(result.size < FrameBits::capacity);
        result.bits[result.size++] = FrameBit{level, position};
        if (position.stuff) ++result.stuff_bits;
    };
    result.crc = static_cast<std::uint16_t>(FrameEncoder{append}.encode(frame));
    append(1, {FrameField::crc_delimiter});
    append(0, {FrameField::ack_slot});
    append(1, {FrameField::ack_delimiter});
    for (std::uint8_t i = 0; i < 7; ++i) append(1, {FrameField::end_of_frame, i});
    return result;
}

}  // namespace canorb::can
