// The engine and its link: filters, frames that are not for it, lost frames, bus-off, notices.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/core/test_engine.hpp"

namespace canorb::core {
namespace {

using namespace test;
using can::ControllerState;
using can::TransmitOutcome;
using testing::ElementsAre;
using testing::IsEmpty;

// ---- the link goes down

class LinkDown : public testing::TestWithParam<ControllerState> {};

TEST_P(LinkDown, FailsWhatIsUnderWayAndRefusesWhatIsNew) {
    TestEngine node;
    const CallHandle answer_awaited = node.call("1801", 1);
    node.transmit();
    const CallHandle partly_sent = node.call("1801", 2, "000102030405060708090A0B0C0D");
    EXPECT_EQ(node.hand_over().size(), 2U);
    node.finish_frame();
    const CallHandle not_begun = node.call("1801", 3);
    const CallHandle own = node.call("2801", 4);
    EXPECT_EQ(node.send("1801", 5), "queued");
    node.counted();
    node.notices();

    node.state(GetParam());
    EXPECT_EQ(node.result(answer_awaited), "COMM_FAILURE MAYBE 6");
    EXPECT_EQ(node.result(partly_sent), "COMM_FAILURE MAYBE 6");
    EXPECT_EQ(node.result(not_begun), "COMM_FAILURE NO 5");
    EXPECT_EQ(node.result(own), "waiting");
    EXPECT_EQ(node.counted(), (Counted{{"messages_failed", 3}}));
    EXPECT_THAT(node.notices(),
                ElementsAre("dropped", "dropped", "dropped", can::name(GetParam())));

    EXPECT_EQ(describe(node.try_call("1801").error()), "COMM_FAILURE NO 4");
    EXPECT_EQ(node.send("1801"), "COMM_FAILURE NO 4");
    EXPECT_EQ(node.multicast(7), "COMM_FAILURE NO 4");
    EXPECT_THAT(node.hand_over(), IsEmpty());
    EXPECT_EQ(node.aborted.size(), 1U);
    EXPECT_EQ(node.engine.queued_messages(), 0U);
    node.finish_frame(TransmitOutcome::failed);

    // Objects of this node need no link.
    EXPECT_THAT(node.requests(), ElementsAre("object 1 operation 4 "));
    node.answer();
    EXPECT_EQ(node.result(own), "NO_EXCEPTION ");

    // Nothing of what was queued is sent after recovery.
    node.state(ControllerState::error_active);
    EXPECT_THAT(node.transmit(), IsEmpty());
    const CallHandle next = node.call("1801", 6);
    EXPECT_THAT(node.transmit(), ElementsAre("465 100005ABD1180106"));
    node.receive("4A3 110003ABD100");
    EXPECT_EQ(node.result(next), "NO_EXCEPTION ");
    EXPECT_EQ(node.engine.next_deadline(), never);
}

INSTANTIATE_TEST_SUITE_P(States, LinkDown,
                         testing::Values(ControllerState::bus_off, ControllerState::stopped),
                         [](const auto& param) {
                             return std::string{
                                 param.param == ControllerState::bus_off ? "BusOff" : "Stopped"};
                         });

// Others may have it: a receiver takes a frame one bit before its sender knows.
TEST(Link, AFrameInTheControllerThatWasNotConfirmedIsMaybe) {
    TestEngine node;
    const CallHandle call = node.call("1801");
    EXPECT_EQ(node.hand_over().size(), 1U);
    node.state(ControllerState::bus_off);
    EXPECT_EQ(node.result(call), "COMM_FAILURE MAYBE 6");
}

TEST(Link, ErrorPassiveIsOnlyTold) {
    TestEngine node;
    const CallHandle call = node.call("1801");
    node.state(ControllerState::error_passive);
    EXPECT_THAT(node.notices(), ElementsAre("error passive"));
    EXPECT_EQ(node.result(call), "waiting");
    EXPECT_EQ(node.transmit().size(), 1U);
}

TEST(Link, AFrameThatTheControllerFailsFailsItsCall) {
    TestEngine node;
    const CallHandle one_frame = node.call("1801");
    EXPECT_EQ(node.hand_over().size(), 1U);
    node.finish_frame(TransmitOutcome::failed);
    EXPECT_EQ(node.result(one_frame), "COMM_FAILURE MAYBE 6");

    const CallHandle three_frames = node.call("1801", 2, "000102030405060708090A0B0C0D");
    EXPECT_EQ(node.hand_over().size(), 2U);
    node.finish_frame();
    node.finish_frame(TransmitOutcome::aborted);
    EXPECT_EQ(node.result(three_frames), "COMM_FAILURE MAYBE 6");
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_EQ(node.counted(), (Counted{{"frames_sent", 1}, {"messages_failed", 2}}));
    EXPECT_THAT(node.notices(), ElementsAre("dropped", "dropped"));
}

TEST(Link, PartialMessagesAreNotContinuedAfterBusOff) {
    TestEngine node;
    const Texts frames = frames_of("4A3",
                                   "100007"
                                   "1234"
                                   "2801"
                                   "02"
                                   "0102");
    node.receive(frames[0]);
    node.state(ControllerState::bus_off);
    node.state(ControllerState::error_active);
    node.receive(frames[1]);
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_EQ(node.counted(), (Counted{{"frames_received", 2},
                                       {"partials_lost_with_frames", 1},
                                       {"continuations_without_message", 1}}));
}

Texts request_of_two_frames() {
    return frames_of("4A3",
                     "100007"
                     "1234"
                     "2801"
                     "02"
                     "0102");
}

TEST(Link, LostFramesDropPartialMessages) {
    TestEngine node;
    const Texts frames = request_of_two_frames();
    node.receive(frames[0]);
    node.event(can::FramesLost{3, node.now});
    node.receive(frames[1]);
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_EQ(node.counted(), (Counted{{"frames_received", 2},
                                       {"frames_lost_by_link", 3},
                                       {"partials_lost_with_frames", 1},
                                       {"continuations_without_message", 1}}));
    EXPECT_THAT(node.notices(), ElementsAre("lost 3"));
    node.receive(frames);
    EXPECT_EQ(node.requests().size(), 1U);
}

TEST(Link, FramesThatMayBeLostDropPartialMessagesAndAreNotCounted) {
    TestEngine node;
    const Texts frames = request_of_two_frames();
    node.receive(frames[0]);
    node.event(can::FramesLost{0, node.now});
    node.receive(frames[1]);
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_EQ(node.counted(), (Counted{{"frames_received", 2},
                                       {"partials_lost_with_frames", 1},
                                       {"continuations_without_message", 1}}));
    EXPECT_THAT(node.notices(), IsEmpty());
}

// ---- frames that are not for it

TEST(Link, ForeignFramesAreCountedAndIgnored) {
    TestEngine node;
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    const auto receive = [&](std::uint32_t id, void (*change)(can::Frame&)) {
        can::Frame frame = can::Frame::standard(id, octets("1000051234280102"));
        change(frame);
        node.event(can::Received{frame, node.now});
    };
    receive(0x4A3, [](can::Frame& frame) { frame.extended = true; });
    receive(0x4A3, [](can::Frame& frame) { frame.remote = true; });
    receive(0x4A3, [](can::Frame& frame) { frame.error = true; });
    node.receive("7E3 1000051234280102");  // to node 31
    node.receive("4BF 1000051234280102");  // from nobody
    EXPECT_EQ(node.counted(), (Counted{{"frames_not_caniop", 5}}));
    node.receive("4C3 1000051234280102");  // to node 6
    EXPECT_EQ(node.counted(), (Counted{{"frames_for_other_nodes", 1}}));
    node.receive("103 1000051234280102");  // to group 8
    EXPECT_EQ(node.counted(), (Counted{{"frames_of_other_groups", 1}}));
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_THAT(node.notices(), IsEmpty());
}

TEST(Link, ADuplicateNodeIsToldOnceASecond) {
    TestEngine node;
    node.receive("4A5 1000051234280102");
    node.receive("0E5 1000051234280102");
    node.receive("465 1000051234280102");  // whoever the receiver is
    EXPECT_THAT(node.notices(), ElementsAre("duplicate node"));
    node.advance(1s - 1ns);
    node.receive("4A5 1000051234280102");
    EXPECT_THAT(node.notices(), IsEmpty());
    node.advance(1ns);
    node.receive("4A5 1000051234280102");
    EXPECT_THAT(node.notices(), ElementsAre("duplicate node"));
    // What was told was about the other number.
    node.engine.set_node(NodeId{6});
    node.receive("4C6 1000051234300102");
    EXPECT_THAT(node.notices(), ElementsAre("duplicate node"));
    EXPECT_EQ(node.counted(), (Counted{{"frames_of_duplicate_node", 6}}));
    EXPECT_THAT(node.requests(), IsEmpty());
}

// ---- filters

std::vector<can::Filter> filters(TestEngine& node, std::size_t filter_list) {
    can::Capabilities capabilities;
    capabilities.filter_list = filter_list;
    const auto set = node.engine.take_filters(capabilities);
    if (!set) return {};
    return {set->span().begin(), set->span().end()};
}

const can::Filter to_node_5{.mask = 0x7E0, .value = 0x4A0, .data_only = true};
const can::Filter from_node_5{.mask = 0x01F, .value = 0x005, .data_only = true};
const can::Filter to_group_1{.mask = 0x7E0, .value = 0x020, .data_only = true};
const can::Filter to_group_3{.mask = 0x7E0, .value = 0x060, .data_only = true};
const can::Filter to_group_5{.mask = 0x7E0, .value = 0x0A0, .data_only = true};

void join_1_3_and_5(TestEngine& node) {
    for (const std::uint8_t group : {std::uint8_t{1}, std::uint8_t{3}, std::uint8_t{5}}) {
        ASSERT_TRUE(node.engine.join(GroupId{group}, {1, &bell}));
    }
}

TEST(Filters, ExactOnesWhereThereIsRoomElseTheTwoRegisters) {
    TestEngine with_room;
    TestEngine with_less;
    TestEngine with_registers;
    join_1_3_and_5(with_room);
    join_1_3_and_5(with_less);
    join_1_3_and_5(with_registers);
    TestEngine with_room_to_spare;
    join_1_3_and_5(with_room_to_spare);
    EXPECT_THAT(filters(with_room_to_spare, 5),
                ElementsAre(to_node_5, to_group_1, to_group_3, to_group_5, from_node_5));
    EXPECT_THAT(filters(with_room, 4), ElementsAre(to_node_5, to_group_1, to_group_3, to_group_5));
    // The wire documentation's own.
    const can::Filter group_mask{.mask = 0x720, .value = 0x020};
    EXPECT_THAT(filters(with_less, 3), ElementsAre(to_node_5, group_mask));
    EXPECT_THAT(filters(with_registers, 0), ElementsAre(to_node_5, group_mask));
}

TEST(Filters, TheFalsePositivesOfAMaskAreDroppedFrameByFrame) {
    TestEngine node;
    for (const std::uint8_t group : {std::uint8_t{1}, std::uint8_t{3}, std::uint8_t{5}}) {
        ASSERT_TRUE(node.engine.join(GroupId{group}, {1, &bell}));
    }
    node.receive(
        "0E3 1000051234"
        "4DDB"
        "02");  // group 7
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_EQ(node.counted(), (Counted{{"frames_of_other_groups", 1}}));
}

TEST(Filters, AreGivenWhenTheyChangeAndOnlyThen) {
    constexpr std::size_t room = 32;
    TestEngine node;
    EXPECT_THAT(filters(node, room), ElementsAre(to_node_5, from_node_5));
    EXPECT_THAT(filters(node, room), IsEmpty());
    ASSERT_TRUE(node.engine.join(GroupId{3}, {1, &bell}));
    EXPECT_THAT(filters(node, room), ElementsAre(to_node_5, to_group_3, from_node_5));
    // A second member, one that is refused, one of several that leaves, who is no member.
    static constexpr InterfaceInfo other{"IDL:Test/Other:1.0"};
    ASSERT_TRUE(node.engine.join(GroupId{3}, {2, &bell}));
    EXPECT_FALSE(node.engine.join(GroupId{3}, {3, &other}));
    node.engine.leave(GroupId{3}, 1);
    node.engine.leave(GroupId{5}, 2);
    node.engine.set_node(NodeId{5});
    EXPECT_THAT(filters(node, room), IsEmpty());
    ASSERT_TRUE(node.engine.join(GroupId{5}, {2, &bell}));
    EXPECT_THAT(filters(node, room), ElementsAre(to_node_5, to_group_3, to_group_5, from_node_5));
    node.engine.leave(GroupId{3}, 2);
    EXPECT_THAT(filters(node, room), ElementsAre(to_node_5, to_group_5, from_node_5));
    node.engine.set_node(NodeId{6});
    const can::Filter to_node_6{.mask = 0x7E0, .value = 0x4C0, .data_only = true};
    const can::Filter from_node_6{.mask = 0x01F, .value = 0x006, .data_only = true};
    EXPECT_THAT(filters(node, room), ElementsAre(to_node_6, to_group_5, from_node_6));
    node.engine.set_node({});
    EXPECT_THAT(filters(node, room), ElementsAre(to_group_5));
}

TEST(Filters, AnObjectDeactivatedLeavesItsGroups) {
    class Bell final : public poa::Servant {
      public:
        const InterfaceInfo& _interface_info() const override { return bell; }
        void _dispatch(poa::ServerCall&) override {}
    } servant;
    TestEngine node;
    ASSERT_TRUE(node.engine.adapter().activate_with_id(poa::root_poa, 1, servant).ok());
    ASSERT_TRUE(node.engine.join(GroupId{3}, {1, &bell}));
    ASSERT_TRUE(node.engine.join(GroupId{5}, {1, &bell}));
    EXPECT_EQ(filters(node, 32).size(), 4U);
    EXPECT_TRUE(node.engine.deactivate(1));
    EXPECT_THAT(filters(node, 32), ElementsAre(to_node_5, from_node_5));
    EXPECT_EQ(node.engine.adapter().find(1), nullptr);
    EXPECT_FALSE(node.engine.agent().is_member(GroupId{3}, 1));
    EXPECT_FALSE(node.engine.deactivate(1));
    EXPECT_THAT(filters(node, 32), IsEmpty());
}

// ---- notices

TEST(Notices, BeyondWhatIsFetchedAreLostAndCounted) {
    TestEngine node;
    for (int i = 0; i < 1000; ++i) node.state(ControllerState::error_passive);
    const std::size_t kept = node.notices().size();
    EXPECT_GE(kept, 100U);
    EXPECT_EQ(node.counted(), (Counted{{"notices_lost", 1000 - kept}}));
    node.state(ControllerState::error_active);
    EXPECT_THAT(node.notices(), ElementsAre("error active"));
}

TEST(Notices, HaveRoomForALongQueueThatFailsAndForTheReason) {
    EngineOptions options = TestEngine::options();
    options.transmit.max_messages = 1000;
    TestEngine node{options};
    for (int i = 0; i < 1000; ++i) ASSERT_EQ(node.multicast(7), "queued");
    node.state(ControllerState::bus_off);
    const auto notices = node.notices();
    ASSERT_EQ(notices.size(), 1001U);
    EXPECT_EQ(notices.back(), "bus off");
    EXPECT_EQ(node.engine.counters()[Counter::notices_lost], 0U);
}

TEST(Counters, TheOwnerCountsWhatOnlyItSees) {
    TestEngine node;
    node.engine.count(Counter::requests_dispatched);
    EXPECT_EQ(node.counted(), (Counted{{"requests_dispatched", 1}}));
}

}  // namespace
}  // namespace canorb::core
