#include "orb/caniop/transmit_queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "orb/caniop/segmenter.hpp"
#include "tests/support/octets.hpp"

namespace canorb::caniop {
namespace {

using canorb::test::hex;
using namespace std::chrono_literals;
using can::TransmitHandle;
using can::TransmitOutcome;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr TimePoint at(Duration since_start) {
    return TimePoint{} + since_start;
}

constexpr Identifier urgent{false, 1, 5};   // 0x025
constexpr Identifier normal{true, 3, 5};    // 0x465
constexpr Identifier relaxed{true, 30, 5};  // 0x7C5

// A message of `length` octets, all `tag`.
std::vector<std::uint8_t> message(std::uint8_t tag, std::size_t length = 8) {
    return std::vector<std::uint8_t>(length, tag);
}

class TransmitQueueTest : public testing::Test {
  protected:
    explicit TransmitQueueTest(const TransmitLimits& limits = {}) : queue(limits) {}

    MessageHandle put(Identifier identifier, std::uint8_t tag, std::size_t length = 8,
                      TimePoint deadline = never) {
        const auto handle = queue.enqueue(identifier, message(tag, length), deadline);
        EXPECT_TRUE(handle);
        return handle.value_or(MessageHandle{0});
    }

    // Hands over what the queue has now: "465:1111111111111111" each.
    std::vector<std::string> pump(TimePoint now = TimePoint{}, std::size_t at_most = 100) {
        std::vector<std::string> frames;
        while (frames.size() < at_most) {
            const auto frame = queue.next_frame(now);
            if (!frame) break;
            frames.push_back(text(*frame));
            in_controller.push_back(TransmitHandle{++last_frame});
            queue.handed_over(in_controller.back());
        }
        return frames;
    }

    static std::string text(const can::Frame& frame) {
        const std::uint8_t id[] = {static_cast<std::uint8_t>(frame.id >> 8),
                                   static_cast<std::uint8_t>(frame.id)};
        return hex(id).substr(1) + ":" + hex(frame.payload());
    }

    // The result of the oldest frame in the controller.
    void result(TransmitOutcome outcome, TimePoint now = TimePoint{}) {
        ASSERT_FALSE(in_controller.empty());
        const TransmitHandle handle = in_controller.front();
        in_controller.erase(in_controller.begin());
        queue.on_result({handle, outcome, now}, now);
    }

    void confirm(TimePoint now = TimePoint{}) { result(TransmitOutcome::sent, now); }

    std::vector<std::string> finished() {
        std::vector<std::string> outcomes;
        while (const auto one = queue.next_finished()) {
            static const std::map<MessageOutcome, std::string> names{
                {MessageOutcome::sent, "sent"},
                {MessageOutcome::expired, "expired"},
                {MessageOutcome::stopped, "stopped"},
                {MessageOutcome::failed, "failed"}};
            outcomes.push_back(std::to_string(static_cast<std::uint64_t>(one->handle)) + " " +
                               names.at(one->outcome) + (one->begun ? " begun" : ""));
            last_time = one->time;
        }
        return outcomes;
    }

    std::vector<std::uint64_t> aborts() {
        std::vector<std::uint64_t> frames;
        while (const auto frame = queue.next_abort())
            frames.push_back(static_cast<std::uint64_t>(*frame));
        return frames;
    }

    TransmitQueue queue;
    std::vector<TransmitHandle> in_controller;
    std::uint64_t last_frame = 0;
    TimePoint last_time{};
};

TEST_F(TransmitQueueTest, SendsAMessageOfOneFrame) {
    const MessageHandle handle = put(normal, 0x11);
    EXPECT_FALSE(queue.begun(handle));
    EXPECT_THAT(pump(), ElementsAre("465:1111111111111111"));
    EXPECT_TRUE(queue.begun(handle));
    EXPECT_THAT(finished(), IsEmpty());
    confirm(at(3ms));
    EXPECT_THAT(finished(), ElementsAre("1 sent begun"));
    EXPECT_EQ(last_time, at(3ms));
    EXPECT_EQ(queue.size(), 0U);
    EXPECT_EQ(queue.next_deadline(), never);
}

TEST_F(TransmitQueueTest, SendsTheFramesOfAMessageInOrderTwoAtATime) {
    put(normal, 0x11, 16);
    EXPECT_THAT(pump(), ElementsAre("465:1111111111111111", "465:8111111111111111"));
    EXPECT_THAT(pump(), IsEmpty());
    confirm();
    EXPECT_THAT(pump(), ElementsAre("465:8211"));
    confirm();
    EXPECT_THAT(finished(), IsEmpty());
    confirm();
    EXPECT_THAT(finished(), ElementsAre("1 sent begun"));
}

TEST_F(TransmitQueueTest, SendsTheLowestIdentifierFirst) {
    put(relaxed, 0x33);
    put(normal, 0x22);
    put(urgent, 0x11);
    EXPECT_THAT(pump(), ElementsAre("025:1111111111111111", "465:2222222222222222"));
    confirm();
    EXPECT_THAT(pump(), ElementsAre("7C5:3333333333333333"));
}

TEST_F(TransmitQueueTest, SendsInTheOrderOfEnqueueingWithinAnIdentifier) {
    put(normal, 0x33, 9);
    put(normal, 0x22);
    put(normal, 0x11);
    EXPECT_THAT(pump(), ElementsAre("465:3333333333333333", "465:8133"));
    confirm();
    confirm();
    EXPECT_THAT(pump(), ElementsAre("465:2222222222222222", "465:1111111111111111"));
}

TEST_F(TransmitQueueTest, AnUrgentMessageWaitsForNoMoreThanTheFramesInTheController) {
    put(normal, 0x22, 100);
    EXPECT_THAT(pump(), ElementsAre("465:2222222222222222", "465:8122222222222222"));
    put(urgent, 0x11, 9);
    confirm();
    EXPECT_THAT(pump(), ElementsAre("025:1111111111111111"));
    confirm();
    EXPECT_THAT(pump(), ElementsAre("025:8111"));
    confirm();
    EXPECT_THAT(pump(), ElementsAre("465:8222222222222222"));
    confirm();
    EXPECT_THAT(finished(), ElementsAre("2 sent begun"));
}

TEST_F(TransmitQueueTest, AFrameThatTheControllerDidNotTakeStaysUnlessOneIsMoreUrgent) {
    const MessageHandle first = put(normal, 0x22);
    EXPECT_EQ(text(*queue.next_frame(at(0ms))), "465:2222222222222222");
    EXPECT_EQ(text(*queue.next_frame(at(1ms))), "465:2222222222222222");
    EXPECT_FALSE(queue.begun(first));
    put(urgent, 0x11);
    EXPECT_EQ(text(*queue.next_frame(at(2ms))), "025:1111111111111111");
    EXPECT_THAT(pump(), ElementsAre("025:1111111111111111", "465:2222222222222222"));
}

TEST_F(TransmitQueueTest, WithdrawsOnlyWhatIsNotBegun) {
    const MessageHandle first = put(normal, 0x11, 9);
    const MessageHandle second = put(normal, 0x22);
    EXPECT_THAT(pump(TimePoint{}, 1), ElementsAre("465:1111111111111111"));
    EXPECT_FALSE(queue.withdraw(first));
    EXPECT_TRUE(queue.withdraw(second));
    EXPECT_FALSE(queue.withdraw(second));
    EXPECT_FALSE(queue.begun(second));
    EXPECT_FALSE(queue.withdraw(MessageHandle{77}));
    EXPECT_THAT(pump(), ElementsAre("465:8111"));
    confirm();
    confirm();
    EXPECT_THAT(finished(), ElementsAre("1 sent begun"));
    EXPECT_THAT(pump(), IsEmpty());
}

TEST_F(TransmitQueueTest, ExpiresWhatIsNotBegunAtItsDeadline) {
    put(normal, 0x11, 8, at(10ms));
    put(normal, 0x22, 8, at(5ms));
    put(normal, 0x33);
    EXPECT_EQ(queue.next_deadline(), at(5ms));
    queue.expire(at(5ms) - 1ns);
    EXPECT_THAT(finished(), IsEmpty());
    queue.expire(at(5ms));
    EXPECT_THAT(finished(), ElementsAre("2 expired"));
    EXPECT_EQ(last_time, at(5ms));
    EXPECT_EQ(queue.next_deadline(), at(10ms));
    EXPECT_THAT(pump(at(6ms)), ElementsAre("465:1111111111111111", "465:3333333333333333"));
    EXPECT_EQ(queue.next_deadline(), never);
}

TEST_F(TransmitQueueTest, DoesNotBeginAMessagePastItsDeadline) {
    put(normal, 0x11, 8, at(10ms));
    put(normal, 0x22);
    EXPECT_THAT(pump(at(10ms)), ElementsAre("465:2222222222222222"));
    queue.expire(at(10ms));
    EXPECT_THAT(finished(), ElementsAre("1 expired"));
}

TEST_F(TransmitQueueTest, SendsAMessageOnceBegunToItsEndPastItsDeadline) {
    put(normal, 0x11, 16, at(10ms));
    pump(at(9ms));
    confirm(at(11ms));
    queue.expire(at(12ms));
    EXPECT_THAT(pump(at(12ms)), ElementsAre("465:8211"));
    confirm(at(13ms));
    confirm(at(14ms));
    EXPECT_THAT(finished(), ElementsAre("1 sent begun"));
}

TEST_F(TransmitQueueTest, TheFirstFrameMayWaitInTheControllerForAsLongAsItTakes) {
    put(normal, 0x11, 9, at(10ms));
    pump(at(0ms), 1);
    EXPECT_EQ(queue.next_deadline(), never);
    queue.expire(at(10s));
    EXPECT_THAT(finished(), IsEmpty());
}

TEST_F(TransmitQueueTest, StopsAMessageWhoseNextFrameStaysInTheController) {
    put(normal, 0x11, 23);
    put(normal, 0x22);
    pump(at(0ms));
    confirm(at(1ms));
    pump(at(1ms));
    EXPECT_EQ(queue.next_deadline(), at(51ms));
    queue.expire(at(51ms) - 1ns);
    EXPECT_THAT(finished(), IsEmpty());
    EXPECT_THAT(aborts(), IsEmpty());
    queue.expire(at(51ms));
    EXPECT_THAT(finished(), ElementsAre("1 stopped begun"));
    EXPECT_THAT(aborts(), ElementsAre(2U, 3U));
    EXPECT_THAT(aborts(), IsEmpty());
    // The controller still holds both frames; only their results make room.
    EXPECT_THAT(pump(at(52ms)), IsEmpty());
    result(TransmitOutcome::aborted, at(52ms));
    EXPECT_THAT(pump(at(52ms)), ElementsAre("465:2222222222222222"));
    confirm(at(53ms));  // too late to be aborted: on the bus all the same
    EXPECT_THAT(finished(), IsEmpty());
    confirm(at(54ms));
    EXPECT_THAT(finished(), ElementsAre("2 sent begun"));
}

TEST_F(TransmitQueueTest, StopsAMessageWhoseNextFrameFindsNoPlaceInTheController) {
    put(normal, 0x22, 9);
    EXPECT_THAT(pump(at(0ms), 1), ElementsAre("465:2222222222222222"));
    confirm(at(1ms));
    EXPECT_TRUE(queue.next_frame(at(30ms)));  // full: not handed over
    queue.expire(at(51ms));
    EXPECT_THAT(finished(), ElementsAre("1 stopped begun"));
    EXPECT_THAT(aborts(), IsEmpty());
    EXPECT_FALSE(queue.next_frame(at(51ms)));
}

TEST_F(TransmitQueueTest, FailsAMessageWithItsFrame) {
    put(normal, 0x11, 16);
    put(normal, 0x22);
    pump();
    result(TransmitOutcome::failed, at(2ms));
    EXPECT_THAT(finished(), ElementsAre("1 failed begun"));
    EXPECT_EQ(last_time, at(2ms));
    EXPECT_THAT(aborts(), ElementsAre(2U));
    EXPECT_THAT(pump(), ElementsAre("465:2222222222222222"));
    result(TransmitOutcome::aborted);
    result(TransmitOutcome::aborted);  // not asked for
    EXPECT_THAT(finished(), ElementsAre("2 failed begun"));
    EXPECT_THAT(aborts(), IsEmpty());
}

TEST_F(TransmitQueueTest, FailsEverythingAtBusOff) {
    put(normal, 0x11, 16);
    put(normal, 0x22);
    put(urgent, 0x33);
    pump();
    confirm();  // the urgent one
    pump();
    confirm();  // the first frame of 0x11
    pump();
    EXPECT_THAT(finished(), ElementsAre("3 sent begun"));
    queue.fail_all(at(7ms));
    EXPECT_THAT(finished(), ElementsAre("1 failed begun", "2 failed"));
    EXPECT_EQ(last_time, at(7ms));
    EXPECT_EQ(queue.next_deadline(), never);
    EXPECT_THAT(aborts(), ElementsAre(3U, 4U));

    // After recovery there is room at once, and late results touch nothing.
    EXPECT_THAT(pump(), IsEmpty());
    put(normal, 0x44);
    put(normal, 0x55);
    EXPECT_THAT(pump(), ElementsAre("465:4444444444444444", "465:5555555555555555"));
    result(TransmitOutcome::failed);
    result(TransmitOutcome::sent);
    EXPECT_THAT(finished(), IsEmpty());
    confirm();
    confirm();
    EXPECT_THAT(finished(), ElementsAre("4 sent begun", "5 sent begun"));
}

TEST_F(TransmitQueueTest, BusOffAfterAStopLeavesNothingInTheController) {
    put(normal, 0x11, 16);
    pump(at(0ms));
    confirm(at(0ms));
    queue.expire(at(50ms));
    EXPECT_THAT(aborts(), ElementsAre(2U));
    queue.fail_all(at(51ms));
    EXPECT_THAT(aborts(), IsEmpty());
    put(normal, 0x22);
    put(normal, 0x33);
    EXPECT_EQ(pump(at(52ms)).size(), 2U);
}

TEST_F(TransmitQueueTest, IgnoresUnknownResults) {
    put(normal, 0x11);
    queue.on_result({TransmitHandle{99}, TransmitOutcome::failed, at(0ms)}, at(0ms));
    EXPECT_THAT(finished(), IsEmpty());
    EXPECT_EQ(queue.size(), 1U);
}

class TransmitQueueLimits : public TransmitQueueTest {
  protected:
    TransmitQueueLimits()
        : TransmitQueueTest({.max_messages = 3, .max_octets = 30, .frames_in_controller = 1}) {}
};

TEST_F(TransmitQueueLimits, RefusesMoreMessagesAndHoldsAPlaceUntilTheOutcomeIsFetched) {
    put(normal, 0x11, 1);
    put(normal, 0x22, 1);
    put(normal, 0x33, 1);
    EXPECT_FALSE(queue.enqueue(urgent, message(0x44, 1), never));
    EXPECT_EQ(pump().size(), 1U);
    confirm();
    EXPECT_FALSE(queue.enqueue(urgent, message(0x44, 1), never));
    EXPECT_THAT(finished(), ElementsAre("1 sent begun"));
    EXPECT_TRUE(queue.enqueue(urgent, message(0x44, 1), never));
}

TEST_F(TransmitQueueLimits, RefusesMoreOctetsAndUsesAllThatAreFree) {
    EXPECT_FALSE(queue.enqueue(normal, message(0x11, 31), never));
    const MessageHandle first = put(normal, 0x11, 8);
    put(urgent, 0x22, 15);
    EXPECT_FALSE(queue.enqueue(normal, message(0x33, 8), never));
    EXPECT_TRUE(queue.withdraw(first));
    // The free octets are not in one piece: the others move together, and stay what they are.
    put(normal, 0x33, 15);
    EXPECT_THAT(pump(), ElementsAre("025:2222222222222222"));
    confirm();
    EXPECT_THAT(pump(), ElementsAre("025:8122222222222222"));
    confirm();
    EXPECT_THAT(pump(), ElementsAre("465:3333333333333333"));
    confirm();
    EXPECT_THAT(pump(), ElementsAre("465:8133333333333333"));
    confirm();
    EXPECT_EQ(finished().size(), 2U);
}

class TransmitQueueGap : public TransmitQueueTest {
  protected:
    TransmitQueueGap() : TransmitQueueTest({.continuation_gap = 10ms}) {}
};

TEST_F(TransmitQueueGap, ComesBeforeEachContinuationAndCountsFromTheConfirmation) {
    put(normal, 0x11, 16);
    put(normal, 0x22);
    put(relaxed, 0x33);
    // Others may go meanwhile, but nothing overtakes within the identifier.
    EXPECT_THAT(pump(at(0ms)), ElementsAre("465:1111111111111111", "7C5:3333333333333333"));
    confirm(at(5ms));
    confirm(at(6ms));
    EXPECT_THAT(pump(at(6ms)), IsEmpty());
    EXPECT_EQ(queue.next_deadline(), at(15ms));
    EXPECT_THAT(pump(at(15ms) - 1ns), IsEmpty());
    EXPECT_THAT(pump(at(15ms)), ElementsAre("465:8111111111111111"));
    EXPECT_EQ(queue.next_deadline(), at(55ms));  // stop, half the inter-frame timeout
    confirm(at(20ms));
    EXPECT_THAT(pump(at(30ms)), ElementsAre("465:8211", "465:2222222222222222"));
}

TEST_F(TransmitQueueGap, IsNotADeadlineAnyMoreWhenItIsOver) {
    put(normal, 0x11, 9);
    pump(at(0ms));
    confirm(at(0ms));
    EXPECT_EQ(queue.next_deadline(), at(10ms));
    EXPECT_TRUE(queue.next_frame(at(10ms)));  // full: not handed over
    EXPECT_EQ(queue.next_deadline(), at(50ms));
}

// A controller that takes what it has room for, and confirms, refuses or fails at random: frames
// of one identifier come out in order, complete, and every message has one outcome.
TEST(TransmitQueueRandom, KeepsItsInvariants) {
    std::mt19937 random(4711);
    const auto below = [&](std::size_t n) {
        return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    };
    TransmitQueue queue({.max_messages = 16, .max_octets = 600, .frames_in_controller = 3});
    struct Known {
        Identifier identifier;
        std::vector<std::uint8_t> octets;
        std::size_t frames_seen = 0;
    };
    std::map<MessageHandle, Known> messages;
    std::vector<can::TransmitHandle> controller;
    std::uint64_t last_frame = 0;
    std::size_t sent = 0;
    TimePoint now{};

    for (int step = 0; step < 100000; ++step) {
        now += std::chrono::milliseconds(below(3));
        const Identifier identifier{below(2) == 0, static_cast<std::uint8_t>(below(4)), 5};
        switch (below(8)) {
            case 0: {
                std::vector<std::uint8_t> octets(1 + below(60));
                for (auto& octet : octets) octet = static_cast<std::uint8_t>(random());
                const auto deadline =
                    below(2) == 0 ? never : now + std::chrono::milliseconds(below(100));
                const auto handle = queue.enqueue(identifier, octets, deadline);
                if (handle) messages[*handle] = {identifier, octets};
                break;
            }
            case 1:
                if (!messages.empty() && below(10) == 0) {
                    const auto one = messages.begin()->first;
                    if (queue.withdraw(one)) messages.erase(one);
                }
                break;
            case 2:
                if (below(1000) == 0) queue.fail_all(now);
                queue.expire(now);
                while (const auto abort = queue.next_abort()) {
                    std::erase(controller, *abort);
                    queue.on_result({*abort, can::TransmitOutcome::aborted, now}, now);
                }
                break;
            case 3:
            case 4:
                if (!controller.empty()) {
                    const auto frame = controller.front();
                    controller.erase(controller.begin());
                    const auto outcome =
                        below(100) == 0 ? can::TransmitOutcome::failed : can::TransmitOutcome::sent;
                    queue.on_result({frame, outcome, now}, now);
                }
                break;
            default:
                if (const auto frame = queue.next_frame(now); frame && below(5) != 0) {
                    // It is the next frame of the oldest message with frames left on its
                    // identifier that is still in the queue.
                    const auto owner =
                        std::find_if(messages.begin(), messages.end(), [&](const auto& known) {
                            return known.second.identifier.can_id() == frame->id &&
                                   known.second.frames_seen <
                                       frame_count(known.second.octets.size()) &&
                                   *frame == cut_frame(known.second.identifier, known.second.octets,
                                                       known.second.frames_seen);
                        });
                    ASSERT_NE(owner, messages.end());
                    for (auto other = messages.begin(); other != owner; ++other) {
                        // None before it is in the middle.
                        const bool begun = other->second.frames_seen > 0;
                        const bool whole =
                            other->second.frames_seen == frame_count(other->second.octets.size());
                        ASSERT_TRUE(other->second.identifier.can_id() != frame->id || !begun ||
                                    whole);
                    }
                    ++owner->second.frames_seen;
                    controller.push_back(can::TransmitHandle{++last_frame});
                    queue.handed_over(controller.back());
                    ASSERT_LE(controller.size(), 3U);
                }
        }
        while (const auto finished = queue.next_finished()) {
            const auto known = messages.find(finished->handle);
            ASSERT_NE(known, messages.end());
            const std::size_t seen = known->second.frames_seen;
            ASSERT_EQ(finished->begun, seen > 0);
            if (finished->outcome == MessageOutcome::sent) {
                ASSERT_EQ(seen, frame_count(known->second.octets.size()));
                ++sent;
            }
            if (finished->outcome == MessageOutcome::expired) {
                ASSERT_EQ(seen, 0U);
            }
            messages.erase(known);
        }
        ASSERT_EQ(messages.size(), queue.size());
    }
    EXPECT_GT(sent, 1000U);
}

}  // namespace
}  // namespace canorb::caniop
