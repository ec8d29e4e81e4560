#include "orb/can/frame.hpp"

#include <gtest/gtest.h>

namespace canorb::can {
namespace {

Frame with(std::uint32_t id, bool extended, std::uint8_t length) {
    Frame frame;
    frame.id = id;
    frame.extended = extended;
    frame.length = length;
    return frame;
}

TEST(Frame, IsClassicUpToTheHighestIdentifierAndLength) {
    EXPECT_TRUE(is_classic(Frame{}));
    EXPECT_TRUE(is_classic(with(0x7FF, false, 8)));
    EXPECT_TRUE(is_classic(with(0x1FFFFFFF, true, 8)));
    Frame remote = with(0x7FF, false, 8);
    remote.remote = true;
    EXPECT_TRUE(is_classic(remote));
}

TEST(Frame, IsNotClassicBeyondThem) {
    EXPECT_FALSE(is_classic(with(0x800, false, 0)));
    EXPECT_FALSE(is_classic(with(0x20000000, true, 0)));
    EXPECT_FALSE(is_classic(with(0, false, 9)));
    EXPECT_FALSE(is_classic(with(0, true, 9)));
}

TEST(Frame, OfCanFdOrOfAnErrorIsNotClassic) {
    Frame fd;
    fd.fd = true;
    EXPECT_FALSE(is_classic(fd));
    Frame error;
    error.error = true;
    EXPECT_FALSE(is_classic(error));
}

}  // namespace
}  // namespace canorb::can
