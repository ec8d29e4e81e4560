#include "orb/can/link/address.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orb/can/link/link.hpp"

namespace canorb::can {
namespace {

using testing::HasSubstr;

template <typename Form>
Form parsed(std::string_view text) {
    const auto address = parse_bus_address(text);
    EXPECT_TRUE(address) << text << ": " << address.error();
    return address && std::holds_alternative<Form>(*address) ? std::get<Form>(*address) : Form{};
}

TEST(BusAddress, Forms) {
    EXPECT_EQ(parsed<LocalAddress>("local:test").name, "test");
    EXPECT_EQ(parsed<LocalAddress>("local:test").bitrate, std::nullopt);
    EXPECT_EQ(parsed<LocalAddress>("local:test?bitrate=250000").name, "test");
    EXPECT_EQ(parsed<LocalAddress>("local:test?bitrate=250000").bitrate, 250'000U);
    EXPECT_EQ(parsed<LocalAddress>("local:test").paced, std::nullopt);
    EXPECT_EQ(parsed<LocalAddress>("local:test?paced=no").paced, false);
    EXPECT_EQ(parsed<LocalAddress>("local:test?paced=yes&bitrate=125000").bitrate, 125'000U);
    EXPECT_EQ(parsed<SimAddress>("sim:/run/canorb/bus0").path, "/run/canorb/bus0");
    EXPECT_EQ(parsed<SimAddress>("sim:bus").path, "bus");
    EXPECT_EQ(parsed<SimAddress>("sim:/" + std::string(106, 'x')).path.size(), 107U);
    EXPECT_EQ(parsed<SocketCanAddress>("socketcan:can0").interface, "can0");
    const auto plain = parsed<SlcanAddress>("slcan:/dev/ttyACM0");
    EXPECT_EQ(plain.device, "/dev/ttyACM0");
    EXPECT_EQ(plain.bitrate, 500'000U);
    EXPECT_EQ(plain.baud, 115'200U);
    EXPECT_TRUE(plain.answers);
    EXPECT_EQ(parsed<SlcanAddress>("slcan:/dev/ttyACM0?bitrate=1000000").bitrate, 1'000'000U);
    EXPECT_EQ(parsed<SlcanAddress>("slcan:/dev/ttyACM0?baud=3000000").baud, 3'000'000U);
    const auto full = parsed<SlcanAddress>("slcan:ttyS0?answers=no&baud=57600&bitrate=10000");
    EXPECT_EQ(full.device, "ttyS0");
    EXPECT_EQ(full.bitrate, 10'000U);
    EXPECT_EQ(full.baud, 57'600U);
    EXPECT_FALSE(full.answers);
    EXPECT_TRUE(parsed<SlcanAddress>("slcan:x?answers=yes").answers);
}

TEST(BusAddress, TheDefaultIsOne) {
    EXPECT_EQ("sim:" + parsed<SimAddress>(default_bus_address()).path, default_bus_address());
}

struct BadAddress {
    std::string text;
    std::string says;
};

TEST(BusAddress, SaysWhatIsWrong) {
    for (const BadAddress& bad : {
             BadAddress{"", "none of local:NAME, sim:PATH, socketcan:IFNAME, slcan:DEVICE"},
             BadAddress{"can0", "\"can0\" is not a bus address"},
             BadAddress{"Local:x", "is not a bus address"},
             BadAddress{"local:", "needs a name"},
             BadAddress{"local:?bitrate=500000", "needs a name"},
             BadAddress{"local:x?speed=1", "no option \"speed=1\""},
             BadAddress{"local:x?", "no option \"\""},
             BadAddress{"local:x?bitrate=5000&", "no option \"\""},
             BadAddress{"local:x?paced=never", "no option \"paced=never\""},
             BadAddress{"local:x?bitrate=", "is not a bit rate"},
             BadAddress{"local:x?bitrate=4999", "from 5000 to 1000000"},
             BadAddress{"local:x?bitrate=1000001", "from 5000 to 1000000"},
             BadAddress{"local:x?bitrate=500k", "\"500k\" is not a bit rate"},
             BadAddress{"local:x?bitrate=-1", "is not a bit rate"},
             BadAddress{"sim:", "needs the path"},
             BadAddress{"sim:/" + std::string(107, 'x'), "has 108 characters"},
             BadAddress{std::string{"sim:/a\0b", 8}, "NUL"},
             BadAddress{"socketcan:", "not the name of a network interface"},
             BadAddress{"socketcan:a/b", "not the name of a network interface"},
             BadAddress{"socketcan:a b", "not the name of a network interface"},
             BadAddress{"socketcan:..", "not the name of a network interface"},
             BadAddress{"socketcan:abcdefghijklmnop", "1 to 15"},
             BadAddress{"slcan:", "needs a serial port"},
             BadAddress{"slcan:?bitrate=500000", "needs a serial port"},
             BadAddress{std::string{"slcan:/a\0b", 10}, "needs a serial port"},
             BadAddress{"slcan:x?bitrate=83333",
                        "\"83333\" is not a bit rate of slcan:; it has 10000 20000 50000 100000 "
                        "125000 250000 500000 800000 1000000"},
             BadAddress{"slcan:x?bitrate=", "\"\" is not a bit rate"},
             BadAddress{"slcan:x?bitrate=500k", "\"500k\" is not a bit rate"},
             BadAddress{"slcan:x?baud=115201", "\"115201\" is not a speed of serial lines"},
             BadAddress{"slcan:x?baud=0", "is not a speed"},
             BadAddress{"slcan:x?answers=maybe", "no option \"answers=maybe\""},
             BadAddress{"slcan:x?speed=1", "no option \"speed=1\""},
             BadAddress{"slcan:x?", "no option \"\""},
             BadAddress{"slcan:x?answers=no&", "no option \"\""},
             BadAddress{"slcan:x?answers=no?baud=9600", "no option"},
         }) {
        const auto address = parse_bus_address(bad.text);
        ASSERT_FALSE(address) << bad.text;
        EXPECT_THAT(address.error(), HasSubstr(bad.says));
        const auto link = open_link(bad.text);
        ASSERT_FALSE(link);
        EXPECT_EQ(link.error(), address.error());
    }
}

TEST(OpenLink, SaysWhatSocketCanLacks) {
    const auto link = open_link("socketcan:no-such-can");
    ASSERT_FALSE(link);
    // The one where the kernel has CAN, the other where it has not.
    EXPECT_THAT(
        link.error(),
        testing::AnyOf(HasSubstr("socketcan:no-such-can: there is no such network interface"),
                       HasSubstr("modprobe can-raw")));
}

}  // namespace
}  // namespace canorb::can
