#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "orb/can/frame.hpp"
#include "orb/can/frame_field.hpp"

namespace canorb::can {

/// Turns a classic frame into the bits from SOF to the end of the CRC sequence, with stuff bits:
/// the one place that knows their order (ISO 11898-1), which frame_length.hpp and frame_bits.hpp
/// share. `Sink` is called as sink(level, position) for each bit; 0 is dominant.
template <typename Sink>
class FrameEncoder {
  public:
    explicit FrameEncoder(Sink sink) : sink_(sink) {}

    /// Returns the CRC sequence. `frame` is not `fd`, not `error`.
    std::uint32_t encode(const Frame& frame) {
        assert(!frame.fd && !frame.error);
        const std::uint32_t rtr = frame.remote ? 1 : 0;
        put(FrameField::start_of_frame, 0, 1);
        if (frame.extended) {
            put(FrameField::identifier, frame.id >> 18, 11);
            put(FrameField::remote_request, 1, 1);  // SRR
            put(FrameField::identifier_extension, 1, 1);
            put(FrameField::extended_identifier, frame.id, 18);
            put(FrameField::extended_remote_request, rtr, 1);
            put(FrameField::reserved_1, 0, 1);
        } else {
            put(FrameField::identifier, frame.id, 11);
            put(FrameField::remote_request, rtr, 1);
            put(FrameField::identifier_extension, 0, 1);
        }
        put(FrameField::reserved_0, 0, 1);
        const std::uint8_t length = std::min(frame.length, Frame::max_classic_payload);
        put(FrameField::data_length_code, length, 4);
        if (!frame.remote) {
            for (std::size_t i = 0; i < length; ++i) {
                put(FrameField::data, frame.data[i], 8, static_cast<std::uint8_t>(8 * i));
            }
        }
        // Writing the CRC changes the register, so its value is taken first.
        const std::uint32_t crc = crc_;
        put(FrameField::crc, crc, 15);
        return crc;
    }

  private:
    /// Most significant bit first. `index` is the first bit's place in its field.
    void put(FrameField field, std::uint32_t value, int width, std::uint8_t index = 0) {
        for (int shift = width - 1; shift >= 0; --shift) {
            const std::uint32_t bit = (value >> shift) & 1U;
            const bool feedback = (((crc_ >> 14) ^ bit) & 1U) != 0;
            crc_ = (crc_ << 1) & 0x7FFFU;
            if (feedback) crc_ ^= 0x4599U;
            const auto level = static_cast<std::uint8_t>(bit);
            put_bit(level, FramePosition{field, index, false});
            if (run_ == 5) put_bit(level ^ 1U, FramePosition{field, index, true});
            ++index;
        }
    }

    void put_bit(std::uint8_t level, FramePosition position) {
        run_ = level == last_ ? run_ + 1 : 1;
        last_ = level;
        sink_(level, position);
    }

    Sink sink_;
    std::uint32_t crc_ = 0;
    std::uint8_t last_ = 2;  // neither: the first bit starts a run
    int run_ = 0;
};

}  // namespace canorb::can
