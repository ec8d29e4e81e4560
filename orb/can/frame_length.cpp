#include "orb/can/frame_length.hpp"

#include <algorithm>
#include <cassert>

namespace canorb::can {
namespace {

/// Appends bits, most significant first, stuffing them and keeping the CRC of the unstuffed ones.
class BitWriter {
  public:
    void put(std::uint32_t value, int width) {
        for (int shift = width - 1; shift >= 0; --shift) {
            const std::uint32_t bit = (value >> shift) & 1U;
            const bool feedback = (((crc_ >> 14) ^ bit) & 1U) != 0;
            crc_ = (crc_ << 1) & 0x7FFFU;
            if (feedback) crc_ ^= 0x4599U;
            put_bit(static_cast<std::uint8_t>(bit));
        }
    }

    StuffedBits finish() {
        // Writing the CRC changes the register, so its value is taken first.
        const std::uint32_t crc = crc_;
        put(crc, 15);
        return out_;
    }

  private:
    void put_bit(std::uint8_t bit) {
        append(bit);
        if (run_ == 5) append(bit ^ 1U);
    }

    void append(std::uint8_t bit) {
        run_ = bit == last_ ? run_ + 1 : 1;
        last_ = bit;
        assert(out_.size < StuffedBits::capacity);
        out_.bits[out_.size++] = bit;
    }

    StuffedBits out_;
    std::uint32_t crc_ = 0;
    std::uint8_t last_ = 2;  // neither: the first bit starts a run
    int run_ = 0;
};

}  // namespace

StuffedBits stuffed_bits(const Frame& frame) {
    assert(!frame.fd && !frame.error);
    const std::uint32_t rtr = frame.remote ? 1 : 0;
    BitWriter writer;
    writer.put(0, 1);  // SOF
    if (frame.extended) {
        writer.put(frame.id >> 18, 11);
        writer.put(0b11, 2);  // SRR, IDE
        writer.put(frame.id, 18);
        writer.put(rtr, 1);
        writer.put(0, 2);  // r1, r0
    } else {
        writer.put(frame.id, 11);
        writer.put(rtr, 1);
        writer.put(0, 2);  // IDE, r0
    }
    const std::uint8_t length = std::min(frame.length, Frame::max_classic_payload);
    writer.put(length, 4);
    if (!frame.remote) {
        for (std::size_t i = 0; i < length; ++i) writer.put(frame.data[i], 8);
    }
    return writer.finish();
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
