#include "orb/can/sim/bus.hpp"

#include <gtest/gtest.h>

#include "tests/can/bus_fixture.hpp"

namespace canorb::can::sim::test {
namespace {

using Ids = std::vector<std::uint32_t>;

// Lengths by hand (frame_length_test.cpp): 0x555 without data is 48 bits, 0x123#DEADBEEF 81,
// 0x000 with 8 zeros 127; each with the 3 bits of intermission.
constexpr std::int64_t length_555 = 48;
constexpr std::int64_t length_123 = 81;
constexpr std::int64_t length_000 = 127;

TEST(Bus, AQuietBusHasNoEvent) {
    Bus bus{500'000, at(7ms)};
    TestNode node{bus};
    EXPECT_EQ(bus.next_event(), never);
    EXPECT_FALSE(bus.advance_one());
    EXPECT_EQ(bus.now(), at(7ms));
    bus.advance(at(9ms));
    EXPECT_EQ(bus.now(), at(9ms));
    bus.advance(at(8ms));
    EXPECT_EQ(bus.now(), at(9ms)) << "time does not go back";
}

TEST(Bus, AFrameBeginsAtOnceOnAnIdleBusAndEndsWithEof) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode receiver{bus};
    bus.advance(at(1ms));
    sender.must_send(standard(0x123, "DEADBEEF"));
    const TimePoint end = at(1ms) + bits(length_123 - 3);
    EXPECT_EQ(bus.next_event(), end);
    bus.advance(end - 1ns);
    EXPECT_FALSE(receiver.has_event());
    EXPECT_FALSE(sender.has_event());
    bus.advance(end);
    sender.drain();
    receiver.drain();
    ASSERT_EQ(receiver.received.size(), 1U);
    EXPECT_EQ(receiver.received[0].time, end);
    EXPECT_EQ(receiver.received[0].frame, standard(0x123, "DEADBEEF"));
    ASSERT_EQ(sender.results.size(), 1U);
    EXPECT_EQ(sender.results[0].time, end);
    EXPECT_EQ(bus.next_event(), never);
}

TEST(Bus, TheNextFrameBeginsAfterTheIntermission) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode receiver{bus};
    sender.must_send(standard(0x555));
    bus.advance(at(bits(length_555 - 3)));
    // In the intermission the bus is not free yet.
    bus.advance(at(bits(length_555 - 1)));
    sender.must_send(standard(0x555));
    EXPECT_EQ(bus.next_event(), at(bits(2 * length_555 - 3)));
}

TEST(Bus, AFrameSubmittedWhileTheBusIsBusyWaits) {
    Bus bus{500'000};
    TestNode first{bus};
    TestNode second{bus};
    first.must_send(standard(0x7EF));
    bus.advance(at(bits(1)));
    second.must_send(standard(0x001));
    run_until_quiet(bus);
    EXPECT_EQ(second.received_ids(), Ids{0x7EF});
    EXPECT_EQ(first.received_ids(), Ids{0x001});
    EXPECT_GT(first.received[0].time, second.received[0].time);
}

TEST(Bus, NodesThatSubmitAtTheSameMomentArbitrate) {
    Bus bus{500'000};
    TestNode first{bus};
    TestNode second{bus};
    TestNode receiver{bus};
    first.must_send(standard(0x300));
    second.must_send(standard(0x200));
    first.must_send(standard(0x100));
    run_until_quiet(bus);
    EXPECT_EQ(receiver.received_ids(), (Ids{0x100, 0x200, 0x300}));
}

TEST(Bus, ALosersFrameCompetesAgain) {
    Bus bus{500'000};
    TestNode loser{bus};
    TestNode winner{bus};
    TestNode receiver{bus};
    loser.must_send(standard(0x400));
    for (int i = 0; i < 5; ++i) winner.must_send(standard(0x100));
    run_until_quiet(bus);
    EXPECT_EQ(receiver.received_ids(), (Ids{0x100, 0x100, 0x100, 0x100, 0x100, 0x400}));
}

TEST(Bus, AReplySubmittedAtTheEndOfEofTakesPartInTheNextArbitration) {
    Bus bus{500'000};
    TestNode client{bus};
    TestNode server{bus};
    client.must_send(standard(0x555));
    client.must_send(standard(0x600));
    bus.advance_one();
    server.must_send(standard(0x500));
    run_until_quiet(bus);
    EXPECT_EQ(client.received_ids(), Ids{0x500});
    server.drain();
    ASSERT_EQ(server.received.size(), 2U);
    EXPECT_LT(client.received[0].time, server.received[1].time);
}

TEST(Bus, KeepsTheOrderWithinAnIdentifierOfANode) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode receiver{bus};
    for (const auto* data : {"03", "01", "02"}) sender.must_send(standard(0x100, data));
    run_until_quiet(bus);
    receiver.drain();
    ASSERT_EQ(receiver.received.size(), 3U);
    EXPECT_EQ(receiver.received[0].frame.data[0], 3);
    EXPECT_EQ(receiver.received[1].frame.data[0], 1);
    EXPECT_EQ(receiver.received[2].frame.data[0], 2);
}

TEST(Bus, TheSameFrameFromTwoNodesIsSentAsOne) {
    Bus bus{500'000};
    TestNode first{bus};
    TestNode second{bus};
    TestNode receiver{bus};
    first.must_send(standard(0x123, "DEADBEEF"));
    second.must_send(standard(0x123, "DEADBEEF"));
    run_until_quiet(bus);
    EXPECT_EQ(bus.now(), at(bits(length_123 - 3)));
    for (TestNode* node : {&first, &second}) {
        node->drain();
        ASSERT_EQ(node->results.size(), 1U);
        EXPECT_EQ(node->results[0].outcome, TransmitOutcome::sent);
        EXPECT_TRUE(node->received.empty());
    }
    EXPECT_EQ(receiver.received_ids(), Ids{0x123});
}

TEST(Bus, CountsBitsSoThatNoRoundingErrorGrows) {
    // A bit is 1'000'000'000 / 83'333 ns: not a whole number.
    Bus bus{83'333};
    TestNode sender{bus};
    TestNode receiver{bus};
    constexpr std::int64_t frames = 20'000;
    for (std::int64_t i = 0; i < frames; ++i) {
        sender.must_send(standard(0x555));
        sender.drain();
        receiver.drain();
        if (i == 0) continue;
        ASSERT_TRUE(bus.advance_one());  // one frame is always waiting: the bus is never idle
    }
    ASSERT_TRUE(bus.advance_one());
    const std::int64_t total_bits = frames * length_555 - 3;
    EXPECT_EQ(bus.now(), at(Duration{total_bits * 1'000'000'000 / 83'333}));
}

TEST(Bus, HoldsAtEveryBitrate) {
    for (const std::uint32_t bitrate : {10'000U, 125'000U, 1'000'000U}) {
        Bus bus{bitrate};
        TestNode sender{bus};
        TestNode receiver{bus};
        sender.must_send(standard(0x000, "0000000000000000"));
        run_until_quiet(bus);
        EXPECT_EQ(bus.now(), at((length_000 - 3) * 1'000'000'000ns / bitrate));
    }
}

TEST(Bus, TracesEveryCompletedFrame) {
    Bus bus{500'000};
    TestNode first{bus};
    TestNode second{bus};
    std::vector<CompletedFrame> log;
    bus.set_trace([&](const CompletedFrame& frame) { log.push_back(frame); });
    second.must_send(standard(0x555));
    run_until_quiet(bus);
    ASSERT_EQ(log.size(), 1U);
    EXPECT_EQ(log[0].frame, standard(0x555));
    EXPECT_EQ(log[0].time, at(bits(length_555 - 3)));
    EXPECT_EQ(log[0].sender, second.node());
}

TEST(Bus, ANodeAttachedDuringAFrameDoesNotReceiveIt) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode receiver{bus};
    sender.must_send(standard(0x100));
    bus.advance(at(bits(10)));
    TestNode late{bus};
    sender.must_send(standard(0x200));
    run_until_quiet(bus);
    EXPECT_EQ(late.received_ids(), Ids{0x200});
    EXPECT_EQ(receiver.received_ids(), (Ids{0x100, 0x200}));
}

TEST(Bus, AFrameOnTheBusGoesOutThoughItsSenderIsDetached) {
    Bus bus{500'000};
    TestNode receiver{bus};
    {
        TestNode sender{bus};
        sender.must_send(standard(0x100));
        sender.must_send(standard(0x200));
        bus.advance(at(bits(10)));
    }
    TestNode successor{bus};  // in its place
    run_until_quiet(bus);
    EXPECT_EQ(receiver.received_ids(), Ids{0x100});
    EXPECT_FALSE(successor.has_event());
}

TEST(Bus, ALostReceiverMayComeBackLate) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode slow{bus, {.mailboxes = 8, .receive_capacity = 3}};
    for (std::uint32_t i = 0; i < 8; ++i) sender.must_send(standard(0x100 + i));
    run_until_quiet(bus);
    EXPECT_EQ(slow.received_ids(), (Ids{0x100, 0x101, 0x102}));
    EXPECT_EQ(slow.lost, 5U);
}

TEST(Bus, AMailboxIsFreeWhenItsResultWasTaken) {
    Bus bus{500'000};
    TestNode sender{bus, {.mailboxes = 1}};
    TestNode receiver{bus};
    sender.must_send(standard(0x100));
    EXPECT_EQ(sender.send(standard(0x100)), SendResult{SendError::full});
    run_until_quiet(bus);
    EXPECT_EQ(sender.send(standard(0x100)), SendResult{SendError::full});
    sender.drain();
    sender.must_send(standard(0x100));
}

TEST(Bus, AnAbortOfTheFrameOnTheBusComesTooLate) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode receiver{bus};
    const TransmitHandle handle = sender.must_send(standard(0x100));
    bus.advance(at(bits(1)));
    sender.abort(handle);
    run_until_quiet(bus);
    sender.drain();
    ASSERT_EQ(sender.results.size(), 1U);
    EXPECT_EQ(sender.results[0].outcome, TransmitOutcome::sent);
}

TEST(Bus, AnAbortAtTheMomentOfSubmissionIsInTime) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode receiver{bus};
    sender.abort(sender.must_send(standard(0x100)));
    EXPECT_EQ(bus.next_event(), never);
    sender.drain();
    ASSERT_EQ(sender.results.size(), 1U);
    EXPECT_EQ(sender.results[0].outcome, TransmitOutcome::aborted);
}

TEST(Bus, ABasicCanControllerTakesTwoFilters) {
    Bus bus{500'000};
    TestNode node{bus, {.filter_list = 0}};
    EXPECT_EQ(node.capabilities().filter_list, 0U);
    EXPECT_TRUE(node.set_filters(std::array<Filter, 2>{}));
    EXPECT_FALSE(node.set_filters(std::array<Filter, 3>{}));
}

TEST(Bus, AnAdvanceOverManyFramesIsTheSameAsOneByOne) {
    const auto run = [](Duration step) {
        Bus bus{500'000};
        TestNode first{bus};
        TestNode second{bus};
        for (std::uint32_t i = 0; i < 8; ++i) {
            first.must_send(standard(0x101 + 2 * i, "0102"));
            second.must_send(standard(0x10E - 2 * i));
        }
        while (bus.next_event() != never) bus.advance(bus.now() + step);
        std::vector<std::pair<std::uint32_t, TimePoint>> log;
        first.drain();
        second.drain();
        for (const Received& each : first.received) log.emplace_back(each.frame.id, each.time);
        for (const Received& each : second.received) log.emplace_back(each.frame.id, each.time);
        return log;
    };
    const auto log = run(1ns * 1'000'000'000);
    EXPECT_EQ(log.size(), 16U);
    EXPECT_EQ(run(700ns), log);
    EXPECT_EQ(run(100us), log);
}

}  // namespace
}  // namespace canorb::can::sim::test
