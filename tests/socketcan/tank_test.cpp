// The tank as three processes on a CAN interface.

#include "tests/socketcan/can_test.hpp"

namespace canorb::test {
namespace {

using TankOnCan = VcanTest;

TEST_F(TankOnCan, RegulatesAndEndsPolitely) {
    Child b{{TANK_NODE_B, "--bus", address}};
    Child a{{TANK_NODE_A, "--bus", address}};
    ASSERT_TRUE(a.says("operator station at ")) << a.text();
    ASSERT_TRUE(a.says("\n"));
    const std::string path = a.text().substr(a.text().find("/dev/"));
    Child station{{TANK_OPERATOR, "--serial", path.substr(0, path.find('\n'))}, Child::Input::pipe};

    // The tank begins full, and empties down to the setpoint, where VE opens.
    ASSERT_TRUE(b.says("VS A")) << b.text();
    station.type("dh\n");
    EXPECT_TRUE(station.says("slot 5 ms, setpoint 125 cm")) << station.text();
    EXPECT_TRUE(station.says("VE open")) << station.text();
    EXPECT_TRUE(station.says("VE closed")) << station.text();
    EXPECT_TRUE(station.says("VE open")) << station.text();
    EXPECT_THAT(station.text(), testing::Not(testing::HasSubstr("LOST")));

    a.send_signal(SIGINT);
    EXPECT_EQ(a.wait(), 0) << a.text();
    EXPECT_GT(station.wait(), 0);
    EXPECT_THAT(station.text(), testing::HasSubstr("node A has closed the line"));
    EXPECT_TRUE(b.says("both valves closed")) << b.text();
    b.send_signal(SIGINT);
    EXPECT_EQ(b.wait(), 0) << b.text();
}

}  // namespace
}  // namespace canorb::test
