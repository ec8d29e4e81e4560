#include <gtest/gtest.h>

#include "tests/socketcan/raw_socket.hpp"

namespace canorb::test {
namespace {

TEST(RawSocket, HearsAnother) {
    const char* interface = std::getenv("CANORB_TEST_VCAN");
    if (interface == nullptr) GTEST_SKIP() << "CANORB_TEST_VCAN names no interface";
    RawSocket one{interface};
    RawSocket other{interface};
    other.accept_only(0x123);
    one.send(0x123, std::vector<std::uint8_t>{1, 2, 3});
    EXPECT_EQ(other.receive().can_dlc, 3);
}

}  // namespace
}  // namespace canorb::test
