// Calls cancelled, before and after their Request was begun, and calls whose end is to be told.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "tests/core/test_engine.hpp"

namespace canorb::core {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(Cancellation, ARequestNotBegunIsWithdrawn) {
    TestEngine node;
    const CallHandle call = node.call("1801");
    const CallHandle other = node.call("1801", 3);
    node.engine.cancel(call);
    EXPECT_THAT(node.transmit(), ElementsAre("465 100005ABCE180103"));
    EXPECT_THAT(node.notices(), ElementsAre("dropped", "sent"));
    EXPECT_FALSE(node.engine.deadline_of(call).has_value());
    node.receive("4A3 110003ABCE00");
    EXPECT_EQ(node.result(other), "NO_EXCEPTION ");
    EXPECT_EQ(node.engine.next_deadline(), never);
}

TEST(Cancellation, ARequestWithdrawnLeavesItsPlaceAtOnce) {
    EngineOptions options = TestEngine::options();
    options.max_outstanding_calls = 1;
    TestEngine node{options};
    for (int i = 0; i < 3; ++i) node.engine.cancel(node.call("1801"));
    EXPECT_TRUE(node.try_call("1801").ok());
}

TEST(Cancellation, TheReplyIsDroppedAndCounted) {
    TestEngine node;
    const CallHandle call = node.call("1801");
    node.transmit();
    node.counted();
    node.engine.cancel(call);
    EXPECT_FALSE(node.engine.deadline_of(call).has_value());
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.counted(), (Counted{{"frames_received", 1},
                                       {"messages_received", 1},
                                       {"replies_to_cancelled_calls", 1}}));
    EXPECT_EQ(node.engine.next_deadline(), never);
    // Once: the next one answers nothing that was ever asked.
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(
        node.counted(),
        (Counted{{"frames_received", 1}, {"messages_received", 1}, {"unmatched_replies", 1}}));
}

TEST(Cancellation, ARequestBegunIsSentToItsEnd) {
    TestEngine node;
    const CallHandle call = node.call("1801", 7, "000102030405060708090A0B0C0D");
    EXPECT_EQ(node.hand_over().size(), 2U);  // of three
    node.engine.cancel(call);
    node.finish_frame();
    EXPECT_THAT(node.transmit(), ElementsAre("465 82"
                                             "0708090A0B0C0D"));
    EXPECT_THAT(node.notices(), ElementsAre("sent"));
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.counted()["replies_to_cancelled_calls"], 1U);
}

TEST(Cancellation, TheReplyMustBeThePeersAndHaveTheId) {
    TestEngine node;
    const CallHandle call = node.call("1801");
    node.transmit();
    node.engine.cancel(call);
    node.counted();
    node.receive("4A4 110003ABCD00");  // node 4
    node.receive("4A3 110003ABCE00");
    EXPECT_EQ(
        node.counted(),
        (Counted{{"frames_received", 2}, {"messages_received", 2}, {"unmatched_replies", 2}}));
}

TEST(Cancellation, RepliesOfEveryKindAreDropped) {
    for (const std::string_view reply :
         {"110003ABCD01", "110003ABCD02", "11FFFFABCD000000", "110003ABCD07"}) {
        SCOPED_TRACE(reply);
        EngineOptions options = TestEngine::options();
        options.max_outstanding_calls = 1;
        TestEngine node{options};
        node.engine.cancel(node.call("1801", 3));  // withdrawn
        const CallHandle call = node.call("1801");
        node.transmit();
        node.engine.cancel(call);
        EXPECT_FALSE(node.try_call("1801").ok());
        // ABCE is the second call's id.
        std::string text{reply};
        text.replace(text.find("ABCD"), 4, "ABCE");
        node.receive("4A3 " + text);
        if (reply.starts_with(
                "11FFFF")) {  // skipped to its end: 65538 octets, 8 in the first frame
            for (std::size_t octets = 8, n = 1; octets < 65538; octets += 7, ++n) {
                const std::uint8_t sequence[] = {static_cast<std::uint8_t>(0x80 + n % 128)};
                const std::size_t left = std::min<std::size_t>(7, 65538 - octets);
                node.receive("4A3 " + hex(sequence) + std::string(2 * left, '0'));
            }
        }
        EXPECT_EQ(node.counted()["replies_to_cancelled_calls"], 1U);
        EXPECT_TRUE(node.try_call("1801").ok());
    }
}

TEST(Cancellation, ThePlaceIsFreeAtTheDeadline) {
    EngineOptions options = TestEngine::options();
    options.max_outstanding_calls = 1;
    TestEngine node{options};
    const CallHandle call = node.call("1801", 2, "", 20ms);
    node.transmit();
    node.engine.cancel(call);
    EXPECT_EQ(node.engine.next_deadline(), node.now + 20ms);
    node.advance(20ms - 1ns);
    EXPECT_EQ(describe(node.try_call("1801").error()), "NO_RESOURCES NO 11");
    node.advance(1ns);
    EXPECT_TRUE(node.try_call("1801").ok());
    EXPECT_EQ(node.counted()["calls_timed_out"], 0U);
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.counted()["unmatched_replies"], 1U);
}

// Around the whole counter: ABCD is passed over while its Reply may come.
TEST(Cancellation, TheRequestIdIsNotUsedAgainMeanwhile) {
    TestEngine node;
    const CallHandle cancelled = node.call("1801", 2, "", 1h);
    node.transmit();
    node.engine.cancel(cancelled);
    for (int i = 0; i < 0xFFFF; ++i) {
        ASSERT_EQ(node.send("1801", 3), "queued");
        const Texts frames = node.transmit();
        ASSERT_EQ(frames.size(), 1U);
        ASSERT_NE(frames[0].substr(0, 14), "465 100005ABCD");
        node.notices();
    }
    const CallHandle call = node.call("1801");
    EXPECT_THAT(node.transmit(), ElementsAre("465 100005ABCE180102"));
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.result(call), "waiting");
    // Now it may be: the counter goes round once more.
    for (int i = 0; i < 0xFFFE; ++i) {
        ASSERT_EQ(node.send("1801", 3), "queued");
        node.transmit();
        node.notices();
    }
    node.send("1801", 3);
    EXPECT_THAT(node.transmit(), ElementsAre("465 100005ABCD180103"));
}

TEST(Cancellation, ALocalCallNotBegunDoesNotRun) {
    TestEngine node;
    const CallHandle call = node.call("2801");
    const CallHandle other = node.call("2801", 3);
    node.engine.cancel(call);
    EXPECT_EQ(node.requests().size(), 1U);
    node.answer("07");
    EXPECT_EQ(node.result(other), "NO_EXCEPTION 07");
    EXPECT_EQ(node.counted(), Counted{});
}

TEST(Cancellation, TheAnswerToALocalCallIsDroppedAndCounted) {
    for (const bool refuse : {false, true}) {
        TestEngine node;
        const CallHandle call = node.call("2801");
        EXPECT_EQ(node.requests().size(), 1U);
        node.engine.cancel(call);
        if (refuse) {
            node.engine.refuse(node.caller, {SystemErrorKind::transient, Completion::no}, node.now);
        } else {
            node.answer("07");
        }
        EXPECT_EQ(node.counted(), (Counted{{"replies_to_cancelled_calls", 1}}));
        EXPECT_EQ(node.engine.next_deadline(), never);
    }
}

TEST(Cancellation, OneThatHasEndedIsForgotten) {
    EngineOptions options = TestEngine::options();
    options.max_outstanding_calls = 1;
    TestEngine node{options};
    const CallHandle call = node.call("1801");
    node.transmit();
    node.receive("4A3 110004ABCD0007");
    node.engine.cancel(call);
    EXPECT_FALSE(node.engine.deadline_of(call).has_value());
    node.engine.cancel(call);
    EXPECT_TRUE(node.try_call("1801").ok());
}

TEST(Cancellation, BusOffLeavesItToItsDeadline) {
    TestEngine node;
    const CallHandle call = node.call("1801", 2, "", 20ms);
    node.hand_over();
    node.engine.watch(call);
    node.engine.cancel(call);
    node.state(can::ControllerState::bus_off);
    EXPECT_FALSE(node.engine.next_ended().has_value());
    node.advance(20ms);
    EXPECT_EQ(node.engine.next_deadline(), never);
}

TEST(WatchedCalls, AreToldOnceInTheOrderOfTheirEnds) {
    TestEngine node;
    const CallHandle first = node.call("1801", 2, "", 20ms);
    const CallHandle second = node.call("1801");
    const CallHandle third = node.call("1801");
    const CallHandle unwatched = node.call("1801");
    for (const CallHandle call : {first, second, third}) node.engine.watch(call);
    node.transmit();
    EXPECT_FALSE(node.engine.next_ended().has_value());
    node.receive("4A3 110003ABCF00");
    node.receive("4A3 110003ABD000");
    node.receive("4A3 110003ABCE00");
    node.advance(20ms);
    EXPECT_EQ(node.engine.next_ended(), std::optional{third});
    EXPECT_EQ(node.engine.next_ended(), std::optional{second});
    EXPECT_EQ(node.engine.next_ended(), std::optional{first});
    EXPECT_FALSE(node.engine.next_ended().has_value());
    EXPECT_EQ(node.result(first), "TIMEOUT MAYBE 2");
    EXPECT_EQ(node.result(unwatched), "NO_EXCEPTION ");
}

}  // namespace
}  // namespace canorb::core
