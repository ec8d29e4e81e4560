// The Orb behind serial adapters that are nodes of one bus.

#include <filesystem>
#include <thread>

#include "tests/can/slcan_adapter.hpp"
#include "tests/can/temporary_directory.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class BehindAdapters : public testing::Test {
  protected:
    OrbOptions node(int number) {
        OrbOptions options;
        options.node = number;
        options.default_timeout = 20s;
        options.inter_frame_timeout = 10s;  // threads may be kept waiting on a busy machine
        options.inter_frame_timeout = 20s;  // a loaded machine may stop a thread for long
        options.log = [](std::string_view) {};
        return options;
    }
    static ObjectRef object_of(int node, Orb& caller) {
        return caller.string_to_object("corbaloc:caniop:" + std::to_string(node) + "/1");
    }
    static std::unique_ptr<can::test::SlcanAdapter> adapter() {
        return std::make_unique<can::test::SlcanAdapter>("local:behind-adapters");
    }
};

TEST_F(BehindAdapters, NodesCallEachOther) {
    const auto adapter_a = adapter();
    const auto adapter_b = adapter();
    const auto bus_a = open_bus("slcan:" + adapter_a->device());
    const auto bus_b = open_bus("slcan:" + adapter_b->device() + "?bitrate=500000");
    Orb a{*bus_a, node(1)};
    Orb b{*bus_b, node(2)};
    TestServant servant_a{{{1, echo}}};
    TestServant servant_b{{{1, echo}}};
    a.root_poa().activate_object_with_id(1, servant_a);
    b.root_poa().activate_object_with_id(1, servant_b);
    const std::vector<std::uint8_t> octets(300, 7);
    const auto call = [&](Orb& client, Orb& server, int server_node) {
        std::thread loop{[&] { server.run(); }};
        const ObjectRef target = object_of(server_node, client);
        for (int i = 0; i < 10; ++i) EXPECT_EQ(target.invoke(1, octets), octets);
        server.shutdown();
        loop.join();
    };
    call(b, a, 1);
    call(a, b, 2);
}

TEST_F(BehindAdapters, PullingOneOutFailsTheCallAndItComesBack) {
    const can::test::TemporaryDirectory directory;
    const std::string device = directory.path() + "/adapter";
    auto adapter_b = adapter();
    std::filesystem::create_symlink(adapter_b->device(), device);
    const auto adapter_a = adapter();
    const auto bus_a = open_bus("slcan:" + adapter_a->device());
    const auto bus_b = open_bus("slcan:" + device);
    Orb server{*bus_a, node(1)};
    TestServant servant{{{0, nothing}}};
    server.root_poa().activate_object_with_id(1, servant);
    Orb client{*bus_b, node(2)};
    std::vector<std::string> events;
    client.on_event([&](const Event& event) { events.push_back(event.text); });

    // Nobody runs the server's loop: the call is out there when the adapter goes.
    std::thread hand;
    const ObjectRef target =
        object_of(1, client).with_sent([&] { hand = std::thread{[&] { adapter_b.reset(); }}; });
    EXPECT_EQ(error_of([&] { target.invoke(0, {}); }),
              (SystemError{SystemErrorKind::comm_failure, Completion::maybe, 6}));
    hand.join();
    client.poll();
    ASSERT_EQ(events.size(), 1U);
    EXPECT_THAT(events[0], testing::HasSubstr("the CAN controller is stopped"));
    EXPECT_THAT(events[0], testing::HasSubstr("plug the adapter in again"));

    adapter_b = adapter();
    std::filesystem::remove(device);
    std::filesystem::create_symlink(adapter_b->device(), device);
    while (events.size() < 2) client.run_for(1ms);
    EXPECT_THAT(events[1], testing::HasSubstr("error active"));
    std::thread loop{[&] { server.run(); }};
    object_of(1, client).invoke(0, {});
    server.shutdown();
    loop.join();
}

}  // namespace
}  // namespace canorb::test
