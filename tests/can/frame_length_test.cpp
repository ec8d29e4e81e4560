#include "orb/can/frame_length.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "tests/can/frames.hpp"

namespace canorb::can {
namespace {

using test::extended;
using test::remote;
using test::standard;

std::string text(const StuffedBits& bits) {
    std::string result;
    for (std::size_t i = 0; i < bits.size; ++i) result += bits.bits[i] == 0 ? '0' : '1';
    return result;
}

TEST(StuffedBits, AllZero) {
    // SOF, 11 + 3 bits, DLC 0: 19 zeros, whose CRC is 0: 34 zeros, a stuff bit after each 5.
    EXPECT_EQ(text(stuffed_bits(standard(0, ""))),
              "000001"
              "000001"
              "000001"
              "000001"
              "000001"
              "000001"
              "0000");
    EXPECT_EQ(frame_length(standard(0, "")), 34U + 6U + 13U);
}

TEST(StuffedBits, FieldsOfAStandardFrame) {
    // The CRC of 0 00000010100 0 0 0 0001 00000001 was computed apart from this code, by long
    // division.
    EXPECT_EQ(text(stuffed_bits(standard(0x014, "01"))),
              "00000"    // SOF and the first four bits of the identifier
              "1"        // stuff bit
              "0010100"  // the rest of the identifier
              "000"      // RTR, IDE, r0: with the identifier's last two, five zeros
              "1"        // stuff bit
              "0001"     // DLC
              "00000"
              "1"
              "001"  // data with a stuff bit
              "111011101010011");
    EXPECT_EQ(frame_length(standard(0x014, "01")), 34U + 8U + 3U + 13U);
}

TEST(StuffedBits, FieldsOfARemoteFrame) {
    EXPECT_EQ(text(stuffed_bits(remote(standard(0x123, ""), 4))),
              "0"
              "00100100011"
              "1"
              "00"
              "0100"
              "100001101010010");
    EXPECT_EQ(frame_length(remote(standard(0x123, ""), 4)), 47U);
}

TEST(StuffedBits, FieldsOfAnExtendedFrame) {
    Frame frame = extended(0, "");
    EXPECT_EQ(text(stuffed_bits(frame)),
              "00000"
              "1"
              "00000"
              "1"
              "00"  // SOF and base identifier
              "11"  // SRR, IDE
              "00000"
              "1"
              "00000"
              "1"
              "00000"
              "1"
              "000"  // identifier extension
              "00"
              "1"
              "0"
              "0000"
              "1"  // RTR and r1, r0 and DLC
              "100011000010000");
    EXPECT_EQ(frame_length(frame), 74U);
}

TEST(StuffedBits, AStuffBitMayFollowTheLastBitOfTheCrc) {
    // The first empty frame whose CRC ends in five equal bits, found by search.
    const StuffedBits bits = stuffed_bits(standard(0x009, ""));
    EXPECT_EQ(text(bits).substr(bits.size - 6), "000001");
}

TEST(FrameLength, OfKnownFrames) {
    EXPECT_EQ(frame_length(standard(0x555, "")), 34U + 1U + 13U);
    EXPECT_EQ(frame_length(standard(0x109, "5555555555555555")), 111U) << "no stuff bit at all";
    EXPECT_EQ(frame_length(standard(0x000, "0000000000000000")), 127U);
    EXPECT_EQ(frame_length(standard(0x7EF, "FFFFFFFFFFFFFFFF")), 125U);
    EXPECT_EQ(frame_length(standard(0x123, "DEADBEEF")), 81U);
    EXPECT_EQ(frame_length(remote(standard(0x123, ""), 0)), 48U);
    EXPECT_EQ(frame_length(extended(0x108465A9, "AAAAAAAAAAAAAA6A")), 131U) << "no stuff bit";
    EXPECT_EQ(frame_length(extended(0, "0000000000000000")), 150U);
    EXPECT_EQ(frame_length(extended(0x1FFFFFFF, "FFFFFFFFFFFFFFFF")), 149U);
    EXPECT_EQ(frame_length(remote(extended(0x12345678, ""), 8)), 67U);
}

// Undoes stuffed_bits() in another way: the fields come back, and the CRC's polynomial divides
// what is between the stuff bits.
TEST(StuffedBits, AreAFrameAgainWithoutTheStuffBits) {
    std::mt19937 random{7};
    for (int i = 0; i < 20'000; ++i) {
        Frame frame;
        frame.extended = random() % 2 == 0;
        frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
        frame.remote = random() % 8 == 0;
        frame.length = static_cast<std::uint8_t>(random() % 9);
        const bool is_extreme = random() % 2 == 0;  // long runs, so many stuff bits
        for (std::size_t k = 0; k < 8 && !frame.remote; ++k) {
            const auto octet = static_cast<std::uint8_t>(random());
            frame.data[k] =
                is_extreme ? static_cast<std::uint8_t>(octet % 2 == 0 ? 0x00 : 0xFF) : octet;
        }
        const StuffedBits stuffed = stuffed_bits(frame);
        std::vector<std::uint8_t> bits;
        int run = 0;
        for (std::size_t k = 0; k < stuffed.size; ++k) {
            const std::uint8_t bit = stuffed.bits[k];
            const bool differs = k == 0 || bit != stuffed.bits[k - 1];
            if (run == 5) {
                ASSERT_TRUE(differs) << "six equal bits";
            } else {
                bits.push_back(bit);
            }
            run = differs ? 1 : run + 1;
        }
        const std::size_t header = frame.extended ? 39 : 19;
        const std::size_t data = frame.remote ? 0 : frame.length * std::size_t{8};
        ASSERT_EQ(bits.size(), header + data + 15);
        for (std::size_t k = 0; k < data; ++k) {
            ASSERT_EQ(bits[header + k], (frame.data[k / 8] >> (7 - k % 8)) & 1);
        }
        std::vector<std::uint8_t> remainder = bits;
        constexpr std::string_view polynomial = "1100010110011001";
        for (std::size_t k = 0; k + 15 < remainder.size(); ++k) {
            if (remainder[k] == 0) continue;
            for (std::size_t j = 0; j < polynomial.size(); ++j) {
                remainder[k + j] =
                    remainder[k + j] ^ static_cast<std::uint8_t>(polynomial[j] - '0');
            }
        }
        ASSERT_EQ(remainder, std::vector<std::uint8_t>(remainder.size(), 0));
        const std::uint32_t length = frame_length(frame);
        ASSERT_GE(length, frame.extended ? 67U : 47U);
        ASSERT_LE(length, frame.extended ? 160U : 135U);
    }
}

TEST(ArbitrationField, OrdersAsTheBusDoes) {
    const std::vector<Frame> in_order{
        standard(0x000, ""),
        remote(standard(0x000, ""), 0),
        extended(0x000, ""),
        remote(extended(0x000, ""), 0),
        extended(0x001, ""),
        extended((1U << 18) - 1, ""),
        standard(0x001, ""),
        extended(1U << 18, ""),
        standard(0x7FF, ""),
        extended(0x1FFFFFFF, ""),
        remote(extended(0x1FFFFFFF, ""), 0),
    };
    for (std::size_t i = 1; i < in_order.size(); ++i) {
        EXPECT_LT(arbitration_field(in_order[i - 1]), arbitration_field(in_order[i])) << i;
    }
    EXPECT_EQ(arbitration_field(standard(0x123, "")), arbitration_field(standard(0x123, "01")));
}

}  // namespace
}  // namespace canorb::can
