#include "orb/caniop/segmenter.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "tests/support/octets.hpp"

namespace canorb::caniop {
namespace {

using canorb::test::hex;
using canorb::test::octets;

constexpr Identifier identifier{true, 3, 5};

TEST(Segmenter, CutsAMessageIntoItsFrames) {
    const auto message = octets("10 0011 1111 1801 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E");
    ASSERT_EQ(frame_count(message.size()), 3U);
    EXPECT_EQ(hex(cut_frame(identifier, message, 0).payload()), "1000111111180102");
    EXPECT_EQ(hex(cut_frame(identifier, message, 1).payload()), "8103040506070809");
    EXPECT_EQ(hex(cut_frame(identifier, message, 2).payload()), "820A0B0C0D0E");
    for (std::size_t i = 0; i < 3; ++i) {
        const can::Frame frame = cut_frame(identifier, message, i);
        EXPECT_EQ(frame.id, 0x465U);
        EXPECT_FALSE(frame.extended || frame.remote || frame.error || frame.fd);
    }
}

TEST(Segmenter, TakesAsFewFramesAsFitAndNoEmptyLastOne) {
    const struct {
        std::size_t length, frames, last;
    } cases[] = {{1, 1, 1},  {3, 1, 3},     {8, 1, 8},     {9, 2, 1},
                 {15, 2, 7}, {16, 3, 1},    {28, 4, 6},    {29, 4, 7},
                 {30, 5, 1}, {904, 129, 7}, {905, 130, 1}, {65538, 9363, 3}};
    for (const auto& each : cases) {
        EXPECT_EQ(frame_count(each.length), each.frames) << each.length;
        EXPECT_EQ(frame_octets(each.length, each.frames - 1), each.last) << each.length;
    }
}

TEST(Segmenter, NumbersContinuationFramesModulo128) {
    std::vector<std::uint8_t> message(2000);
    std::iota(message.begin(), message.end(), std::uint8_t{0});
    EXPECT_EQ(hex(cut_frame(identifier, message, 127).payload().first(1)), "FF");
    EXPECT_EQ(hex(cut_frame(identifier, message, 128).payload().first(1)), "80");
    EXPECT_EQ(hex(cut_frame(identifier, message, 129).payload().first(1)), "81");
    // Octets 8 + 127 * 7 = 897 = 3 * 256 + 0x81 and on.
    EXPECT_EQ(hex(cut_frame(identifier, message, 128).payload()), "8081828384858687");
}

}  // namespace
}  // namespace canorb::caniop
