// Fault confinement of the simulated bus: lone nodes, collisions, bus-off.

#include <gtest/gtest.h>

#include "tests/can/bus_fixture.hpp"

namespace canorb::can::sim::test {
namespace {

using Ids = std::vector<std::uint32_t>;

std::vector<ControllerState> states_of(TestNode& node) {
    node.drain();
    std::vector<ControllerState> states;
    for (const StateChanged& each : node.states) states.push_back(each.status.state);
    return states;
}

TEST(LoneNode, BecomesErrorPassiveAfterSixteenAttemptsAndThenTheBusIsQuiet) {
    Bus bus{500'000};
    TestNode node{bus};
    node.must_send(standard(0x555));  // 48 bits
    // To the end of the ACK slot 37, error flag 6, delimiter 8: 51, and 3 of intermission.
    for (int attempt = 0; attempt < 16; ++attempt) {
        ASSERT_TRUE(bus.advance_one());
        EXPECT_EQ(bus.now(), at(bits(attempt * 54 + 51)));
        EXPECT_EQ(node.error_status().tec, 8 * (attempt + 1));
    }
    EXPECT_FALSE(bus.advance_one());
    EXPECT_EQ(states_of(node), std::vector{ControllerState::error_passive});
    EXPECT_TRUE(node.results.empty());
}

TEST(LoneNode, SendsFromTheMomentThatSomebodyAcknowledges) {
    Bus bus{500'000};
    TestNode node{bus};
    node.must_send(standard(0x555));
    bus.advance(at(1s));
    TestNode other{bus};
    EXPECT_EQ(bus.next_event(), at(1s) + bits(45));
    run_until_quiet(bus);
    EXPECT_EQ(other.received_ids(), Ids{0x555});
    EXPECT_EQ(node.error_status(), (ErrorStatus{ControllerState::error_active, 127, 0}));
}

TEST(LoneNode, AnAbortEndsItsAttempts) {
    Bus bus{500'000};
    TestNode node{bus};
    const TransmitHandle handle = node.must_send(standard(0x555));
    bus.advance(at(bits(10)));
    node.abort(handle);
    EXPECT_FALSE(node.has_event()) << "it is on the bus";
    run_until_quiet(bus);
    node.drain();
    ASSERT_EQ(node.results.size(), 1U);
    EXPECT_EQ(node.results[0].outcome, TransmitOutcome::aborted);
    EXPECT_EQ(node.error_status().tec, 8);
}

TEST(LoneNode, AOneShotFrameIsTriedOnceEvenWhenErrorPassive) {
    Bus bus{500'000};
    TestNode node{bus};
    node.must_send(standard(0x555));
    run_until_quiet(bus);
    node.must_send(standard(0x100), {.one_shot = true});
    run_until_quiet(bus);
    node.drain();
    ASSERT_EQ(node.results.size(), 1U);
    EXPECT_EQ(node.results[0].outcome, TransmitOutcome::failed);
    EXPECT_EQ(node.error_status().tec, 128);
}

TEST(LoneNode, TwoSendersOfTheSameFrameDoNotAcknowledgeEachOther) {
    Bus bus{500'000};
    TestNode first{bus};
    TestNode second{bus};
    first.must_send(standard(0x100));
    second.must_send(standard(0x100));
    bus.advance_one();
    EXPECT_EQ(first.error_status().tec, 8);
    EXPECT_EQ(second.error_status().tec, 8);
}

TEST(OneShot, FailsWhenItLosesTheArbitration) {
    Bus bus{500'000};
    TestNode loser{bus};
    TestNode winner{bus};
    loser.must_send(standard(0x200), {.one_shot = true});
    winner.must_send(standard(0x100));
    run_until_quiet(bus);
    EXPECT_EQ(loser.received_ids(), Ids{0x100});
    ASSERT_EQ(loser.results.size(), 1U);
    EXPECT_EQ(loser.results[0].outcome, TransmitOutcome::failed);
    EXPECT_EQ(loser.error_status().tec, 0) << "losing is no error";
}

TEST(OneShot, MayWaitForABusyBus) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode other{bus};
    other.must_send(standard(0x100));
    bus.advance(at(bits(1)));
    sender.must_send(standard(0x200), {.one_shot = true});
    run_until_quiet(bus);
    EXPECT_EQ(other.received_ids(), Ids{0x200});
}

// The CAN rules, attempt by attempt: while the sender of the recessive bit is error active it
// destroys the frame for both. At TEC 128 its flag is silent and the dominant frame passes.
TEST(Collision, OfOneIdentifierWithDifferentDataCostsSixteenAttempts) {
    Bus bus{500'000};
    TestNode dominant{bus};
    TestNode recessive{bus};
    TestNode receiver{bus};
    dominant.must_send(standard(0x100, "00"));
    recessive.must_send(standard(0x100, "01"));
    for (int attempt = 1; attempt <= 16; ++attempt) {
        ASSERT_TRUE(bus.advance_one());
        EXPECT_EQ(dominant.error_status().tec, 8 * attempt);
        EXPECT_EQ(recessive.error_status().tec, 8 * attempt);
        EXPECT_EQ(receiver.error_status().rec, attempt);
    }
    EXPECT_FALSE(receiver.has_event());
    ASSERT_TRUE(bus.advance_one());
    EXPECT_EQ(dominant.error_status(), (ErrorStatus{ControllerState::error_active, 127, 0}));
    EXPECT_EQ(recessive.error_status(), (ErrorStatus{ControllerState::error_passive, 136, 0}));
    run_until_quiet(bus);
    receiver.drain();
    ASSERT_EQ(receiver.received.size(), 2U);
    EXPECT_EQ(receiver.received[0].frame.data[0], 0);
    EXPECT_EQ(receiver.received[1].frame.data[0], 1);
    EXPECT_EQ(recessive.error_status().tec, 135);
}

TEST(Collision, ADestroyedAttemptEndsWithItsErrorFrame) {
    Bus bus{500'000};
    TestNode first{bus};
    TestNode second{bus};
    // 0 10101010101 000 0001: the DLC's last bit is the first to differ from that of no data.
    // SOF, identifier, RTR, IDE, r0, 2 bits of DLC and their stuff bit, 2 bits of DLC: 20 bits.
    first.must_send(standard(0x555));
    second.must_send(standard(0x555, "00"));
    bus.advance_one();
    EXPECT_EQ(bus.now(), at(bits(20 + 12 + 8)));
    EXPECT_EQ(second.error_status().tec, 8);
}

TEST(Collision, OneShotFramesFailAtOnce) {
    Bus bus{500'000};
    TestNode first{bus};
    TestNode second{bus};
    first.must_send(standard(0x100, "00"), {.one_shot = true});
    second.must_send(standard(0x100, "01"), {.one_shot = true});
    run_until_quiet(bus);
    for (TestNode* node : {&first, &second}) {
        node->drain();
        ASSERT_EQ(node->results.size(), 1U);
        EXPECT_EQ(node->results[0].outcome, TransmitOutcome::failed);
        EXPECT_EQ(node->error_status().tec, 8);
    }
}

class BusOff : public testing::Test {
  protected:
    BusOff() {
        // Collisions one after the other, until one of the two gives up.
        for (int i = 0; i < 100 && victim_.error_status().state != ControllerState::bus_off; ++i) {
            rival_.must_send(standard(0x100, "00"));
            victim_.must_send(standard(0x100, "01"));
            run_until_quiet(bus_);
            rival_.drain();
            victim_.drain();
        }
        went_off_ = bus_.now();
    }

    Bus bus_{500'000};
    TestNode rival_{bus_};
    TestNode victim_{bus_};
    TestNode receiver_{bus_};
    TimePoint went_off_;
};

TEST_F(BusOff, ComesFromRepeatedCollisionsAndFailsAllTransmissions) {
    EXPECT_EQ(states_of(victim_),
              (std::vector{ControllerState::error_passive, ControllerState::bus_off}));
    EXPECT_GT(victim_.error_status().tec, 255);
    EXPECT_EQ(victim_.results.back().outcome, TransmitOutcome::failed);
    EXPECT_NE(rival_.error_status().state, ControllerState::bus_off);
}

TEST_F(BusOff, NeitherSendsNorReceives) {
    EXPECT_EQ(victim_.send(standard(0x100)), SendResult{SendError::bus_off});
    victim_.received.clear();
    rival_.must_send(standard(0x555));
    run_until_quiet(bus_);
    EXPECT_EQ(victim_.received_ids(), Ids{});
    EXPECT_EQ(receiver_.received_ids().back(), 0x555U);
}

TEST_F(BusOff, LastsUntilRecoverAnd128Times11Bits) {
    const TimePoint asked = bus_.now() + 1s;
    bus_.advance(asked);
    EXPECT_EQ(bus_.next_event(), never);
    victim_.recover();
    victim_.recover();
    EXPECT_EQ(bus_.next_event(), asked + bits(128 * 11));
    victim_.states.clear();
    bus_.advance(asked + bits(128 * 11) - 1ns);
    EXPECT_FALSE(victim_.has_event());
    EXPECT_TRUE(bus_.advance_one());
    EXPECT_EQ(states_of(victim_), std::vector{ControllerState::error_active});
    EXPECT_EQ(victim_.states[0].time, asked + bits(128 * 11));
    EXPECT_EQ(victim_.error_status(), ErrorStatus{});
    victim_.must_send(standard(0x555));
    run_until_quiet(bus_);
    EXPECT_EQ(receiver_.received_ids().back(), 0x555U);
}

TEST_F(BusOff, ALinkMayReportLateRefusals) {
    EXPECT_TRUE(bus_.fail(victim_.node(), TransmitHandle{4711}));
    victim_.drain();
    EXPECT_EQ(victim_.results.back().handle, TransmitHandle{4711});
    EXPECT_EQ(victim_.results.back().outcome, TransmitOutcome::failed);
    for (std::size_t i = 0; i < victim_.capabilities().mailboxes; ++i) {
        EXPECT_TRUE(bus_.fail(victim_.node(), TransmitHandle{i}));
    }
    EXPECT_FALSE(bus_.fail(victim_.node(), TransmitHandle{99}));
}

TEST(BusOffAndLone, ABusOffNodeDoesNotAcknowledge) {
    Bus bus{500'000};
    TestNode sender{bus};
    TestNode off{bus};
    {
        TestNode rival{bus};
        for (int i = 0; i < 100 && off.error_status().state != ControllerState::bus_off; ++i) {
            rival.must_send(standard(0x100, "00"));
            off.must_send(standard(0x100, "01"));
            run_until_quiet(bus);
            rival.drain();
            off.drain();
            sender.drain();
        }
    }
    sender.must_send(standard(0x555));
    run_until_quiet(bus);
    sender.drain();
    EXPECT_TRUE(sender.results.empty());
    EXPECT_EQ(sender.error_status().state, ControllerState::error_passive);
    off.recover();
    run_until_quiet(bus);
    sender.drain();
    EXPECT_EQ(sender.results.size(), 1U);
}

}  // namespace
}  // namespace canorb::can::sim::test
