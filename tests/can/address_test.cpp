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
    EXPECT_EQ(parsed<SimAddress>("sim:/run/canorb/bus0").path, "/run/canorb/bus0");
    EXPECT_EQ(parsed<SimAddress>("sim:bus").path, "bus");
    EXPECT_EQ(parsed<SimAddress>("sim:/" + std::string(106, 'x')).path.size(), 107U);
    EXPECT_EQ(parsed<SocketCanAddress>("socketcan:can0").interface, "can0");
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
             BadAddress{"", "none of local:NAME, sim:PATH, socketcan:IFNAME"},
             BadAddress{"can0", "\"can0\" is not a bus address"},
             BadAddress{"Local:x", "is not a bus address"},
             BadAddress{"local:", "needs a name"},
             BadAddress{"local:?bitrate=500000", "needs a name"},
             BadAddress{"local:x?speed=1", "no option \"speed=1\""},
             BadAddress{"local:x?bitrate=", "is not a bit rate"},
             BadAddress{"local:x?bitrate=9999", "from 10000 to 1000000"},
             BadAddress{"local:x?bitrate=1000001", "from 10000 to 1000000"},
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
         }) {
        const auto address = parse_bus_address(bad.text);
        ASSERT_FALSE(address) << bad.text;
        EXPECT_THAT(address.error(), HasSubstr(bad.says));
        const auto link = open_link(bad.text);
        ASSERT_FALSE(link);
        EXPECT_EQ(link.error(), address.error());
    }
}

TEST(OpenLink, SaysThatThereIsNoSocketCanYet) {
    const auto link = open_link("socketcan:can0");
    ASSERT_FALSE(link);
    EXPECT_THAT(link.error(), HasSubstr("no SocketCAN link yet"));
}

}  // namespace
}  // namespace canorb::can
