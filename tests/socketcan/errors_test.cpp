// The fault confinement state, as the kernel tells it in error frames. No interface of the machine
// has errors of its own, so `cansend` makes them up.

#include <linux/can/error.h>

#include <fstream>

#include "tests/socketcan/can_test.hpp"

namespace canorb::test {
namespace {

using can::ControllerState;
using can::ErrorStatus;

class Errors : public VcanTest {
  protected:
    /// An error frame as candump -e shows it: its class, and what is behind it.
    void report(const std::string& error_class, const std::string& data) {
        run_command("cansend " + interface + " " + error_class + "#" + data);
    }
    void report_bus_off() { report("20000040", "0000000000000000"); }
    void report_restart() { report("20000100", "0000000000000000"); }
};

TEST_F(Errors, BusOffEndsCallsAndRestartLetsThemThrough) {
    Node server{address, 3};
    Node client{address, 5};
    TestServant servant{{{7, nothing}}};
    server->root_poa().activate_object_with_id(1, servant);
    RawSocket observer{interface};
    observer.accept_only(0b1'01001'00101);
    CallInProgress call{client.object_on(9)};
    ASSERT_TRUE(observer.receive_within(20s));

    report_bus_off();
    const auto reported = CallInProgress::Clock::now();
    const CallInProgress::End end = call.end();
    ASSERT_TRUE(end.error.has_value());
    EXPECT_EQ(end.error->kind, SystemErrorKind::comm_failure);
    EXPECT_LT(end.time - reported, 100ms);
    EXPECT_EQ(client->error_status().state, ControllerState::bus_off);
    EXPECT_TRUE(server.tells(ControllerState::bus_off));
    EXPECT_TRUE(client.tells(ControllerState::bus_off));
    EXPECT_EQ(CallInProgress{client.object_on(3)}.end().error.value().kind,
              SystemErrorKind::comm_failure);

    report_restart();
    EXPECT_TRUE(server.tells(ControllerState::error_active));
    EXPECT_TRUE(client.tells(ControllerState::error_active));
    EXPECT_EQ(CallInProgress{client.object_on(3)}.end().error, std::nullopt);
}

// There is nothing behind a virtual interface that would have to be restarted.
TEST_F(Errors, RecoverLeavesBusOff) {
    Node server{address, 3};
    Node client{address, 5};
    TestServant servant{{{7, nothing}}};
    server->root_poa().activate_object_with_id(1, servant);
    report_bus_off();
    EXPECT_TRUE(client.tells(ControllerState::bus_off));
    EXPECT_TRUE(server.tells(ControllerState::bus_off));
    client->recover();
    server->recover();
    EXPECT_TRUE(client.tells(ControllerState::error_active));
    EXPECT_TRUE(server.tells(ControllerState::error_active));
    EXPECT_TRUE(client.object_on(3).invoke(7, {}).empty());
}

TEST_F(Errors, CountersAndErrorPassive) {
    Node client{address, 5};
    const auto shows = [&](const ErrorStatus& wanted) {
        return wait_until([&] { return client->error_status() == wanted; });
    };
    // CAN_ERR_CRTL, transmitter passive; TEC 136, REC 5 in octets 6 and 7.
    report("20000004", "0020000000008805");
    EXPECT_TRUE(shows({ControllerState::error_passive, 136, 5}));
    // Back to active (CAN_ERR_CRTL_ACTIVE).
    report("20000004", "0040000000005F00");
    EXPECT_TRUE(shows({ControllerState::error_active, 95, 0}));
    // Receiver passive.
    report("20000004",
           "0010000000000080"
           "");
    EXPECT_TRUE(shows({ControllerState::error_passive, 0, 128}));
    // Only a warning: active.
    report("20000004", "000C000000006060");
    EXPECT_TRUE(shows({ControllerState::error_active, 96, 96}));
}

// Frames that are for a node and come faster than it reads: the kernel drops them, and counts.
TEST_F(Errors, SlowReaderIsToldOfLostFrames) {
    Node server{address, 3};
    std::atomic<bool> in_servant = false;
    std::atomic<bool> release = false;
    TestServant servant{{{7, [&](ServerCall& call) {
                              in_servant = true;
                              wait_until([&] { return release.load(); });
                              nothing(call);
                          }}}};
    server->root_poa().activate_object_with_id(1, servant);
    Node client{address, 5};
    CallInProgress call{client.object_on(3)};
    ASSERT_TRUE(wait_until([&] { return in_servant.load(); }));
    // Void calls to node 3, by node 6: more than a socket's buffer has room for.
    RawSocket flood{interface};
    constexpr unsigned count = 5000;
    for (unsigned i = 0; i < count; ++i) {
        const std::array<std::uint8_t, 8> request{
            0x10, 0x00, 0x05, static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i),
            0x18, 0x01, 0x07};
        flood.send(0b1'00011'00110, request);
    }
    release = true;
    EXPECT_EQ(call.end().error, std::nullopt);
    EXPECT_TRUE(wait_until([&] { return !server.events(Event::Kind::frames_lost).empty(); }));
    const auto accounted_for = [&] {
        const Counters counters = server->counters();
        return counters[Counter::frames_received] + counters[Counter::frames_lost_by_link];
    };
    EXPECT_TRUE(wait_until([&] { return accounted_for() >= count + 1; })) << accounted_for();
    EXPECT_GT(server->counters()[Counter::frames_received], 0U);
    // And it works on.
    EXPECT_TRUE(client.object_on(3).invoke(7, {}).empty());
}

/// Frames that went through an interface of a real driver; `what` is tx or rx.
unsigned packets(const std::string& interface, const std::string& what) {
    std::ifstream file{"/sys/class/net/" + interface + "/statistics/" + what + "_packets"};
    unsigned count = 0;
    file >> count;
    return count;
}

// What a node sends is confirmed by what it receives; and the more so when it receives too much.
TEST(Overrun, DoesNotSwallowConfirmations) {
    const std::optional<Interfaces> pair = can_pair();
    if (!pair) GTEST_SKIP() << "CANORB_TEST_CAN_PAIR names no interfaces";
    Node server{"socketcan:" + pair->second, 3};
    TestServant servant{{{7, nothing}}};
    server->root_poa().activate_object_with_id(1, servant);
    RawSocket observer{pair->second};
    observer.accept_only(0b0'00101'00101);  // to group 5 from node 5
    unsigned seen = 0;
    const auto look = [&] {
        while (observer.receive_within(0ms)) ++seen;
    };

    // Nobody runs its event loop, so that it reads when this test says so.
    const std::unique_ptr<Bus> bus = open_bus("socketcan:" + pair->first);
    OrbOptions options;
    options.node = 5;
    options.inter_frame_timeout = 30s;
    options.log = [](std::string_view) {};
    Orb orb{*bus, options};
    orb.poll();

    // Replies to node 5 from node 6, to calls that it never made: more than it has room for.
    const unsigned received = packets(pair->first, "rx");
    RawSocket flood{pair->second};
    constexpr unsigned count = 5000;
    for (unsigned i = 0; i < count; ++i) {
        const std::array<std::uint8_t, 6> reply{
            0x11, 0x00, 0x03, static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i), 0};
        flood.send(0b1'00101'00110, reply);
    }
    ASSERT_TRUE(wait_until([&] { return packets(pair->first, "rx") - received >= count; }));

    // As many frames of a longer message as it hands over at once go out while there is no room.
    const unsigned sent = packets(pair->first, "tx");
    const ObjectRef group = orb.group_reference(GroupId{5});
    group.invoke(7, std::vector<std::uint8_t>(20));
    ASSERT_TRUE(wait_until([&] { return packets(pair->first, "tx") - sent >= 2; }));
    EXPECT_EQ(orb.counters()[Counter::frames_received], 0U) << "it has read, and made room";

    // The rest of it, other calls and the answer to a two-way call follow without a pause. A
    // transmission whose confirmation is missing would hold its place for 5 s.
    constexpr int more = 10;
    const auto begin = CallInProgress::Clock::now();
    for (int i = 0; i < more; ++i) group.invoke(7, {});
    const ObjectRef target = orb.string_to_object("corbaloc:caniop:3/1");
    EXPECT_TRUE(target.with_timeout(20s).invoke(7, {}).empty());
    EXPECT_LT(CallInProgress::Clock::now() - begin, 3s);
    EXPECT_TRUE(wait_until([&] {
        orb.poll();
        return orb.counters()[Counter::messages_sent] >= more + 2U;
    }));
    EXPECT_LT(CallInProgress::Clock::now() - begin, 3s);
    look();
    EXPECT_EQ(orb.counters()[Counter::messages_failed], 0U);
    EXPECT_EQ(orb.counters()[Counter::frames_sent], seen + 1U);
    EXPECT_GE(seen, 2U + more);
    EXPECT_GT(orb.counters()[Counter::frames_lost_by_link], 0U) << "there was no overrun";
}

// Events of its own transmissions do not keep a node from what it receives.
TEST_F(Errors, BusySenderReceives) {
    const std::unique_ptr<Bus> bus = open_bus(address);
    OrbOptions options;
    options.node = 3;
    options.log = [](std::string_view) {};
    Orb orb{*bus, options};
    TestServant servant{{{7, nothing}}};
    orb.root_poa().activate_object_with_id(1, servant);
    const ObjectRef group = orb.group_reference(GroupId{5});
    RawSocket peer{interface};
    peer.accept_only(0x7FF);
    constexpr int count = 20;
    for (std::uint8_t i = 0; i < 10 * count; ++i) {
        if (i % 10 == 0) {
            // A void call to node 3 from node 6.
            const std::array<std::uint8_t, 8> request{0x10, 0x00, 0x05, 0x00, i, 0x18, 0x01, 0x07};
            peer.send(0b1'00011'00110, request);
        }
        group.invoke(7, {});
        orb.poll();
    }
    EXPECT_EQ(servant.calls, count);
    EXPECT_EQ(orb.counters()[Counter::frames_lost_by_link], 0U);
}

}  // namespace
}  // namespace canorb::test
