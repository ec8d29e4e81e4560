// Frames, filters and error messages as linux/can.h and linux/can/error.h define them.

#include "orb/can/link/socketcan_frame.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace canorb::can {
namespace {

using canorb::test::octets;

constexpr std::uint32_t extended_flag = 0x80000000;
constexpr std::uint32_t remote_flag = 0x40000000;

can_frame raw(std::uint32_t id, std::uint8_t length, const std::string& data) {
    can_frame frame{};
    frame.can_id = id;
    frame.can_dlc = length;
    const auto bytes = octets(data);
    std::copy(bytes.begin(), bytes.end(), frame.data);
    return frame;
}

void expect_both_ways(const Frame& frame, std::uint32_t id, std::uint8_t length,
                      const std::string& data) {
    const can_frame out = to_socketcan(frame);
    EXPECT_EQ(out.can_id, id);
    EXPECT_EQ(out.can_dlc, length);
    EXPECT_EQ((std::vector<std::uint8_t>{out.data, out.data + 8}), octets(data));
    EXPECT_EQ(from_socketcan(out), frame);
}

TEST(SocketCanFrame, BothWays) {
    expect_both_ways(Frame::standard(0x123, octets("DEADBEEF")), 0x123, 4, "DEADBEEF 00000000");
    expect_both_ways(Frame::standard(0x7EF, octets("0102030405060708")), 0x7EF, 8,
                     "0102030405060708");
    Frame extended = Frame::standard(0, octets("FF"));
    extended.id = 0x1FFFFFFF;
    extended.extended = true;
    expect_both_ways(extended, 0x9FFFFFFF, 1, "FF00000000000000");
    Frame remote;
    remote.id = 0x321;
    remote.remote = true;
    remote.length = 8;
    expect_both_ways(remote, 0x40000321, 8, "0000000000000000");
}

TEST(SocketCanFrame, ALargerDlcIsEightOctets) {
    EXPECT_EQ(from_socketcan(raw(0x100, 15, "0102030405060708")),
              Frame::standard(0x100, octets("0102030405060708")));
}

TEST(SocketCanFrame, FiltersKeepStandardAndExtendedApart) {
    const can_filter node = to_socketcan(Filter{.mask = 0x7E0, .value = 0x460, .data_only = true});
    EXPECT_EQ(node.can_id, 0x460U);
    EXPECT_EQ(node.can_mask, 0x7E0U | extended_flag | remote_flag);
    const can_filter all = to_socketcan(Filter{.mask = 0, .value = 0});
    EXPECT_EQ(all.can_mask, extended_flag);
    const can_filter one =
        to_socketcan(Filter{.mask = 0x1FFFFFFF, .value = 0x12345, .extended = true});
    EXPECT_EQ(one.can_id, 0x12345U | extended_flag);
    EXPECT_EQ(one.can_mask, 0x1FFFFFFFU | extended_flag);
    // CAN_INV_FILTER, bit 29 of the identifier, would turn a filter round.
    EXPECT_EQ(to_socketcan(Filter{.mask = 0x7FF, .value = 0x20000001}).can_id, 0x1U);
}

ErrorReport error(std::uint32_t classes, const std::string& data = "0000000000000000") {
    return parse_error(raw(0x20000000 | classes, 8, data));
}

TEST(SocketCanErrors, BusOffAndRestarted) {
    EXPECT_EQ(error(0x40).state, ControllerState::bus_off);
    EXPECT_EQ(error(0x100).state, ControllerState::error_active);
    EXPECT_EQ(error(0x140).state, ControllerState::bus_off) << "the worse of the two";
    EXPECT_EQ(error(0x40).tec, std::nullopt);
}

TEST(SocketCanErrors, StatesOfTheController) {
    EXPECT_EQ(error(0x04, "0010000000000000").state, ControllerState::error_passive) << "RX";
    EXPECT_EQ(error(0x04, "0020000000000000").state, ControllerState::error_passive) << "TX";
    EXPECT_EQ(error(0x04, "003C000000000000").state, ControllerState::error_passive);
    EXPECT_EQ(error(0x04, "0004000000000000").state, ControllerState::error_active) << "warning";
    EXPECT_EQ(error(0x04, "0040000000000000").state, ControllerState::error_active);
    EXPECT_EQ(error(0x04, "0000000000000000").state, std::nullopt) << "unspecified";
}

TEST(SocketCanErrors, Counters) {
    const ErrorReport passive = error(0x04, "0020 0000 0000 8805");
    EXPECT_EQ(passive.tec, 0x88);
    EXPECT_EQ(passive.rec, 0x05);
    const ErrorReport bus_error = error(0x288, "0000 0000 0000 1122");  // CAN_ERR_CNT
    EXPECT_EQ(bus_error.tec, 0x11);
    EXPECT_EQ(bus_error.rec, 0x22);
    EXPECT_EQ(bus_error.state, std::nullopt);
    EXPECT_EQ(error(0x88, "0000 0000 0000 1122").tec, std::nullopt) << "no counters in it";
}

TEST(SocketCanErrors, WhatWasLost) {
    EXPECT_TRUE(error(0x04, "0001000000000000").receive_overflow);
    EXPECT_FALSE(error(0x04, "0002000000000000").receive_overflow) << "that is the transmitter";
    EXPECT_TRUE(error(0x88, "0000040000000000").receive_error) << "a stuff error";
    EXPECT_FALSE(error(0x88, "0000840000000000").receive_error) << "that is the transmitter";
    EXPECT_FALSE(error(0x08, "0000200000000000").receive_error) << "an overload frame";
    EXPECT_FALSE(error(0x08, "0000400000000000").receive_error) << "an active error flag";
    EXPECT_FALSE(error(0x04, "0000040000000000").receive_error) << "not what data[2] is about";
    EXPECT_TRUE(error(0x01).transmit_timeout);
    EXPECT_FALSE(error(0x40).transmit_timeout);
}

}  // namespace
}  // namespace canorb::can
