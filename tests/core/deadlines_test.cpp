// What the deadline does to a message and to its call; and a message that is late between frames.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/core/test_engine.hpp"

namespace canorb::core {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(Deadlines, ACallNotBegunIsWithdrawnAndHasNotHappened) {
    TestEngine node;
    const CallHandle call = node.call("1801", 2, "", 20ms);
    EXPECT_EQ(node.engine.next_deadline(), node.now + 20ms);
    node.advance(20ms - 1ns);
    EXPECT_EQ(node.result(call), "waiting");
    node.advance(1ns);
    EXPECT_EQ(node.result(call), "TIMEOUT NO 1");
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_THAT(node.notices(), ElementsAre("dropped"));
    EXPECT_EQ(node.counted(), (Counted{{"calls_timed_out", 1}, {"messages_expired", 1}}));
    EXPECT_EQ(node.engine.next_deadline(), never);
}

TEST(Deadlines, NothingIsBegunAtTheDeadlineEvenBeforeOnTime) {
    TestEngine node;
    const CallHandle call = node.call("1801", 2, "", 20ms);
    node.now += 20ms;
    EXPECT_THAT(node.transmit(), IsEmpty());
    node.advance(0ns);
    EXPECT_EQ(node.result(call), "TIMEOUT NO 1");
}

TEST(Deadlines, ACallBegunMayHaveHappened) {
    TestEngine node;
    const CallHandle call = node.call("1801", 2, "", 20ms);
    EXPECT_EQ(node.hand_over().size(), 1U);  // in the controller, not on the bus
    node.advance(20ms);
    EXPECT_EQ(node.result(call), "TIMEOUT MAYBE 2");
    EXPECT_EQ(node.counted(), (Counted{{"calls_timed_out", 1}}));
    node.finish_frame();
    EXPECT_THAT(node.notices(), ElementsAre("sent"));
    // Its late Reply finds no call.
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.counted(), (Counted{{"frames_sent", 1},
                                       {"messages_sent", 1},
                                       {"frames_received", 1},
                                       {"messages_received", 1},
                                       {"unmatched_replies", 1}}));
}

TEST(Deadlines, AMessageOnceBegunIsSentToItsEnd) {
    TestEngine node;
    const CallHandle call = node.call("1801", 7, "000102030405060708090A0B0C0D", 20ms);
    EXPECT_EQ(node.hand_over().size(), 2U);  // of three
    node.finish_frame();
    node.advance(20ms);
    EXPECT_EQ(node.result(call), "TIMEOUT MAYBE 2");
    EXPECT_THAT(node.transmit(), ElementsAre("465 82"
                                             "0708090A0B0C0D"));
    EXPECT_EQ(node.counted(),
              (Counted{{"calls_timed_out", 1}, {"frames_sent", 3}, {"messages_sent", 1}}));
}

TEST(Deadlines, ACallSentAndNotAnsweredMayHaveHappened) {
    TestEngine node;
    const CallHandle call = node.call("1801", 2, "", 20ms);
    node.transmit();
    EXPECT_EQ(node.engine.next_deadline(), node.now + 20ms);
    node.advance(20ms);
    EXPECT_EQ(node.result(call), "TIMEOUT MAYBE 2");
}

TEST(Deadlines, OnewayAndGroupMessagesExpire) {
    TestEngine node;
    EXPECT_EQ(node.send("1801", 2, "", 20ms), "queued");
    EXPECT_EQ(node.multicast(7, 0, 2, "", 30ms), "queued");
    EXPECT_EQ(node.engine.next_deadline(), node.now + 20ms);
    node.advance(20ms);
    EXPECT_EQ(node.engine.next_deadline(), node.now + 10ms);
    node.advance(10ms);
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_THAT(node.notices(), ElementsAre("dropped", "dropped"));
    EXPECT_EQ(node.counted(), (Counted{{"messages_expired", 2}}));
}

TEST(Deadlines, EachCallHasItsOwn) {
    TestEngine node;
    const CallHandle later = node.call("1801", 2, "", 30ms);
    const CallHandle earlier = node.call("1801", 2, "", 10ms);
    node.transmit();
    node.advance(10ms);
    EXPECT_EQ(node.result(earlier), "TIMEOUT MAYBE 2");
    EXPECT_EQ(node.result(later), "waiting");
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.result(later), "NO_EXCEPTION ");
}

TEST(Deadlines, AMessageLateBetweenTwoFramesIsStopped) {
    TestEngine node;
    const CallHandle call = node.call("1801", 7, "000102030405060708090A0B0C0D");
    const CallHandle behind = node.call("1801", 3);
    EXPECT_EQ(node.hand_over().size(), 2U);
    node.finish_frame();
    EXPECT_EQ(node.engine.next_deadline(), node.now + 50ms);  // half of the inter-frame timeout
    node.advance(50ms);
    EXPECT_EQ(node.result(call), "COMM_FAILURE MAYBE 7");
    EXPECT_THAT(node.notices(), ElementsAre("dropped"));
    EXPECT_EQ(node.counted(), (Counted{{"frames_sent", 1}, {"messages_stopped", 1}}));
    // Its second frame is taken back, its third never comes; the message behind it goes.
    EXPECT_THAT(node.hand_over(), ElementsAre("465 100005ABCE180103"));
    EXPECT_EQ(node.aborted, std::vector{can::TransmitHandle{2}});
    node.finish_frame(can::TransmitOutcome::aborted);
    node.finish_frame();
    node.receive("4A3 110003ABCE00");
    EXPECT_EQ(node.result(behind), "NO_EXCEPTION ");
}

}  // namespace
}  // namespace canorb::core
