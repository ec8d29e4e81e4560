// What a node's user can do: one-shot frames, abort, listen-only, mailboxes, filters, detach, and
// what becomes of it in the middle of a frame. Frames in one step and bits must not differ.

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "tests/can/bus_fixture.hpp"
#include "tests/can/flip.hpp"

namespace canorb::can::sim::test {
namespace {

using Ids = std::vector<std::uint32_t>;

constexpr FramePosition first_bit_of_crc{FrameField::crc, 0, false};

// 0x555 without data, 0 10101010101 000 00I00 110011101001100 1 0 1 1111111: 45 bits to the end of
// EOF. The first bit of its CRC is bit 20.
constexpr std::int64_t length_555 = 45;

class Nodes : public WithFidelity {
  protected:
    ~Nodes() override { bus_.set_disturbance(nullptr); }

    /// What became of the only transmission, and when.
    void expect_result(TestNode& node, TransmitOutcome outcome, TimePoint time) {
        node.drain();
        ASSERT_EQ(node.results.size(), 1U);
        EXPECT_EQ(node.results[0].outcome, outcome);
        EXPECT_EQ(node.results[0].time, time);
    }

    Flip flip_;
    TestNode a_{bus_, {.name = "a"}};
    TestNode b_{bus_, {.name = "b"}};
    TestNode c_{bus_, {.name = "c"}};
};
CANORB_WITH_BOTH_FIDELITIES(Nodes);

// ---- one-shot

TEST_P(Nodes, AOneShotFrameIsSent) {
    a_.must_send(standard(0x555), {.one_shot = true});
    run_until_quiet(bus_);
    expect_result(a_, TransmitOutcome::sent, at(bits(length_555)));
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
}

TEST_P(Nodes, AOneShotFrameFailsWithTheErrorThatDestroysIt) {
    bus_.set_disturbance(&flip_);
    flip_.at(first_bit_of_crc);
    a_.must_send(standard(0x555), {.one_shot = true});
    run_until_quiet(bus_);
    expect_result(a_, TransmitOutcome::failed, at(bits(21)));
    EXPECT_EQ(a_.error_status().tec, 8);
    EXPECT_EQ(b_.received_ids(), Ids{});
    EXPECT_TRUE(frames_.empty());
}

TEST_P(Nodes, AFrameThatIsNotOneShotIsRepeatedAfterAnError) {
    bus_.set_disturbance(&flip_);
    flip_.at(first_bit_of_crc);
    a_.must_send(standard(0x555));
    run_until_quiet(bus_);
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
    EXPECT_EQ(a_.error_status().tec, 7);
    ASSERT_EQ(frames_.size(), 1U);
    // Bits 18, 19 and 20 were dominant for B and C: three of the flag make a stuff error in bit 23.
    // Their flags are bits 24 to 29, the delimiter 30 to 37, the intermission 38 to 40.
    EXPECT_EQ(frames_[0].start, at(bits(41)));
    EXPECT_EQ(frames_[0].lost_arbitrations, 0U);
}

TEST_P(Nodes, AOneShotFrameFailsWhenTheFrameIsOverToWhichItLost) {
    a_.must_send(standard(0x556), {.one_shot = true});
    b_.must_send(standard(0x555));
    bus_.advance(at(bits(length_555)) - 1ns);
    a_.drain();
    EXPECT_TRUE(a_.results.empty());
    run_until_quiet(bus_);
    expect_result(a_, TransmitOutcome::failed, at(bits(length_555)));
    EXPECT_EQ(frames_.size(), 1U);
}

TEST_P(Nodes, AOneShotFrameFailsWhenTheFrameIsDestroyedToWhichItLost) {
    bus_.set_disturbance(&flip_);
    flip_.at(first_bit_of_crc);
    a_.must_send(standard(0x556), {.one_shot = true});
    b_.must_send(standard(0x555));
    run_until_quiet(bus_);
    a_.drain();
    ASSERT_EQ(a_.results.size(), 1U);
    EXPECT_EQ(a_.results[0].outcome, TransmitOutcome::failed);
    EXPECT_EQ(a_.received_ids(), Ids{0x555});
}

// ---- abort

TEST_P(Nodes, AnAbortBeforeTheSofIsAtOnce) {
    const TransmitHandle handle = a_.must_send(standard(0x555));
    a_.abort(handle);
    expect_result(a_, TransmitOutcome::aborted, at(0ns));
    EXPECT_EQ(bus_.next_event(), never);
    EXPECT_EQ(bus_.statistics().busy_bits, 0U);
}

TEST_P(Nodes, AnAbortOfAFrameThatWaitsForTheBusIsAtOnce) {
    b_.must_send(standard(0x555));
    bus_.advance(at(bits(10)));
    const TransmitHandle handle = a_.must_send(standard(0x100));
    bus_.advance(at(bits(20)));
    a_.abort(handle);
    expect_result(a_, TransmitOutcome::aborted, at(bits(20)));
    run_until_quiet(bus_);
    EXPECT_EQ(b_.received_ids(), Ids{});
    EXPECT_EQ(a_.received_ids(), Ids{0x555});
}

TEST_P(Nodes, AnAbortOfAnotherFrameOfTheSenderIsAtOnce) {
    a_.must_send(standard(0x555));
    const TransmitHandle handle = a_.must_send(standard(0x556));
    bus_.advance(at(bits(10)));
    a_.abort(handle);
    expect_result(a_, TransmitOutcome::aborted, at(bits(10)));
    run_until_quiet(bus_);
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
}

TEST_P(Nodes, AnAbortOfTheFrameOnTheBusComesTooLate) {
    const TransmitHandle handle = a_.must_send(standard(0x555));
    bus_.advance(at(bits(1)));
    a_.abort(handle);
    run_until_quiet(bus_);
    expect_result(a_, TransmitOutcome::sent, at(bits(length_555)));
}

TEST_P(Nodes, AnAbortOfTheFrameOnTheBusKeepsItFromBeingRepeated) {
    bus_.set_disturbance(&flip_);
    flip_.at(first_bit_of_crc);
    const TransmitHandle handle = a_.must_send(standard(0x555));
    bus_.advance(at(bits(10)));
    a_.abort(handle);
    run_until_quiet(bus_);
    expect_result(a_, TransmitOutcome::aborted, at(bits(21)));
    EXPECT_TRUE(frames_.empty());
}

TEST_P(Nodes, AnAbortOfAFrameThatHasLostComesTrueAtTheEndOfTheOther) {
    const TransmitHandle handle = a_.must_send(standard(0x556));
    b_.must_send(standard(0x555));
    bus_.advance(at(bits(30)));
    a_.abort(handle);
    run_until_quiet(bus_);
    expect_result(a_, TransmitOutcome::aborted, at(bits(length_555)));
    EXPECT_EQ(frames_.size(), 1U);
}

TEST_P(Nodes, AnAbortOfAnUnknownHandleIsIgnored) {
    const TransmitHandle handle = a_.must_send(standard(0x555));
    a_.abort(TransmitHandle{4711});
    run_until_quiet(bus_);
    a_.abort(handle);
    expect_result(a_, TransmitOutcome::sent, at(bits(length_555)));
}

// ---- listen-only

TEST_P(Nodes, AListenerReceivesAndDoesNotSend) {
    EXPECT_TRUE(b_.set_listen_only(true));
    EXPECT_EQ(b_.send(standard(0x100)), SendResult{SendError::unsupported});
    a_.must_send(standard(0x555));
    run_until_quiet(bus_);
    expect_result(a_, TransmitOutcome::sent, at(bits(length_555)));
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
    EXPECT_EQ(bus_.statistics(b_.node()).received, 1U);
}

TEST_P(Nodes, AListenerDoesNotAcknowledge) {
    EXPECT_TRUE(b_.set_listen_only(true));
    EXPECT_TRUE(c_.set_listen_only(true));
    a_.must_send(standard(0x555));
    bus_.advance(at(bits(37)));
    ASSERT_EQ(errors_.size(), 1U);
    EXPECT_EQ(errors_[0].capture.kind, ErrorKind::acknowledgment);
    // It sees the sender's flag in the ACK delimiter.
    bus_.advance(at(bits(38)));
    ASSERT_EQ(errors_.size(), 3U);
    EXPECT_EQ(errors_[1].capture.kind, ErrorKind::form);
    EXPECT_FALSE(errors_[1].active_flag);
    EXPECT_FALSE(errors_[1].primary);
    EXPECT_EQ(b_.error_status(), ErrorStatus{});
    EXPECT_EQ(bus_.statistics(b_.node()).errors, 1U);
}

// Nobody acknowledges, the flag of an error passive sender is recessive, and a receiver checks
// nothing but its own ACK: for a listener the frame is valid, each time that it is repeated.
TEST_P(Nodes, AListenerReceivesWhatALoneErrorPassiveSenderRepeats) {
    EXPECT_TRUE(b_.set_listen_only(true));
    EXPECT_TRUE(c_.set_listen_only(true));
    a_.must_send(standard(0x555));
    constexpr std::int64_t first_passive = 16 * 54 + 8;
    bus_.advance(at(bits(first_passive + 9 * 62 + length_555)));
    EXPECT_EQ(b_.received_ids(), Ids(10, 0x555));
    for (std::int64_t i = 0; i < 10; ++i) {
        EXPECT_EQ(b_.received[static_cast<std::size_t>(i)].time,
                  at(bits(first_passive + i * 62 + length_555)));
    }
    EXPECT_EQ(a_.error_status().tec, 128);
    EXPECT_TRUE(frames_.empty()) << "nobody acknowledged it";
}

TEST_P(Nodes, ListenOnlyWithdrawsWhatWaits) {
    a_.must_send(standard(0x555));
    EXPECT_TRUE(a_.set_listen_only(true));
    expect_result(a_, TransmitOutcome::aborted, at(0ns));
    EXPECT_EQ(bus_.next_event(), never);
}

TEST_P(Nodes, ListenOnlyShowsAtTheEndOfAFrame) {
    // The sender's frame goes out, and its other one is withdrawn at once. B still acknowledges.
    EXPECT_TRUE(c_.set_listen_only(true));
    a_.must_send(standard(0x555));
    a_.must_send(standard(0x556));
    bus_.advance(at(bits(10)));
    EXPECT_TRUE(a_.set_listen_only(true));
    EXPECT_TRUE(b_.set_listen_only(true));
    expect_result(a_, TransmitOutcome::aborted, at(bits(10)));
    run_until_quiet(bus_);
    a_.drain();
    ASSERT_EQ(a_.results.size(), 2U);
    EXPECT_EQ(a_.results[1].outcome, TransmitOutcome::sent);
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
    EXPECT_EQ(frames_.size(), 1U);
}

TEST_P(Nodes, ListenOnlyEndsWhenAFrameIsOver) {
    EXPECT_TRUE(b_.set_listen_only(true));
    EXPECT_TRUE(c_.set_listen_only(true));
    a_.must_send(standard(0x555));
    bus_.advance(at(bits(10)));
    EXPECT_TRUE(b_.set_listen_only(false));
    run_until_quiet(bus_);
    // Nobody acknowledges the first attempt. B sees the sender's flag, bits 37 to 42, as a form
    // error in bit 37. Its own flag, 38 to 43, is seen by itself only; delimiter 44 to 51,
    // intermission 52 to 54. The second attempt begins at 54: a SOF in the third of these bits.
    expect_result(a_, TransmitOutcome::sent, at(bits(54 + length_555)));
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
    EXPECT_EQ(b_.error_status(), ErrorStatus{});
    b_.must_send(standard(0x100));
    run_until_quiet(bus_);
    EXPECT_EQ(a_.received_ids(), Ids{0x100});
}

// ---- mailboxes, receive FIFO

TEST_P(Nodes, MailboxesSendTheLowestIdentifierFirst) {
    for (const std::size_t mailboxes : {1U, 2U, 3U, 8U, 31U, 32U}) {
        TestNode sender{bus_, {.mailboxes = mailboxes}};
        TestNode receiver{bus_};
        Ids ids;
        for (std::uint32_t i = 0; i < mailboxes; ++i) {
            // In no order: 7 and 32 have no common divisor, nor do 7 and the other numbers.
            sender.must_send(standard(0x100 + 7 * i % static_cast<std::uint32_t>(mailboxes)));
            ids.push_back(0x100 + i);
        }
        EXPECT_EQ(sender.send(standard(0x000)), SendResult{SendError::full});
        run_until_quiet(bus_);
        EXPECT_EQ(receiver.received_ids(), ids) << mailboxes;
        sender.drain();
        EXPECT_EQ(sender.results.size(), mailboxes);
        for (TestNode* each : {&a_, &b_, &c_}) each->drain();
    }
}

TEST_P(Nodes, ALowerIdentifierOvertakesWhatWaits) {
    for (const std::uint32_t id : {0x555U, 0x556U, 0x557U}) a_.must_send(standard(id));
    bus_.advance(at(bits(10)));
    a_.must_send(standard(0x001));
    run_until_quiet(bus_);
    EXPECT_EQ(b_.received_ids(), (Ids{0x555, 0x001, 0x556, 0x557}));
}

TEST_P(Nodes, MailboxesAreInTheOrderOfTheBus) {
    a_.must_send(remote(extended(0x555 << 18)));
    a_.must_send(extended(0x555 << 18));
    a_.must_send(remote(standard(0x555)));
    a_.must_send(standard(0x555));
    run_until_quiet(bus_);
    b_.drain();
    ASSERT_EQ(b_.received.size(), 4U);
    EXPECT_EQ(b_.received[0].frame, standard(0x555));
    EXPECT_EQ(b_.received[1].frame, remote(standard(0x555)));
    EXPECT_EQ(b_.received[2].frame, extended(0x555 << 18));
    EXPECT_EQ(b_.received[3].frame, remote(extended(0x555 << 18)));
}

TEST_P(Nodes, ALosersMailboxesAreChosenAnewAtEachSof) {
    a_.must_send(standard(0x300));
    b_.must_send(standard(0x200));
    bus_.advance(at(bits(20)));
    a_.must_send(standard(0x100));
    run_until_quiet(bus_);
    EXPECT_EQ(c_.received_ids(), (Ids{0x200, 0x100, 0x300}));
}

TEST_P(Nodes, AFullReceiveFifoCountsWhatItLoses) {
    TestNode slow{bus_, {.receive_capacity = 3}};
    for (std::uint32_t i = 0; i < 8; ++i) a_.must_send(standard(0x100 + i));
    run_until_quiet(bus_);
    EXPECT_EQ(slow.received_ids(), (Ids{0x100, 0x101, 0x102}));
    EXPECT_EQ(slow.lost, 5U);
    EXPECT_EQ(bus_.events(slow.node()).lost(), 5U);
    EXPECT_EQ(bus_.statistics(slow.node()).received, 8U) << "it acknowledged them";
    a_.drain();
    slow.received.clear();
    a_.must_send(standard(0x555));
    run_until_quiet(bus_);
    EXPECT_EQ(slow.received_ids(), Ids{0x555});
    EXPECT_EQ(slow.lost, 5U);
}

// ---- acceptance

TEST_P(Nodes, FiltersDecideAtTheEndOfEof) {
    EXPECT_TRUE(b_.set_filters({}));
    a_.must_send(standard(0x555));
    bus_.advance(at(bits(length_555)) - 1ns);
    EXPECT_TRUE(b_.set_filters(std::array{Filter{0x7FF, 0x555, false}}));
    a_.must_send(standard(0x556));
    run_until_quiet(bus_);
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
    EXPECT_EQ(bus_.statistics(b_.node()).received, 2U);
}

TEST_P(Nodes, FiltersAreMasksAndValues) {
    EXPECT_TRUE(b_.set_filters(
        std::array{Filter{0x700, 0x100, false}, Filter{0x1FFFFFFF, 0x12345, true, true}}));
    for (const Frame& frame :
         {standard(0x0FF), standard(0x100), remote(standard(0x1FF)), standard(0x200),
          extended(0x100), extended(0x12345), remote(extended(0x12345)), extended(0x12344)}) {
        a_.must_send(frame);
    }
    run_until_quiet(bus_);
    EXPECT_EQ(b_.received_ids(), (Ids{0x12345, 0x100, 0x1FF}));
}

// ---- attach and detach

TEST_P(Nodes, AFrameGoesOutThoughItsSenderIsDetached) {
    std::optional<TestNode> sender{std::in_place, bus_};
    sender->must_send(standard(0x555));
    sender->must_send(standard(0x556));
    bus_.advance(at(bits(10)));
    sender.reset();
    run_until_quiet(bus_);
    EXPECT_EQ(a_.received_ids(), Ids{0x555});
    EXPECT_EQ(a_.received[0].time, at(bits(length_555)));
    ASSERT_EQ(frames_.size(), 1U);
}

TEST_P(Nodes, AFrameThatIsDestroyedDiesWithItsSender) {
    bus_.set_disturbance(&flip_);
    flip_.at(first_bit_of_crc);
    std::optional<TestNode> sender{std::in_place, bus_};
    sender->must_send(standard(0x555));
    bus_.advance(at(bits(10)));
    sender.reset();
    run_until_quiet(bus_);
    EXPECT_EQ(a_.received_ids(), Ids{});
    EXPECT_EQ(errors_.size(), 4U);
    EXPECT_TRUE(frames_.empty());
}

TEST_P(Nodes, ALosersFrameDiesWithIt) {
    std::optional<TestNode> loser{std::in_place, bus_};
    loser->must_send(standard(0x556));
    a_.must_send(standard(0x555));
    bus_.advance(at(bits(30)));
    loser.reset();
    run_until_quiet(bus_);
    EXPECT_EQ(b_.received_ids(), Ids{0x555});
}

TEST_P(Nodes, AReceiverAcknowledgesTheFrameDuringWhichItIsDetached) {
    Bus bus{500'000};
    bus.set_fidelity(GetParam());
    TestNode sender{bus};
    std::optional<TestNode> receiver{std::in_place, bus};
    sender.must_send(standard(0x555));
    sender.must_send(standard(0x556));
    bus.advance(at(bits(10)));
    receiver.reset();
    bus.advance(at(bits(length_555)));
    sender.drain();
    ASSERT_EQ(sender.results.size(), 1U);
    EXPECT_EQ(sender.results[0].outcome, TransmitOutcome::sent);
    run_until_quiet(bus);
    sender.drain();
    EXPECT_EQ(sender.results.size(), 1U) << "nobody is there any more";
    EXPECT_EQ(sender.error_status().tec, 128);
}

TEST_P(Nodes, ADetachedNodesNumberIsUsedAgainWhenItHasLeft) {
    std::optional<TestNode> node{std::in_place, bus_};
    const NodeIndex number = node->node();
    node->must_send(standard(0x555));
    bus_.advance(at(bits(10)));
    node.reset();
    EXPECT_NE(TestNode{bus_}.node(), number) << "it is still in its frame";
    run_until_quiet(bus_);
    EXPECT_EQ(TestNode{bus_}.node(), number);
}

TEST_P(Nodes, ANodeThatIsAttachedInAFrameLetsItPassBy) {
    a_.must_send(standard(0x555));
    bus_.advance(at(bits(10)));
    TestNode late{bus_};
    late.must_send(standard(0x001));
    a_.must_send(standard(0x556));
    run_until_quiet(bus_);
    // The ACK delimiter, EOF and the intermission are 11 recessive bits: it takes part in the next
    // arbitration.
    EXPECT_EQ(late.received_ids(), Ids{0x556});
    EXPECT_EQ(b_.received_ids(), (Ids{0x555, 0x001, 0x556}));
    EXPECT_EQ(frames_[1].start, at(bits(length_555 + 3)));
}

// ---- bus-off, by itself

TEST_P(Nodes, ANodeWithAutomaticRecoveryLeavesBusOffByItself) {
    bus_.set_disturbance(&flip_);
    TestNode node{bus_, {.automatic_recovery = true}};
    TimePoint begin;
    while (node.error_status().state != ControllerState::bus_off) {
        ASSERT_LT(node.error_status().tec, 256);
        flip_.at({FrameField::start_of_frame, 0, false}, node.node());
        begin = bus_.now();
        node.must_send(standard(0x555), {.one_shot = true});
        bus_.advance(bus_.now() + bits(100));
        node.drain();
    }
    // The SOF is bit 0. For the others it is no error that it is followed by recessive bits, until
    // there are six: bit 6. Their flags are bits 7 to 12. The bus is recessive in bits 1 to 6, less
    // than 11, and from bit 13 on.
    run_until_quiet(bus_);
    node.drain();
    ASSERT_EQ(node.states.size(), 3U);
    EXPECT_EQ(node.states[1].status.state, ControllerState::bus_off);
    EXPECT_EQ(node.states[1].time, begin + bits(1));
    EXPECT_EQ(node.states[2].status, ErrorStatus{});
    EXPECT_EQ(node.states[2].time, begin + bits(13 + 128 * 11));
    node.must_send(standard(0x555));
    run_until_quiet(bus_);
    EXPECT_EQ(a_.received_ids(), Ids{0x555});
}

// ---- many

TEST_P(Nodes, ThirtyTwoNodesArbitrate) {
    std::vector<std::unique_ptr<TestNode>> nodes;
    Ids ids;
    for (std::uint32_t i = 0; i < 29; ++i) {
        nodes.push_back(std::make_unique<TestNode>(bus_));
        nodes.back()->must_send(standard(0x100 + 12 * i % 29));
        ids.push_back(0x100 + i);
    }
    run_until_quiet(bus_);
    EXPECT_EQ(a_.received_ids(), ids);
    ASSERT_EQ(frames_.size(), 29U);
    for (std::uint32_t i = 0; i < 29; ++i) EXPECT_EQ(frames_[i].lost_arbitrations, 28 - i);
    EXPECT_TRUE(errors_.empty());
}

}  // namespace
}  // namespace canorb::can::sim::test
