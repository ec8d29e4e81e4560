// Fault confinement of the simulated bus as its nodes' users see it: lone nodes, collisions,
// bus-off. The rules one by one are in rules_1_to_3_test.cpp and its siblings.

#include <gtest/gtest.h>

#include <optional>

#include "orb/can/sim/fault_injector.hpp"
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

// 0x555 without data: 0 10101010101 000 00I00 110011101001100, with one stuff bit (I), is 35 bits
// from SOF to the end of the CRC, its delimiter bit 35 (from 0), its ACK slot bit 36. An attempt
// that nobody acknowledges:
//
//     0        SOF
//     36       ACK slot: the error, told at its end, 37 bits after the SOF began
//     37..42   error flag
//     43..50   error delimiter
//     51..53   intermission
//     54       SOF of the next attempt; error passive: 54..61 suspend transmission, SOF at 62
constexpr std::int64_t ack_error = 37;
constexpr std::int64_t active_period = 54;
constexpr std::int64_t passive_period = 62;
constexpr std::int64_t length_555 = 45;  ///< SOF to the end of EOF, where it is acknowledged
/// The 17th attempt, the first of an error passive sender, comes after 16 with an active flag (the
/// error that makes it passive has one, too) and the first suspend transmission.
constexpr std::int64_t first_passive = 16 * active_period + 8;

class LoneNode : public WithFidelity {};
CANORB_WITH_BOTH_FIDELITIES(LoneNode);

TEST_P(LoneNode, BecomesErrorPassiveAfterSixteenAttemptsAndThenTheBusIsQuiet) {
    TestNode node{bus_};
    node.must_send(standard(0x555));
    run_until_quiet(bus_);
    ASSERT_EQ(errors_.size(), 16U);
    for (int attempt = 0; attempt < 16; ++attempt) {
        const NodeError& error = errors_[static_cast<std::size_t>(attempt)];
        EXPECT_EQ(error.time, at(bits(attempt * active_period + ack_error)));
        EXPECT_EQ(error.capture.kind, ErrorKind::acknowledgment);
        EXPECT_EQ(error.status.tec, 8 * (attempt + 1));
        EXPECT_TRUE(error.active_flag);
        EXPECT_TRUE(error.primary);
    }
    EXPECT_FALSE(bus_.advance_one());
    EXPECT_TRUE(bus_.is_quiet());
    EXPECT_NE(bus_.next_event(), never) << "somebody wants to know of each attempt";
    bus_.set_error_trace(nullptr);
    EXPECT_EQ(bus_.next_event(), never);
    EXPECT_EQ(states_of(node), std::vector{ControllerState::error_passive});
    EXPECT_TRUE(node.results.empty());
}

TEST_P(LoneNode, RepeatsItsFrameForEverThoughTheBusIsQuiet) {
    TestNode node{bus_};
    node.must_send(standard(0x555));
    bus_.set_error_trace(nullptr);
    // Bit 28 of the attempt that begins at 872 + 8050 * 62 = 499 972.
    bus_.advance(at(bits(500'000)));
    EXPECT_EQ(bus_.next_event(), never);
    EXPECT_EQ(node.error_status(), (ErrorStatus{ControllerState::error_passive, 128, 0}));
    EXPECT_FALSE(bus_.statistics().frames > 0);
    EXPECT_EQ(bus_.statistics().error_frames, 16U + 8050U);
    EXPECT_EQ(bus_.statistics(node.node()).errors, 16U + 8050U);
    // Suspend transmission is not busy: 54 bits of each attempt, and 28 of this one.
    EXPECT_EQ(bus_.statistics().busy_bits, (16U + 8050U) * 54U + 28U);
}

TEST_P(LoneNode, IsHeardInTheFirstAttemptThatBeginsElevenRecessiveBitsAfterSomebodyCame) {
    TestNode node{bus_};
    node.must_send(standard(0x555));
    bus_.advance(at(bits(500'000)));
    TestNode other{bus_};
    // In the middle of an attempt (see above): this one it lets pass by. From its CRC delimiter to
    // the end of suspend transmission there are 27 recessive bits.
    run_until_quiet(bus_);
    other.drain();
    ASSERT_EQ(other.received.size(), 1U);
    EXPECT_EQ(other.received[0].time, at(bits(499'972 + passive_period + length_555)));
    EXPECT_EQ(node.error_status(), (ErrorStatus{ControllerState::error_active, 127, 0}));
    EXPECT_EQ(states_of(node),
              (std::vector{ControllerState::error_passive, ControllerState::error_active}));
    EXPECT_EQ(other.error_status(), ErrorStatus{});
}

TEST_P(LoneNode, IsHeardAtOnceBySomebodyWhoCameBetweenTwoAttempts) {
    TestNode node{bus_};
    node.must_send(standard(0x555));
    // In the last bit of suspend transmission: the bus has been recessive for 26 bits.
    bus_.advance(at(bits(first_passive + passive_period) - 1ns));
    TestNode other{bus_};
    run_until_quiet(bus_);
    other.drain();
    ASSERT_EQ(other.received.size(), 1U);
    EXPECT_EQ(other.received[0].time, at(bits(first_passive + passive_period + length_555)));
}

TEST_P(LoneNode, IsNotHeardBySomebodyWhoCameTooLateInItsErrorFrame) {
    TestNode node{bus_};
    node.must_send(standard(0x555));
    // Error active, six dominant bits: the recessive ones are 43..53, 11 of them. Who comes at
    // their beginning is in time, and a bit later too late.
    bus_.advance(at(bits(active_period + 44)));
    TestNode other{bus_};
    bus_.advance(at(bits(2 * active_period + 44)));
    EXPECT_EQ(node.error_status().tec, 16) << "not the third attempt";
    run_until_quiet(bus_);
    other.drain();
    ASSERT_EQ(other.received.size(), 1U);
    EXPECT_EQ(other.received[0].time, at(bits(2 * active_period + length_555)));
}

TEST_P(LoneNode, AnAbortEndsItsAttempts) {
    TestNode node{bus_};
    const TransmitHandle handle = node.must_send(standard(0x555));
    bus_.advance(at(bits(10)));
    node.abort(handle);
    EXPECT_FALSE(node.has_event()) << "it is on the bus";
    run_until_quiet(bus_);
    node.drain();
    ASSERT_EQ(node.results.size(), 1U);
    EXPECT_EQ(node.results[0],
              (TransmitResult{handle, TransmitOutcome::aborted, at(bits(ack_error))}));
    EXPECT_EQ(node.error_status().tec, 8);
}

TEST_P(LoneNode, AnAbortEndsAlsoAttemptsWithoutEnd) {
    TestNode node{bus_};
    const TransmitHandle handle = node.must_send(standard(0x555));
    bus_.advance(at(bits(500'000)));
    node.drain();
    node.abort(handle);
    EXPECT_FALSE(node.has_event()) << "it is on the bus";
    EXPECT_EQ(bus_.next_event(), at(bits(499'972 + ack_error)));
    run_until_quiet(bus_);
    node.drain();
    ASSERT_EQ(node.results.size(), 1U);
    EXPECT_EQ(node.results[0],
              (TransmitResult{handle, TransmitOutcome::aborted, at(bits(499'972 + ack_error))}));
    EXPECT_EQ(node.error_status().tec, 128);
}

TEST_P(LoneNode, AOneShotFrameIsTriedOnceEvenWhenErrorPassive) {
    TestNode node{bus_};
    node.must_send(standard(0x555));
    run_until_quiet(bus_);
    node.must_send(standard(0x100), {.one_shot = true});
    run_until_quiet(bus_);
    node.drain();
    ASSERT_EQ(node.results.size(), 1U);
    EXPECT_EQ(node.results[0].outcome, TransmitOutcome::failed);
    // 0 00100000I000 00I 0 0000 and 15 bits of CRC, its delimiter and the ACK slot, where the 17th
    // attempt of the other frame would have been.
    EXPECT_EQ(errors_.size(), 17U);
    EXPECT_EQ(errors_.back().capture.kind, ErrorKind::acknowledgment);
    EXPECT_FALSE(errors_.back().active_flag);
    EXPECT_EQ(node.error_status().tec, 128);
}

TEST_P(LoneNode, TwoSendersOfTheSameFrameDoNotAcknowledgeEachOther) {
    TestNode first{bus_};
    TestNode second{bus_};
    first.must_send(standard(0x555));
    second.must_send(standard(0x555));
    run_until_quiet(bus_);
    ASSERT_EQ(errors_.size(), 2U * 16U);
    EXPECT_TRUE(errors_[0].primary);
    EXPECT_FALSE(errors_[1].primary);
    EXPECT_EQ(first.error_status(), (ErrorStatus{ControllerState::error_passive, 128, 0}));
    EXPECT_EQ(second.error_status(), (ErrorStatus{ControllerState::error_passive, 128, 0}));
    bus_.advance(at(bits(500'000)));
    EXPECT_EQ(bus_.statistics().error_frames, 16U + 8050U);
    EXPECT_EQ(bus_.statistics(second.node()).errors, 16U + 8050U);
}

// Two nodes send frames with one identifier and different data, which CAN forbids:
//
//     dominant   0 00100000I000 0 0I 0 0001 00000I000 100101101011010
//     recessive  0 00100000I000 0 0I 0 0001 00000I001 ...
//
// Both have the same length. Bit 29 is the last of the data, where the recessive one has a bit
// error. Its flag is on the bus from bit 30 on, where the dominant one sends the first bit of its
// CRC, recessive: a bit error, too. Its flag is bits 31..36. A receiver sees 000 and then the
// first flag: bit 32 is the sixth dominant one and a stuff error. Its flag is bits 33..38.
class Collision : public WithFidelity {
  protected:
    static constexpr std::int64_t length = 55;  ///< SOF to the end of EOF
    static constexpr std::int64_t active_period =
        50;  ///< ... 39..46 delimiter, 47..49 intermission

    TestNode dominant_{bus_};
    TestNode recessive_{bus_};
};
CANORB_WITH_BOTH_FIDELITIES(Collision);

// While the recessive one is error active it destroys the frame for both. At TEC 128 its flag is
// silent and the dominant frame passes.
TEST_P(Collision, OfOneIdentifierWithDifferentDataCostsSixteenAttempts) {
    TestNode receiver{bus_};
    dominant_.must_send(standard(0x100, "00"));
    recessive_.must_send(standard(0x100, "01"));
    for (int attempt = 1; attempt <= 16; ++attempt) {
        const std::int64_t begin = (attempt - 1) * active_period;
        bus_.advance(at(bits(begin + 33)));
        ASSERT_EQ(errors_.size(), 3U);
        EXPECT_EQ(errors_[0].node, recessive_.node());
        EXPECT_EQ(errors_[0].time, at(bits(begin + 30)));
        EXPECT_EQ(errors_[0].capture,
                  (ErrorCapture{ErrorKind::bit, {FrameField::data, 7, false}, true}));
        EXPECT_TRUE(errors_[0].primary);
        EXPECT_EQ(errors_[1].node, dominant_.node());
        EXPECT_EQ(errors_[1].time, at(bits(begin + 31)));
        EXPECT_EQ(errors_[1].capture,
                  (ErrorCapture{ErrorKind::bit, {FrameField::crc, 0, false}, true}));
        EXPECT_EQ(errors_[2].node, receiver.node());
        EXPECT_EQ(errors_[2].time, at(bits(begin + 33)));
        EXPECT_EQ(errors_[2].capture,
                  (ErrorCapture{ErrorKind::stuff, {FrameField::crc, 1, true}, false}));
        EXPECT_FALSE(errors_[2].primary);
        EXPECT_EQ(dominant_.error_status().tec, 8 * attempt);
        EXPECT_EQ(recessive_.error_status().tec, 8 * attempt);
        EXPECT_EQ(receiver.error_status().rec, attempt);
        errors_.clear();
    }
    EXPECT_FALSE(receiver.has_event());
    EXPECT_EQ(bus_.statistics().error_frames, 16U);

    // Both are error passive and wait for 8 bits more. The 17th attempt destroys nothing. The
    // passive flag is over when six equal bits have been seen: the ACK delimiter and five bits of
    // EOF. The delimiter is the other two, the intermission and three bits of the idle bus; then
    // come another intermission and suspend transmission.
    const std::int64_t passes = 16 * active_period + 8;
    const std::int64_t second = passes + length + 3 + 3 + 3 + 8;
    run_until_quiet(bus_);
    ASSERT_EQ(errors_.size(), 1U);
    EXPECT_EQ(errors_[0].time, at(bits(passes + 30)));
    EXPECT_FALSE(errors_[0].active_flag);
    receiver.drain();
    ASSERT_EQ(receiver.received.size(), 2U);
    EXPECT_EQ(receiver.received[0].frame.data[0], 0);
    EXPECT_EQ(receiver.received[0].time, at(bits(passes + length)));
    EXPECT_EQ(receiver.received[1].frame.data[0], 1);
    EXPECT_EQ(receiver.received[1].time, at(bits(second + length)));
    EXPECT_EQ(dominant_.error_status(), (ErrorStatus{ControllerState::error_active, 127, 0}));
    EXPECT_EQ(recessive_.error_status(), (ErrorStatus{ControllerState::error_passive, 135, 0}));
    EXPECT_EQ(receiver.error_status().rec, 14);
}

TEST_P(Collision, OfTwoLengthsDestroysAnAttemptAtTheLastBitOfTheDlc) {
    // first   0 10101010101 000 00I00 110011101001100
    // second  0 10101010101 000 00I01 ...
    // Bit 19 differs; the second's flag is 20..25. The first has its bit error at 20, the first of
    // its CRC, and its flag in 21..26. Delimiter 27..34, intermission 35..37, next attempt at 38.
    dominant_.must_send(standard(0x555));
    recessive_.must_send(standard(0x555, "00"));
    bus_.advance(at(bits(38 + 21)));
    ASSERT_EQ(errors_.size(), 4U);
    EXPECT_EQ(errors_[0].time, at(bits(20)));
    EXPECT_EQ(errors_[0].capture,
              (ErrorCapture{ErrorKind::bit, {FrameField::data_length_code, 3, false}, true}));
    EXPECT_EQ(errors_[1].time, at(bits(21)));
    EXPECT_EQ(errors_[1].capture,
              (ErrorCapture{ErrorKind::bit, {FrameField::crc, 0, false}, true}));
    EXPECT_EQ(errors_[2].time, at(bits(38 + 20)));
    EXPECT_EQ(errors_[3].time, at(bits(38 + 21)));
}

TEST_P(Collision, OneShotFramesFailAtOnce) {
    dominant_.must_send(standard(0x100, "00"), {.one_shot = true});
    recessive_.must_send(standard(0x100, "01"), {.one_shot = true});
    run_until_quiet(bus_);
    std::int64_t error = 31;
    for (TestNode* node : {&dominant_, &recessive_}) {
        node->drain();
        ASSERT_EQ(node->results.size(), 1U);
        EXPECT_EQ(node->results[0].outcome, TransmitOutcome::failed);
        EXPECT_EQ(node->results[0].time, at(bits(error--)));
        EXPECT_EQ(node->error_status().tec, 8);
    }
}

// The collisions of above, again and again, each when the bus has been idle for long. The first
// round costs 16 attempts and leaves TEC 127 and 135. In each later one the victim has an error
// and sends its frame afterwards: 135 + 7 * 17 = 254, and in the 19th round 262. The rival, which
// has no error any more, has counted down to 127 - 18.
class BusOff : public WithFidelity {
  protected:
    BusOff() {
        receiver_.emplace(bus_);
        for (int round = 0; round < 19; ++round) {
            EXPECT_NE(victim_.error_status().state, ControllerState::bus_off) << round;
            last_round_ = bus_.now();
            rival_.must_send(standard(0x100, "00"));
            victim_.must_send(standard(0x100, "01"));
            run_until_quiet(bus_);
            bus_.advance(bus_.now() + bits(100));
            rival_.drain();
            victim_.drain();
        }
        EXPECT_EQ(victim_.error_status(), (ErrorStatus{ControllerState::bus_off, 262, 0}));
    }

    TestNode rival_{bus_};
    TestNode victim_{bus_};
    std::optional<TestNode> receiver_;
    TimePoint last_round_;
};
CANORB_WITH_BOTH_FIDELITIES(BusOff);

TEST_P(BusOff, ComesFromRepeatedCollisionsAndFailsAllTransmissions) {
    EXPECT_EQ(states_of(victim_),
              (std::vector{ControllerState::error_passive, ControllerState::bus_off}));
    EXPECT_EQ(victim_.states.back().time, last_round_ + bits(30));
    EXPECT_EQ(victim_.results.back().outcome, TransmitOutcome::failed);
    EXPECT_EQ(victim_.results.back().time, last_round_ + bits(30));
    EXPECT_EQ(rival_.error_status(), (ErrorStatus{ControllerState::error_active, 127 - 18, 0}));
    receiver_->drain();
    EXPECT_EQ(receiver_->received.back().time, last_round_ + bits(55)) << "the rival's";
}

TEST_P(BusOff, NeitherSendsNorReceives) {
    EXPECT_EQ(victim_.send(standard(0x100)), SendResult{SendError::bus_off});
    victim_.received.clear();
    rival_.must_send(standard(0x555));
    run_until_quiet(bus_);
    EXPECT_EQ(victim_.received_ids(), Ids{});
    EXPECT_EQ(receiver_->received_ids().back(), 0x555U);
}

TEST_P(BusOff, LastsUntilRecoverAnd128Times11Bits) {
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
    EXPECT_EQ(receiver_->received_ids().back(), 0x555U);
}

TEST_P(BusOff, LastsLongerWhereOthersSend) {
    // A frame restarts a run of recessive bits, and the runs that are complete count.
    const TimePoint asked = bus_.now();
    victim_.recover();
    bus_.advance(asked + bits(25));  // two runs, and three bits that are lost
    rival_.must_send(standard(0x555));
    // Its recessive end is the ACK delimiter, EOF and what follows: bits 37 on.
    const std::int64_t over = 25 + 37 + 126 * 11;
    bus_.advance(asked + bits(over) - 1ns);
    EXPECT_EQ(victim_.error_status().state, ControllerState::bus_off);
    bus_.advance(asked + bits(over));
    EXPECT_EQ(victim_.error_status(), ErrorStatus{});
}

TEST_P(BusOff, ALinkMayReportLateRefusals) {
    EXPECT_TRUE(bus_.fail(victim_.node(), TransmitHandle{4711}));
    victim_.drain();
    EXPECT_EQ(victim_.results.back().handle, TransmitHandle{4711});
    EXPECT_EQ(victim_.results.back().outcome, TransmitOutcome::failed);
    for (std::size_t i = 0; i < victim_.capabilities().mailboxes; ++i) {
        EXPECT_TRUE(bus_.fail(victim_.node(), TransmitHandle{i}));
    }
    EXPECT_FALSE(bus_.fail(victim_.node(), TransmitHandle{99}));
}

TEST_P(BusOff, ABusOffNodeDoesNotAcknowledgeUntilItHasRecovered) {
    receiver_.reset();
    const TimePoint begin = bus_.now();
    rival_.drain();
    rival_.results.clear();
    // TEC 109: error passive with the third attempt that fails.
    rival_.must_send(standard(0x555));
    run_until_quiet(bus_);
    rival_.drain();
    EXPECT_TRUE(rival_.results.empty());
    EXPECT_EQ(rival_.error_status(), (ErrorStatus{ControllerState::error_passive, 133, 0}));

    const TimePoint asked = begin + bits(3 * active_period + 8 + 5 * passive_period);  // a SOF
    bus_.advance(asked);
    victim_.recover();
    // Each attempt has 27 recessive bits in a row, 35..61: two runs of 11, the second of which is
    // complete after bit 56. So 64 attempts.
    const TimePoint recovered = asked + bits(63 * passive_period + 57);
    bus_.advance(recovered - 1ns);
    EXPECT_EQ(victim_.error_status().state, ControllerState::bus_off);
    bus_.advance(recovered);
    EXPECT_EQ(victim_.error_status(), ErrorStatus{});
    run_until_quiet(bus_);
    rival_.drain();
    ASSERT_EQ(rival_.results.size(), 1U);
    EXPECT_EQ(rival_.results[0].time, asked + bits(64 * passive_period + length_555));
}

class OneShot : public WithFidelity {};
CANORB_WITH_BOTH_FIDELITIES(OneShot);

TEST_P(OneShot, FailsWhenItLosesTheArbitration) {
    TestNode loser{bus_};
    TestNode winner{bus_};
    loser.must_send(standard(0x200), {.one_shot = true});
    winner.must_send(standard(0x100));
    run_until_quiet(bus_);
    EXPECT_EQ(loser.received_ids(), Ids{0x100});
    ASSERT_EQ(loser.results.size(), 1U);
    EXPECT_EQ(loser.results[0].outcome, TransmitOutcome::failed);
    EXPECT_EQ(loser.error_status().tec, 0) << "losing is no error";
}

TEST_P(OneShot, MayWaitForABusyBus) {
    TestNode sender{bus_};
    TestNode other{bus_};
    other.must_send(standard(0x100));
    bus_.advance(at(bits(1)));
    sender.must_send(standard(0x200), {.one_shot = true});
    run_until_quiet(bus_);
    EXPECT_EQ(other.received_ids(), Ids{0x200});
}

// ---- frames that do not begin on an idle bus

std::vector<CompletedFrame> frames_under(std::string_view script, bool second_is_late) {
    Bus bus{500'000};
    FaultInjector injector{*parse_fault_script(script), 500'000};
    bus.set_disturbance(&injector);
    std::vector<CompletedFrame> frames;
    bus.set_trace([&](const CompletedFrame& frame) { frames.push_back(frame); });
    TestNode first{bus, {.name = "first"}};
    TestNode second{bus, {.name = "second"}};
    TestNode third{bus, {.name = "third"}};
    first.must_send(standard(0x123));
    if (second_is_late) bus.advance(at(bits(5)));
    second.must_send(standard(0x456, "5555"));
    bus.advance(at(bits(1000)));
    return frames;
}

// 0x456 with 55 55 is 62 bits on the wire, 2 of them stuff bits.
TEST(JoinedFrame, BeginsWithTheBitThatWasTakenForItsSof) {
    const auto frames = frames_under("frame 123 at intermission.3 dominant wire", false);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[1].frame.id, 0x456U);
    EXPECT_EQ(frames[1].start, frames[0].time + bits(2));
    EXPECT_EQ(frames[1].time, frames[1].start + bits(62));
    EXPECT_EQ(frames[1].bits, 62U);
    EXPECT_EQ(frames[1].stuff_bits, 2U);
    EXPECT_EQ(frames[1].lost_arbitrations, 0U);
}

TEST(OverloadFrame, IsToldWithTheBitThatCausedIt) {
    Bus bus{500'000};
    FaultInjector injector{*parse_fault_script("frame 123 at intermission.1 dominant b"), 500'000};
    bus.set_disturbance(&injector);
    std::vector<NodeOverload> overloads;
    bus.set_overload_trace([&](const NodeOverload& each) { overloads.push_back(each); });
    TestNode a{bus, {.name = "a"}};
    TestNode b{bus, {.name = "b"}};
    a.must_send(standard(0x123));
    run_until_quiet(bus);
    a.drain();
    ASSERT_EQ(a.results.size(), 1U);
    // b's flag begins in the second bit of the intermission, where a answers it.
    ASSERT_EQ(overloads.size(), 2U);
    EXPECT_EQ(overloads[0].node, b.node());
    EXPECT_EQ(overloads[0].time, a.results[0].time + bits(1));
    EXPECT_EQ(overloads[0].position, (FramePosition{FrameField::intermission, 0, false}));
    EXPECT_EQ(overloads[1].node, a.node());
    EXPECT_EQ(overloads[1].time, a.results[0].time + bits(2));
    EXPECT_EQ(overloads[1].position, (FramePosition{FrameField::intermission, 1, false}));
    EXPECT_EQ(bus.statistics(a.node()).overloads, 1U);
    EXPECT_EQ(bus.statistics(b.node()).overloads, 1U);
    EXPECT_EQ(a.error_status(), ErrorStatus{});
}

TEST(CutOffNode, BeginsAFrameDuringAnotherWithoutDisturbingItsAccount) {
    // "second" hears nothing of the frame on the wire and begins one of its own at bit 5, in vain.
    const auto frames = frames_under("at 0s cut-off second for 200 bits", true);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[0].frame.id, 0x123U);
    EXPECT_EQ(frames[0].start, at(0ns));
    EXPECT_EQ(frames[0].time, frames[0].start + bits(frames[0].bits));
    EXPECT_EQ(frames[1].frame.id, 0x456U);
    EXPECT_EQ(frames[1].time, frames[1].start + bits(62));
}

}  // namespace
}  // namespace canorb::can::sim::test
