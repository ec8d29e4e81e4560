// The engine's tracer: what it keeps, and that off it costs nothing.

#include "tests/core/test_engine.hpp"

namespace canorb::core {
namespace {

using namespace canorb::core::test;
using testing::ElementsAre;

Texts traces(TestEngine& node) {
    Texts texts;
    while (const auto trace = node.engine.tracer().next()) {
        texts.push_back(to_string(*trace).substr(17));
    }
    return texts;
}

TEST(Tracer, OffItRecordsNothing) {
    TestEngine node;
    EXPECT_EQ(node.send("1801"), "queued");
    node.transmit();
    node.receive("4A3 1000051234280102");
    EXPECT_FALSE(node.engine.tracer().has_next());
    EXPECT_FALSE(node.engine.tracer().next());
}

TEST(Tracer, WhatIsInTheQueueWhenItIsTurnedOnOrOffIsNotTold) {
    TestEngine node;
    EXPECT_EQ(node.send("1801"), "queued");
    node.engine.tracer().turn(true);
    EXPECT_EQ(node.send("1802"), "queued");
    node.transmit();
    EXPECT_THAT(traces(node),
                ElementsAre("out    5 -> 3        Request      ABCE     8 octets    1 "
                            "frame   object 2, operation 2, oneway"));
    EXPECT_EQ(node.send("1802"), "queued");
    node.engine.tracer().turn(false);
    node.engine.tracer().turn(true);
    node.transmit();
    EXPECT_THAT(traces(node), testing::IsEmpty());
}

TEST(Tracer, WhatNobodyFetchesIsCounted) {
    TestEngine node;
    node.engine.tracer().turn(true);
    for (int i = 0; i < 1030; ++i) {
        ASSERT_EQ(node.send("1801"), "queued");
        node.transmit();
        node.notices();
    }
    EXPECT_EQ(node.counted()["traces_lost"], 6U);
    const Texts texts = traces(node);
    ASSERT_EQ(texts.size(), 1024U);
    EXPECT_THAT(texts.front(), testing::HasSubstr(" ABCD "));  // the oldest are kept
    EXPECT_EQ(node.send("1801"), "queued");
    node.transmit();
    EXPECT_EQ(traces(node).size(), 1U);
    EXPECT_EQ(node.counted()["traces_lost"], 0U);
}

TEST(Tracer, TellsMessagesThatWereGivenUp) {
    TestEngine node;
    node.engine.tracer().turn(true);
    node.send("1801", 2, "0102030405060708");  // three frames
    node.hand_over();
    node.finish_frame();
    node.send("2001");
    node.state(can::ControllerState::bus_off);
    const Texts texts = traces(node);
    ASSERT_EQ(texts.size(), 2U);
    for (const std::string& text : texts) {
        EXPECT_THAT(text, testing::EndsWith(", oneway, FAILED with the link"));
    }
}

TEST(Tracer, TellsRequestsOfCancelledCallsOnce) {
    TestEngine node;
    node.engine.tracer().turn(true);
    for (int i = 0; i < 3; ++i) node.engine.cancel(node.call("1801"));
    Texts texts = traces(node);
    ASSERT_EQ(texts.size(), 3U);
    for (const std::string& text : texts) {
        EXPECT_THAT(text, testing::EndsWith(", operation 2, NOT SENT: its call was cancelled"));
    }
    // One that is on its way goes on, and is told as any other.
    const CallHandle begun = node.call("1801");
    node.hand_over();
    node.engine.cancel(begun);
    EXPECT_THAT(traces(node), testing::IsEmpty());
    node.transmit();
    EXPECT_THAT(
        traces(node),
        ElementsAre(testing::EndsWith("ABD0     8 octets    1 frame   object 1, operation 2")));
}

TEST(Tracer, SaysWhatAPeerSentInCharactersThatATerminalCanTake) {
    TestEngine node;
    node.engine.tracer().turn(true);
    node.call("1801");
    node.transmit();
    // A user exception whose id has an escape, a tab and a NUL behind it: 5 octets with the NUL.
    node.receive(frames_of("4A3", "11 0009 ABCD 01 05 411B0942 00"));
    const Texts texts = traces(node);
    ASSERT_EQ(texts.size(), 2U);
    EXPECT_THAT(texts[1], testing::EndsWith("USER_EXCEPTION A??B"));
    // An unknown status, and one that has no body.
    node.call("1801");
    node.transmit();
    node.receive("4A3 110003ABCE09");
    EXPECT_THAT(traces(node).back(), testing::EndsWith("    6 octets    1 frame   unknown status"));
    node.receive("4A3 110003ABCE02");
    EXPECT_THAT(traces(node).back(), testing::EndsWith("SYSTEM_EXCEPTION UNKNOWN MAYBE, minor 0"));
}

}  // namespace
}  // namespace canorb::core
