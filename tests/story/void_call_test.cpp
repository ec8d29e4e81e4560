// The smallest thing that runs end to end: a void call over a bus inside this process, and every
// octet of it as a third controller on that bus sees it.

#include <gtest/gtest.h>
#include <poll.h>

#include <thread>
#include <variant>
#include <vector>

#include "canorb/orb.hpp"
#include "orb/can/link/link.hpp"

namespace {

using namespace std::chrono_literals;

constexpr canorb::InterfaceInfo bell_interface{"IDL:Test/Bell:1.0"};

class Bell final : public canorb::Servant {
  public:
    const canorb::InterfaceInfo& _interface_info() const override { return bell_interface; }
    void _dispatch(canorb::ServerCall& call) override {
        if (call.operation() != 7 || !call.read()) return;
        ++rung;
        call.reply();
    }
    int rung = 0;
};

/// Waits for the next frame on the bus, for as long as a loaded machine may take.
canorb::can::Frame next_frame(canorb::can::Controller& observer) {
    for (;;) {
        while (const auto event = observer.poll()) {
            if (const auto* received = std::get_if<canorb::can::Received>(&*event)) {
                return received->frame;
            }
        }
        pollfd readable{observer.event_fd(), POLLIN, 0};
        if (::poll(&readable, 1, 10'000) <= 0) return {};
    }
}

std::vector<std::uint8_t> octets(const canorb::can::Frame& frame) {
    return {frame.payload().begin(), frame.payload().end()};
}

TEST(VoidCall, IsOneFrameOutAndOneFrameBack) {
    auto link = canorb::can::open_link("local:void-call");
    ASSERT_TRUE(link.ok()) << link.error();
    auto observer = (*link)->attach("observer");
    ASSERT_TRUE(observer.ok()) << observer.error();
    const canorb::can::Filter everything{};
    ASSERT_TRUE((*observer)->set_filters({&everything, 1}));

    const auto bus = canorb::open_bus("local:void-call");
    canorb::Orb server{*bus, {.node = 3}};
    Bell bell;
    server.root_poa().activate_object_with_id(1, bell);
    std::thread server_thread{[&] { server.run(); }};

    canorb::Orb client{*bus, {.node = 5}};
    const auto reference = client.string_to_object("corbaloc:caniop:3/1");
    EXPECT_TRUE(reference.with_timeout(10s).invoke(7, {}).empty());

    const canorb::can::Frame request = next_frame(**observer);
    const canorb::can::Frame reply = next_frame(**observer);
    server.shutdown();
    server_thread.join();
    EXPECT_EQ(bell.rung, 1);

    // Peer to peer (1), to node 3 (00011), from node 5 (00101).
    EXPECT_EQ(request.id, 0b1'00011'00101U);
    ASSERT_EQ(request.length, 8);
    const std::uint8_t id_high = request.data[3];
    const std::uint8_t id_low = request.data[4];
    EXPECT_EQ(octets(request), (std::vector<std::uint8_t>{
                                   0x10,             // Request, version 1.0
                                   0x00, 0x05,       // message_size
                                   id_high, id_low,  // request_id: starts at random
                                   0x18, 0x01,       // object_key: node 3, index 1
                                   0x07,             // operation
                               }));
    EXPECT_EQ(reply.id, 0b1'00101'00011U);
    EXPECT_EQ(octets(reply), (std::vector<std::uint8_t>{
                                 0x11,             // Reply, version 1.0
                                 0x00, 0x03,       // message_size
                                 id_high, id_low,  // request_id
                                 0x00,             // NO_EXCEPTION
                             }));
}

}  // namespace
