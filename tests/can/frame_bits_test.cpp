#include "orb/can/frame_bits.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/can/frames.hpp"

namespace canorb::can {
namespace {

using test::extended;
using test::remote;
using test::standard;

/// Fields apart by blanks, octets by dots, stuff bits in parentheses.
std::string text(const FrameBits& frame) {
    std::string result;
    FrameField field = FrameField::start_of_frame;
    for (const FrameBit& bit : frame) {
        const FramePosition& position = bit.position;
        if (position.field != field) {
            result += ' ';
        } else if (field == FrameField::data && position.index > 0 && position.index % 8 == 0 &&
                   !position.stuff) {
            result += '.';
        }
        field = position.field;
        const char digit = bit.level == 0 ? '0' : '1';
        if (position.stuff) {
            result += {'(', digit, ')'};
        } else {
            result += digit;
        }
    }
    return result;
}

// The CRCs in this file were computed apart from this code, by long division by 1100010110011001.

TEST(FrameBits, OfAStandardDataFrame) {
    const FrameBits frame = frame_bits(standard(0x123, "DEADBEEF00000000"));
    EXPECT_EQ(text(frame),
              "0 00100100011 0 0 0 1000 "
              "11011110.10101101.1011111(0)0.11101111."
              "00000(1)000.00(1)00000(1)0.0000(1)0000.0(1)00000(1)00 "
              "110011101110111 1 0 1 1111111");
    EXPECT_EQ(frame.crc, 0x6777);
    EXPECT_EQ(frame.stuff_bits, 7U);
    EXPECT_EQ(frame.size, 115U);
    EXPECT_EQ(frame.size_with_intermission(), 118U);
}

// Frames 001h and 00800000h are those of figures 5.2 and 5.3 in C. A. Chamu Morales, "Desarrollo de
// un sistema educativo para la ensenanza del protocolo de comunicaciones CAN", 2005.
TEST(FrameBits, OfAStandardFrameWithStuffBitsBetweenOctets) {
    const FrameBits frame = frame_bits(standard(0x001, "4560554560554560"));
    EXPECT_EQ(text(frame),
              "0 0000(1)00000(1)01 0 0 0 1000 "
              "01000101.01100000(1).01010101.01000101.01100000(1).01010101.01000101.01100000(1) "
              "001111001011000 1 0 1 1111111");
    EXPECT_EQ(frame.crc, 0x1E58);
    EXPECT_EQ(frame.stuff_bits, 5U);
    EXPECT_EQ(frame.size, 113U);
}

TEST(FrameBits, OfAnExtendedDataFrame) {
    const FrameBits frame = frame_bits(extended(0x00800000, "63616E322E304232"));
    EXPECT_EQ(text(frame),
              "0 0000(1)0100000(1) 1 1 00000(1)00000(1)00000(1)000 0 0(1) 0 1000 "
              "01100011.01100001.01101110.00110010.00101110.00110000.0(1)1000010.00110010 "
              "001100000(1)010100 1 0 1 1111111");
    EXPECT_EQ(frame.crc, 0x1814);
    EXPECT_EQ(frame.stuff_bits, 8U);
    EXPECT_EQ(frame.size, 136U);
}

TEST(FrameBits, OfRemoteFrames) {
    const FrameBits empty = frame_bits(remote(standard(0x123, ""), 0));
    EXPECT_EQ(text(empty), "0 00100100011 1 0 0 000(1)0 001101110011101 1 0 1 1111111");
    EXPECT_EQ(empty.crc, 0x1B9D);
    EXPECT_EQ(empty.size, 45U);

    const FrameBits of_four = frame_bits(remote(standard(0x123, ""), 4));
    EXPECT_EQ(text(of_four), "0 00100100011 1 0 0 0100 100001101010010 1 0 1 1111111");
    EXPECT_EQ(of_four.crc, 0x4352);
    EXPECT_EQ(of_four.stuff_bits, 0U);
    EXPECT_EQ(of_four.size, 44U);

    const FrameBits wide = frame_bits(remote(extended(0x12345678, ""), 8));
    EXPECT_EQ(text(wide),
              "0 10010001101 1 1 000101011001111000 1 0 0 1000 110101101010101 1 0 1 1111111");
    EXPECT_EQ(wide.crc, 0x6B55);
    EXPECT_EQ(wide.size, 64U);
}

TEST(FrameBits, AStuffBitMayFollowTheLastBitOfTheCrc) {
    const FrameBits recessive = frame_bits(standard(0x009, ""));
    EXPECT_EQ(text(recessive),
              "0 0000(1)0001001 0 0 0 00(1)00 11111(0)0000(1)100000(1) 1 0 1 1111111");
    EXPECT_EQ(recessive.crc, 0x7C20);
    EXPECT_EQ(recessive.size, 49U);

    const FrameBits dominant = frame_bits(extended(0x62, ""));
    EXPECT_EQ(text(dominant),
              "0 0000(1)00000(1)00 1 1 00000(1)00000(1)01100010 0 0 0 0(1)000 "
              "101100010011111(0) 1 0 1 1111111");
    EXPECT_EQ(dominant.crc, 0x589F);
    EXPECT_EQ(dominant.size, 70U);
    const FrameBit stuff_bit = dominant.bits[dominant.size - frame_tail_bits - 1];
    EXPECT_EQ(stuff_bit, (FrameBit{0, {FrameField::crc, 14, true}}));
}

TEST(FrameBits, IndexesCountWithinTheField) {
    const FrameBits frame = frame_bits(standard(0x000, "FFFF"));
    EXPECT_EQ(frame.bits[0], (FrameBit{0, {FrameField::start_of_frame, 0, false}}));
    EXPECT_EQ(frame.bits[1], (FrameBit{0, {FrameField::identifier, 0, false}}));
    EXPECT_EQ(frame.bits[4], (FrameBit{0, {FrameField::identifier, 3, false}}));
    EXPECT_EQ(frame.bits[5], (FrameBit{1, {FrameField::identifier, 3, true}}));
    EXPECT_EQ(frame.bits[6], (FrameBit{0, {FrameField::identifier, 4, false}}));
    // 19 bits and 3 stuff bits before the data; a stuff bit after its fifth and tenth one.
    EXPECT_EQ(frame.bits[22], (FrameBit{1, {FrameField::data, 0, false}}));
    EXPECT_EQ(frame.bits[27], (FrameBit{0, {FrameField::data, 4, true}}));
    EXPECT_EQ(frame.bits[31], (FrameBit{1, {FrameField::data, 8, false}}));
    EXPECT_EQ(frame.bits[frame.size - 1], (FrameBit{1, {FrameField::end_of_frame, 6, false}}));
}

TEST(FrameBits, AgreeWithTheLengthOfTheFrame) {
    std::mt19937 random{11};
    for (int i = 0; i < 5'000; ++i) {
        Frame frame;
        frame.extended = random() % 2 == 0;
        frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
        frame.remote = random() % 8 == 0;
        frame.length = static_cast<std::uint8_t>(random() % 9);
        for (auto& octet : frame.data) octet = random() % 2 == 0 ? 0x00 : 0xFF;
        ASSERT_EQ(frame_bits(frame).size_with_intermission(), frame_length(frame));
    }
}

TEST(FrameField, HasAName) {
    EXPECT_EQ(name(FrameField::start_of_frame), "start of frame");
    EXPECT_EQ(name(FrameField::crc_delimiter), "CRC delimiter");
    EXPECT_EQ(name(FrameField::idle), "idle");
}

}  // namespace
}  // namespace canorb::can
