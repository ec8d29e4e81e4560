// One call of the tank, followed through every layer: node B, number 2, tells group 3 that the
// level is 1234 mm. Each step takes what the one before gave, and says which octets these are.

#include <gtest/gtest.h>

#include <algorithm>

#include "canorb/orb.hpp"
#include "canorb/simulation.hpp"
#include "canorb/stub.hpp"
#include "orb/caniop/filters.hpp"
#include "orb/caniop/identifier.hpp"
#include "orb/caniop/reassembler.hpp"
#include "orb/caniop/segmenter.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
#include "orb/core/engine.hpp"
#include "orb/giop/format.hpp"
#include "orb/giop/message.hpp"
#include "orb/poa/servant.hpp"
#include "tests/support/octets.hpp"

namespace {

using namespace std::chrono_literals;
using canorb::test::hex;
using canorb::test::octets;

// interface Measurement { oneway void level(in unsigned short millimetres); ... };
constexpr canorb::InterfaceInfo measurement{"IDL:Tank/Measurement:1.0"};
constexpr canorb::OperationInfo level{&measurement, 0, "level", true, true};

constexpr canorb::GroupId group{3};
constexpr canorb::NodeId node_a{1};
constexpr canorb::NodeId node_b{2};

class Display final : public canorb::Servant {
  public:
    const canorb::InterfaceInfo& _interface_info() const override { return measurement; }
    void _dispatch(canorb::ServerCall& call) override {
        if (call.operation() != level.id) return;
        call.oneway();
        std::uint16_t value{};
        if (call.read(value)) millimetres = value;
    }
    int millimetres = -1;
};

constexpr std::string_view request =
    "10"     // Request, version 1.0
    "0007"   // message_size: 7 octets follow
    "BEEF"   // request_id
    "4AA0"   // to a group: CRC of IDL:Tank/Measurement:1.0
    "00"     // operation 0: level
    "84D2";  // 1234: bits 10, then 14 bits of payload
constexpr std::string_view first_frame = "100007BEEF4AA000";
constexpr std::string_view second_frame = "8184D2";  // sequence number 1, the last two octets
constexpr std::uint32_t can_id = 0b0'00011'00010;    // group message, group 3, from node 2

TEST(Story, DownFromTheStubToTheBus) {
    // ccdr: the parameter.
    std::array<std::uint8_t, 32> buffer{};
    canorb::ccdr::Encoder parameters{
        canorb::MutableBytes{buffer}.subspan(canorb::giop::request_header_size)};
    encode(parameters, std::uint16_t{1234});
    ASSERT_TRUE(parameters.error() == canorb::ccdr::EncodeError::none);
    EXPECT_EQ(hex(parameters.octets()), "84D2");

    // giop: the message.
    canorb::giop::write_request_header(
        canorb::MutableBytes{buffer}.first<canorb::giop::request_header_size>(), 0xBEEF,
        measurement.group_key(), level.id, parameters.size());
    const auto message =
        canorb::Bytes{buffer}.first(canorb::giop::request_header_size + parameters.size());
    EXPECT_EQ(hex(message), request);

    // caniop: the identifier and the frames.
    const auto to = canorb::caniop::Identifier::to_group(group, node_b);
    EXPECT_EQ(to.can_id(), can_id);
    ASSERT_EQ(canorb::caniop::frame_count(message.size()), 2U);
    const auto first = canorb::caniop::cut_frame(to, message, 0);
    const auto second = canorb::caniop::cut_frame(to, message, 1);
    EXPECT_EQ(first.id, can_id);
    EXPECT_EQ(hex(first.payload()), first_frame);
    EXPECT_EQ(second.id, can_id);
    EXPECT_EQ(hex(second.payload()), second_frame);
}

canorb::can::Frame frame(std::string_view payload) {
    const auto data = octets(payload);
    canorb::can::Frame frame;
    frame.id = can_id;
    frame.length = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data.begin());
    return frame;
}

TEST(Story, UpFromTheBusToTheServant) {
    const canorb::can::Frame frames[] = {frame(first_frame), frame(second_frame)};

    // caniop: the filters of node A, which is in groups 1 and 3.
    const canorb::GroupId groups[] = {canorb::GroupId{1}, group};
    const auto exact = canorb::caniop::exact_filters(node_a, groups);
    ASSERT_EQ(exact.size(), 3U);
    EXPECT_EQ(exact.span()[0].mask, 0b1'11111'00000U);
    EXPECT_EQ(exact.span()[0].value, 0b1'00001'00000U);  // to node 1
    EXPECT_EQ(exact.span()[1].value, 0b0'00001'00000U);  // to group 1
    EXPECT_EQ(exact.span()[2].value, 0b0'00011'00000U);  // to group 3
    EXPECT_TRUE(exact.span()[2].accepts(frames[0]));
    EXPECT_FALSE(exact.span()[0].accepts(frames[0]));
    const auto basic = canorb::caniop::mask_filters(node_a, groups);
    ASSERT_EQ(basic.size(), 2U);
    EXPECT_EQ(basic.span()[1].mask, 0b1'11101'00000U);  // 00001 and 00011 differ in one bit
    EXPECT_EQ(basic.span()[1].value, 0b0'00001'00000U);
    EXPECT_TRUE(basic.span()[1].accepts(frames[0]));

    // caniop: the message is whole with the second frame.
    canorb::Counters counters;
    canorb::caniop::Reassembler reassembler{
        {}, {canorb::giop::header_size, canorb::giop::message_length}, counters};
    std::vector<std::uint8_t> message;
    for (const canorb::can::Frame& received : frames) {
        EXPECT_TRUE(message.empty());
        const auto admitted = canorb::caniop::admit(received, node_a, groups);
        const auto* from = std::get_if<canorb::caniop::Identifier>(&admitted);
        ASSERT_NE(from, nullptr);
        EXPECT_FALSE(from->peer_to_peer);
        EXPECT_EQ(from->sender, 2);
        const auto reception = reassembler.accept(*from, received.payload(), canorb::TimePoint{});
        if (const auto* whole = std::get_if<canorb::caniop::Message>(&reception)) {
            message.assign(whole->octets.begin(), whole->octets.end());
        }
    }
    EXPECT_EQ(hex(message), request);

    // giop: the Request.
    const auto parsed = canorb::giop::parse(message);
    ASSERT_TRUE(parsed.has_value());
    const auto* call = std::get_if<canorb::giop::Request>(&*parsed);
    ASSERT_NE(call, nullptr);
    EXPECT_EQ(call->id, 0xBEEF);
    EXPECT_EQ(call->object_key, 0x4AA0);
    EXPECT_EQ(call->operation, 0);
    EXPECT_EQ(hex(call->parameters), "84D2");

    // mca: the member with that interface.
    Display display;
    canorb::mca::MulticastAgent agent;
    ASSERT_TRUE(agent.join(group, {1024, &display._interface_info()}));
    ASSERT_EQ(agent.members(group).size(), 1U);
    EXPECT_TRUE(agent.members(group)[0].interface->has_group_key(call->object_key));

    // poa and the skeleton: the servant, and the parameter once more.
    canorb::ServerCall server_call{call->operation, canorb::ccdr::Decoder{call->parameters},
                                   canorb::MutableBytes{}};
    canorb::poa::dispatch(display, server_call);
    EXPECT_EQ(display.millimetres, 1234);
    EXPECT_EQ(server_call.outcome(), canorb::ServerCall::Outcome::none);  // nobody answers
}

// The joint between the two halves: frames in, a Request for servants out.
TEST(Story, ThroughTheEngine) {
    Display display;
    canorb::core::EngineOptions options;
    options.node = node_a;
    canorb::core::Engine engine{options};
    const auto index = engine.adapter().activate(canorb::poa::root_poa, display);
    ASSERT_TRUE(index.ok());
    ASSERT_TRUE(engine.join(group, {*index, &display._interface_info()}));
    for (const auto payload : {first_frame, second_frame}) {
        EXPECT_FALSE(engine.has_request());
        engine.on_event(canorb::can::Received{frame(payload), canorb::TimePoint{}},
                        canorb::TimePoint{});
    }
    const auto incoming = engine.next_request(canorb::TimePoint{});
    ASSERT_TRUE(incoming.has_value());
    EXPECT_TRUE(incoming->group == group);
    EXPECT_EQ(incoming->interface_key, 0x4AA0);
    EXPECT_EQ(incoming->operation, 0);
    EXPECT_EQ(hex(incoming->parameters), "84D2");
    EXPECT_TRUE(std::holds_alternative<canorb::core::NoAnswer>(incoming->answer_to));
    EXPECT_FALSE(engine.next_frame(canorb::TimePoint{}).has_value());
}

// And all of it at once, as an application sees it.
TEST(Story, FromOneOrbToTheOther) {
    canorb::Simulation simulation;
    auto& bus = simulation.add_bus({.bitrate = 500'000});
    std::vector<canorb::can::Frame> seen;
    bus.on_frame(
        [&](const canorb::can::Frame& on_bus, canorb::TimePoint) { seen.push_back(on_bus); });
    Display display;
    canorb::Orb a{bus, {.node = 1}};
    canorb::Orb b{bus, {.node = 2}};
    a.object_join(a.root_poa().activate_object(display), group);

    const canorb::ObjectRef displays = b.string_to_object("corbaloc:caniop:group/3");
    canorb::ClientCall call{displays, level};
    call.write(std::uint16_t{1234});
    call.invoke();
    simulation.run_for(1ms);

    EXPECT_EQ(display.millimetres, 1234);
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_EQ(seen[0].id, can_id);
    std::string payload = hex(seen[0].payload());
    payload.replace(6, 4, "BEEF");  // the request id: wherever this ORB began to count
    EXPECT_EQ(payload, first_frame);
    EXPECT_EQ(seen[1].id, can_id);
    EXPECT_EQ(hex(seen[1].payload()), second_frame);
}

}  // namespace
