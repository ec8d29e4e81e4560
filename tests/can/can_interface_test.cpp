// What the kernel says of a CAN interface, octet by octet. All numbers are in the machine's octet
// order; these are a little-endian machine's.

#include "orb/can/link/can_interface.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cerrno>

#include "tests/support/octets.hpp"

namespace canorb::can {
namespace {

using canorb::test::hex;
using canorb::test::octets;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using testing::VariantWith;

// struct nlmsghdr: length, type RTM_NEWLINK, flags, sequence, port
const std::string new_can0 =
    "84000000 1000 0000 00000000 00000000"
    // struct ifinfomsg: family, ARPHRD_CAN, index 5, IFF_UP | RUNNING | LOWER_UP | ECHO, change
    "00 00 1801 05000000 41000500 FFFFFFFF"
    // IFLA_IFNAME, padded to a multiple of four
    "0900 0300 63616E30 00 000000"
    // IFLA_LINKINFO, marked as nested, with IFLA_INFO_KIND and IFLA_INFO_DATA
    "5800 1280"
    "0800 0100 63616E 00"
    "4C00 0200"
    // IFLA_CAN_BITTIMING: 500 000 bit/s, seven more numbers
    "2400 0100 20A10700 00000000 00000000 00000000 00000000 00000000 00000000 00000000"
    // IFLA_CAN_STATE error passive; IFLA_CAN_CTRLMODE listen-only; IFLA_CAN_RESTART_MS 100
    "0800 0400 02000000"
    "0C00 0500 02000000 02000000"
    "0800 0600 64000000"
    // IFLA_CAN_BERR_COUNTER: TEC 128, REC 5
    "0800 0800 8000 0500";

const std::string new_vcan0 =
    "40000000 1000 0000 00000000 00000000"
    "00 00 1801 03000000 C1000100 FFFFFFFF"
    "0A00 0300 7663616E30 00 0000"
    "1400 1200 0900 0100 7663616E 00 000000 0000 0000";

class Netlink : public testing::Test {
  protected:
    void SetUp() override {
        if (std::endian::native != std::endian::little) {
            GTEST_SKIP() << "the octets are those of a little-endian machine";
        }
    }
};

InterfaceStatus only_interface(const std::string& datagram) {
    const auto messages = parse_netlink(octets(datagram));
    if (messages.size() != 1 || !std::holds_alternative<InterfaceStatus>(messages[0])) {
        ADD_FAILURE() << messages.size() << " messages, or another kind";
        return {};
    }
    return std::get<InterfaceStatus>(messages[0]);
}

TEST_F(Netlink, TellsAllOfAnInterface) {
    const InterfaceStatus status = only_interface(new_can0);
    EXPECT_EQ(status.index, 5);
    EXPECT_EQ(status.name, "can0");
    EXPECT_TRUE(status.is_can);
    EXPECT_FALSE(status.removed);
    EXPECT_TRUE(status.up);
    EXPECT_TRUE(status.carrier);
    EXPECT_TRUE(status.running);
    EXPECT_TRUE(status.echoes);
    EXPECT_TRUE(status.listen_only);
    EXPECT_TRUE(status.restarts_itself);
    EXPECT_EQ(status.bitrate, 500'000U);
    EXPECT_EQ(status.errors, (ErrorStatus{ControllerState::error_passive, 128, 5}));
}

TEST_F(Netlink, AVirtualInterfaceHasNoErrorsAndNoBitrate) {
    const InterfaceStatus status = only_interface(new_vcan0);
    EXPECT_EQ(status.name, "vcan0");
    EXPECT_TRUE(status.is_can);
    EXPECT_TRUE(status.up);
    EXPECT_FALSE(status.echoes);
    EXPECT_EQ(status.bitrate, 0U);
    EXPECT_EQ(status.errors, std::nullopt);
}

std::string with(std::string text, const std::string& old, const std::string& replacement) {
    const std::size_t at = text.find(old);
    if (at == std::string::npos) {
        ADD_FAILURE() << old;
        return text;
    }
    return text.replace(at, old.size(), replacement);
}

TEST_F(Netlink, KnowsTheKernelsStates) {
    const auto state = [](const std::string& number) {
        return only_interface(with(new_can0, "0800 0400 02", "0800 0400 " + number)).errors->state;
    };
    EXPECT_EQ(state("00"), ControllerState::error_active);
    EXPECT_EQ(state("01"), ControllerState::error_active) << "warning";
    EXPECT_EQ(state("02"), ControllerState::error_passive);
    EXPECT_EQ(state("03"), ControllerState::bus_off);
    EXPECT_EQ(state("04"), ControllerState::error_active) << "being down is another flag's matter";
}

TEST_F(Netlink, DownAndRemoved) {
    EXPECT_FALSE(only_interface(with(new_can0, "41000500", "00000400")).up);
    const InterfaceStatus bus_off = only_interface(with(new_can0, "41000500", "01000400"));
    EXPECT_TRUE(bus_off.up);
    EXPECT_FALSE(bus_off.carrier);
    EXPECT_FALSE(bus_off.running);
    const InterfaceStatus removed = only_interface(with(new_can0, "1000 0000", "1100 0000"));
    EXPECT_TRUE(removed.removed);
    EXPECT_FALSE(removed.up) << "whatever its flags say";
    EXPECT_FALSE(only_interface(with(new_can0, "1801", "0100")).is_can) << "Ethernet";
}

TEST_F(Netlink, AnswersToRequests) {
    EXPECT_THAT(parse_netlink(octets("24000000 0200 0000 00000000 00000000  EDFFFFFF"
                                     "00000000 0000 0000 00000000 00000000")),
                ElementsAre(VariantWith<NetlinkAnswer>(NetlinkAnswer{ENODEV})));
    EXPECT_THAT(parse_netlink(octets("24000000 0200 0000 00000000 00000000  00000000"
                                     "00000000 0000 0000 00000000 00000000")),
                ElementsAre(VariantWith<NetlinkAnswer>(NetlinkAnswer{0})));
}

TEST_F(Netlink, SeveralMessagesInADatagram) {
    EXPECT_THAT(parse_netlink(octets(new_vcan0 + new_can0)), SizeIs(2));
}

TEST_F(Netlink, IgnoresWhatIsCutShort) {
    const auto whole = octets(new_can0);
    for (std::size_t size = 0; size < whole.size(); ++size) {
        EXPECT_THAT(parse_netlink(Bytes{whole}.first(size)), IsEmpty()) << size;
    }
    // A message that is whole, with attributes that claim to be longer, or shorter than their head.
    EXPECT_EQ(only_interface(with(new_can0, "0900 0300", "FF00 0300")).name, "");
    EXPECT_EQ(only_interface(with(new_can0, "0900 0300", "0300 0300")).name, "");
    EXPECT_EQ(only_interface(with(new_can0, "4C00 0200", "4D00 0200")).bitrate, 0U);
    EXPECT_EQ(only_interface(with(new_can0, "2400 0100", "0500 0100")).bitrate, 0U);
}

TEST_F(Netlink, AsksForAnInterfaceByItsName) {
    EXPECT_EQ(hex(interface_query("can0")), hex(octets("2C000000 1200 0100 00000000 00000000"
                                                       "00 00 0000 00000000 00000000 00000000"
                                                       "0900 0300 63616E30 00 000000")));
}

TEST_F(Netlink, AsksForARestart) {
    EXPECT_EQ(hex(restart_request(5)), hex(octets("38000000 1000 0500 00000000 00000000"
                                                  "00 00 0000 05000000 00000000 00000000"
                                                  "1800 1200"
                                                  "0800 0100 63616E 00"
                                                  "0C00 0200"
                                                  "0800 0700 01000000")));
}

TEST(InterfaceMonitor, SeesTheLoopbackInterfaceAndMissesWhatIsNotThere) {
    const auto loopback = InterfaceMonitor::open("lo");
    ASSERT_TRUE(loopback) << error_text(loopback.error());
    EXPECT_FALSE(loopback->status().removed);
    EXPECT_GT(loopback->status().index, 0);
    EXPECT_FALSE(loopback->status().is_can);
    const auto missing = InterfaceMonitor::open("no-such-can");
    ASSERT_TRUE(missing) << error_text(missing.error());
    EXPECT_TRUE(missing->status().removed);
}

}  // namespace
}  // namespace canorb::can
