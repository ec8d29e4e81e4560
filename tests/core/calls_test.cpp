// The engine as a client: Requests out, Replies in, and every way in which a call can end.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

#include "tests/core/test_engine.hpp"

namespace canorb::core {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::IsEmpty;

// ---- Requests

TEST(Calls, AVoidCallIsOneFrameOutAndOneBack) {
    TestEngine node;
    const CallHandle call = node.call("1801", 2);
    EXPECT_EQ(node.result(call), "waiting");
    EXPECT_THAT(node.transmit(), ElementsAre("465 100005ABCD180102"));
    EXPECT_THAT(node.notices(), ElementsAre("sent"));
    EXPECT_EQ(node.result(call), "waiting");
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.result(call), "NO_EXCEPTION ");
    EXPECT_EQ(node.counted(), (Counted{{"frames_sent", 1},
                                       {"messages_sent", 1},
                                       {"frames_received", 1},
                                       {"messages_received", 1}}));
    EXPECT_EQ(node.engine.next_deadline(), never);
}

TEST(Calls, ParametersGoInFurtherFrames) {
    TestEngine node;
    // SetAttributeValueUL("max_acceleration", 3, 42): 28 message octets, 31 in frames.
    const CallHandle call = node.call("1801", 7, "11 6D61785F616363656C65726174696F6E 00 03 2A");
    EXPECT_THAT(node.transmit(), ElementsAre("465 100019ABCD180107",  //
                                             "465 81116D61785F6163",  //
                                             "465 8263656C65726174",  //
                                             "465 83696F6E00032A"));
    EXPECT_EQ(node.counted(), (Counted{{"frames_sent", 4}, {"messages_sent", 1}}));
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.result(call), "NO_EXCEPTION ");
}

TEST(Calls, AMessageIsToldToBeOnItsWayUntilItIsSent) {
    TestEngine node;
    const CallHandle call = node.call("1801");
    EXPECT_TRUE(node.engine.message_of(call).has_value());
    EXPECT_EQ(node.engine.queued_messages(), 1U);
    node.transmit();
    EXPECT_FALSE(node.engine.message_of(call).has_value());
    EXPECT_EQ(node.engine.queued_messages(), 0U);
}

TEST(Calls, RequestIdsCountUpOverAllKindsAndWrap) {
    auto options = TestEngine::options();
    options.first_request_id = 0xFFFE;
    TestEngine node{options};
    node.call("1801");
    EXPECT_EQ(node.send("1801"), "queued");
    EXPECT_EQ(node.multicast(7), "queued");
    EXPECT_THAT(node.transmit(), ElementsAre("0E5 1000050000"
                                             "4DDB"
                                             "02",  // the group first
                                             "465 100005FFFE180102", "465 100005FFFF180102"));
    node.call("1801");
    EXPECT_THAT(node.transmit(), ElementsAre("465 1000050001180102"));
}

TEST(Calls, RequestIdsOfOutstandingCallsAreSkipped) {
    auto options = TestEngine::options();
    options.first_request_id = 0;
    TestEngine node{options};
    const CallHandle first = node.call("1801", 2, "", 1h);
    const CallHandle second = node.call("2001", 2, "", 1h);
    node.transmit();
    for (int i = 2; i < 0x10000; ++i) {
        ASSERT_EQ(node.send("1801"), "queued");
        node.transmit();
        node.notices();
    }
    EXPECT_EQ(node.send("1801"), "queued");
    EXPECT_THAT(node.transmit(), ElementsAre("465 1000050002180102"));
    node.receive("4A3 110003000000");
    node.receive("4A4 110003000100");
    EXPECT_EQ(node.result(first), "NO_EXCEPTION ");
    EXPECT_EQ(node.result(second), "NO_EXCEPTION ");
}

TEST(Calls, AMessageAboveTheFormatsLimitIsImpLimitBeforeAnythingIsSent) {
    TestEngine node;
    std::vector<std::uint8_t> message(65539);
    const TimePoint deadline = node.now + 1s;
    for (const std::uint16_t key :
         std::initializer_list<std::uint16_t>{0x1801, 0x2801}) {  // another node's, its own
        EXPECT_EQ(describe(node.engine.call(ObjectKey{key}, 2, message, deadline).error()),
                  "IMP_LIMIT NO 30");
        EXPECT_EQ(describe(node.engine.send(ObjectKey{key}, 2, message, deadline).error()),
                  "IMP_LIMIT NO 30");
    }
    EXPECT_EQ(describe(node.engine.multicast(GroupId{7}, 0, 2, message, deadline).error()),
              "IMP_LIMIT NO 30");
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_THAT(node.requests(), IsEmpty());
    // One octet less is the longest that message_size can tell.
    message.pop_back();
    EXPECT_TRUE(node.engine.call(ObjectKey{0x1801}, 2, message, deadline).ok());
    const Texts frames = node.transmit();
    EXPECT_EQ(frames.size(), 1U + (65538 - 8 + 6) / 7);
    EXPECT_EQ(frames.front(), "465 10FFFFABCD180102");
}

// ---- Replies

struct ReplyRow {
    std::string name;
    Texts frames;
    std::string result;
    Counted counters;
};

class Replies : public testing::TestWithParam<ReplyRow> {};

TEST_P(Replies, EndTheCallAs) {
    auto options = TestEngine::options();
    options.receive.max_message = 60;
    TestEngine node{options};
    const CallHandle call = node.call("1801");
    node.transmit();
    node.counted();
    node.receive(GetParam().frames);
    EXPECT_EQ(node.result(call), GetParam().result);
    Counted counters = node.counted();
    counters.erase("frames_received");
    EXPECT_EQ(counters, GetParam().counters);
    // Nothing is ever sent in answer to a Reply.
    EXPECT_THAT(node.transmit(), IsEmpty());
}

const Counted one_message{{"messages_received", 1}};

INSTANTIATE_TEST_SUITE_P(
    All, Replies,
    testing::Values(
        ReplyRow{"NoException", {"4A3 110004ABCD002A"}, "NO_EXCEPTION 2A", one_message},
        ReplyRow{"ManyFrames",
                 {"4A3 11000CABCD000102", "4A3 8103040506070809"},
                 "NO_EXCEPTION 010203040506070809",
                 one_message},
        ReplyRow{"UserException", {"4A3 110005ABCD010100"}, "USER_EXCEPTION 0100", one_message},
        ReplyRow{"SystemException",
                 frames_of("4A3", system_exception_reply("ABCD", "NO_RESOURCES", "0A", "01")),
                 "NO_RESOURCES NO 10", one_message},
        // The wire documentation's own, with minor 300 = 812C.
        ReplyRow{"SystemExceptionWithMinor",
                 frames_of("4A3",
                           "11 0025 ABCD 02 1E"
                           "49444C3A6F6D672E6F72672F434F5242412F54494D454F55543A312E30 00 812C 02"),
                 "TIMEOUT MAYBE 300", one_message},
        // "IDL:x:1.0"
        ReplyRow{"UnknownSystemException",
                 frames_of("4A3", "11 0010 ABCD 02 0A 49444C3A783A312E30 00 00 01"), "UNKNOWN NO",
                 one_message},
        ReplyRow{
            "SystemExceptionWithoutABody", {"4A3 110003ABCD02"}, "MARSHAL YES 21", one_message},
        ReplyRow{"SystemExceptionCompletion3",
                 frames_of("4A3", system_exception_reply("ABCD", "TIMEOUT", "02", "03")),
                 "MARSHAL YES 21", one_message},
        ReplyRow{"SystemExceptionWithMoreBehind",
                 frames_of("4A3", "11 0011 ABCD 02 0A 49444C3A783A312E30 00 00 01 00"),
                 "MARSHAL YES 21", one_message},
        ReplyRow{"UnknownStatus",
                 {"4A3 110003ABCD03"},
                 "MARSHAL YES 21",
                 {{"messages_received", 1}, {"malformed_messages", 1}}},
        ReplyRow{"UnknownStatusOfAnotherCall",
                 {"4A3 110003ABCE03"},
                 "waiting",
                 {{"messages_received", 1}, {"malformed_messages", 1}}},
        ReplyRow{"OtherRequestId",
                 {"4A3 110003ABCE00"},
                 "waiting",
                 {{"messages_received", 1}, {"unmatched_replies", 1}}},
        ReplyRow{"OtherPeer",
                 {"4A4 110003ABCD00"},
                 "waiting",
                 {{"messages_received", 1}, {"unmatched_replies", 1}}},
        ReplyRow{"Twice",
                 {"4A3 110004ABCD002A", "4A3 110004ABCD002A"},
                 "NO_EXCEPTION 2A",
                 {{"messages_received", 2}, {"unmatched_replies", 1}}},
        // 2 octets are less than a Reply has; the reassembler counts it, and nobody else.
        ReplyRow{"ImpossibleSize", {"4A3 110002ABCD"}, "waiting", {{"malformed_messages", 1}}},
        // 61 octets, one above the limit.
        ReplyRow{"TooLong",
                 frames_of("4A3", "11003AABCD00" + std::string(110, '0')),
                 "IMP_LIMIT YES 32",
                 {{"oversize_messages", 1}}},
        ReplyRow{"TooLongWithUnknownStatus",
                 frames_of("4A3", "11003AABCD09" + std::string(110, '0')),
                 "IMP_LIMIT YES 32",
                 {{"oversize_messages", 1}}},
        ReplyRow{"TooLongOfAnotherCall",
                 frames_of("4A3", "11003AABCE00" + std::string(110, '0')),
                 "waiting",
                 {{"oversize_messages", 1}, {"unmatched_replies", 1}}},
        ReplyRow{"AsLongAsAllowed", frames_of("4A3", "110039ABCD00" + std::string(108, '0')),
                 "NO_EXCEPTION " + std::string(108, '0'), one_message},
        ReplyRow{"MessageError",
                 {"4A3 120000"},
                 "COMM_FAILURE MAYBE 8",
                 {{"messages_received", 1}, {"message_errors_received", 1}}},
        ReplyRow{"MessageErrorOfAnotherNode",
                 {"4A4 120000"},
                 "waiting",
                 {{"messages_received", 1}, {"message_errors_received", 1}}},
        ReplyRow{
            "MessageErrorWithASize", {"4A3 12000100"}, "waiting", {{"malformed_messages", 1}}}),
    [](const auto& param) { return param.param.name; });

TEST(Calls, AMessageErrorFailsAllCallsToThatNodeAndNoOthers) {
    TestEngine node;
    const CallHandle first = node.call("1801");
    const CallHandle second = node.call("1802");
    const CallHandle elsewhere = node.call("2001");
    const CallHandle own = node.call("2801");
    node.transmit();
    node.receive("4A3 120000");
    EXPECT_EQ(node.result(first), "COMM_FAILURE MAYBE 8");
    EXPECT_EQ(node.result(second), "COMM_FAILURE MAYBE 8");
    EXPECT_EQ(node.result(elsewhere), "waiting");
    EXPECT_EQ(node.result(own), "waiting");
    EXPECT_THAT(node.transmit(), IsEmpty());
    // The next call works.
    const CallHandle next = node.call("1801");
    EXPECT_THAT(node.transmit(), ElementsAre("465 100005ABD0180102"));
    node.receive("4A3 110003ABD000");
    EXPECT_EQ(node.result(next), "NO_EXCEPTION ");
}

TEST(Calls, RepliesMayComeInAnyOrder) {
    TestEngine node;
    const CallHandle first = node.call("1801");
    const CallHandle second = node.call("1801");
    node.transmit();
    node.receive("4A3 110004ABCE0002");
    node.receive("4A3 110004ABCD0001");
    EXPECT_EQ(node.result(first), "NO_EXCEPTION 01");
    EXPECT_EQ(node.result(second), "NO_EXCEPTION 02");
}

TEST(Calls, ACallThatIsNotKnownIsInternal) {
    TestEngine node;
    const CallHandle call = node.call("1801");
    node.transmit();
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.result(call), "NO_EXCEPTION ");
    EXPECT_EQ(node.result(call), "INTERNAL MAYBE 42");
    EXPECT_FALSE(node.engine.message_of(call).has_value());
}

// ---- limits

TEST(Limits, AFullTransmitQueueIsNoResourcesAtOnce) {
    auto options = TestEngine::options();
    options.transmit.max_messages = 2;
    TestEngine node{options};
    EXPECT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    const CallHandle first = node.call("1801");
    EXPECT_EQ(node.send("1801"), "queued");
    EXPECT_EQ(describe(node.try_call("1801").error()), "NO_RESOURCES NO 10");
    EXPECT_EQ(node.send("1801"), "NO_RESOURCES NO 10");
    EXPECT_EQ(node.multicast(7), "NO_RESOURCES NO 10");
    EXPECT_THAT(node.requests(), IsEmpty());  // not even the local members got it
    EXPECT_EQ(node.transmit().size(), 2U);
    const CallHandle next = node.call("1801");
    node.transmit();
    node.receive("4A3 110003ABCD00");
    EXPECT_EQ(node.result(first), "NO_EXCEPTION ");
    EXPECT_EQ(node.result(next), "waiting");
}

TEST(Limits, AQueueFullOfOctetsIsNoResourcesToo) {
    auto options = TestEngine::options();
    options.transmit.max_octets = 20;
    TestEngine node{options};
    EXPECT_EQ(node.send("1801", 2, "01020304"), "queued");
    EXPECT_EQ(node.send("1801", 2, "01"), "NO_RESOURCES NO 10");
    EXPECT_EQ(node.send("1801", 2, ""), "queued");
}

TEST(Limits, TooManyOutstandingCallsAreNoResources) {
    auto options = TestEngine::options();
    options.max_outstanding_calls = 2;
    TestEngine node{options};
    const CallHandle first = node.call("1801");
    const CallHandle second = node.call("1801");
    node.transmit();
    EXPECT_EQ(describe(node.try_call("1801").error()), "NO_RESOURCES NO 11");
    EXPECT_EQ(describe(node.try_call("2801").error()), "NO_RESOURCES NO 11");
    EXPECT_EQ(node.send("1801"), "queued");  // waits for nothing
    node.receive("4A3 110003ABCD00");
    // Ended, but its result is still to be fetched.
    EXPECT_EQ(describe(node.try_call("1801").error()), "NO_RESOURCES NO 11");
    EXPECT_EQ(node.result(first), "NO_EXCEPTION ");
    EXPECT_TRUE(node.try_call("1801").ok());
    EXPECT_EQ(node.result(second), "waiting");
}

TEST(Limits, ACallThatWasRefusedLeavesNothingBehind) {
    auto options = TestEngine::options();
    options.max_outstanding_calls = 1;
    options.max_incoming_requests = 1;
    options.transmit.max_messages = 1;
    TestEngine node{options};
    EXPECT_EQ(node.send("1801"), "queued");
    EXPECT_EQ(node.send("2801"), "own");
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(describe(node.try_call("1801").error()), "NO_RESOURCES NO 10");
        EXPECT_EQ(describe(node.try_call("2801").error()), "TRANSIENT NO 15");
    }
    EXPECT_EQ(node.engine.next_deadline(), node.now + 1s);  // the oneway's
    node.transmit();
    EXPECT_TRUE(node.try_call("1801").ok());
}

TEST(Limits, WithoutANodeNumberNothingGoesToTheBus) {
    auto options = TestEngine::options();
    options.node.reset();
    TestEngine node{options};
    EXPECT_EQ(describe(node.try_call("1801").error()), "BAD_INV_ORDER NO 36");
    EXPECT_EQ(node.send("1801"), "BAD_INV_ORDER NO 36");
    EXPECT_EQ(node.multicast(7), "BAD_INV_ORDER NO 36");
    EXPECT_THAT(node.transmit(), IsEmpty());
    // Groups reach it all the same.
    EXPECT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    node.receive(
        "0E3 1000050001"
        "4DDB"
        "02");
    EXPECT_THAT(node.requests(), ElementsAre("group 7 key 4DDB operation 2 "));
    node.receive("4A3 1000050001280102");
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_EQ(
        node.counted(),
        (Counted{{"frames_received", 1}, {"messages_received", 1}, {"frames_for_other_nodes", 1}}));
    node.engine.set_node(NodeId{5});
    node.call("1801");
    EXPECT_THAT(node.transmit(), ElementsAre("465 100005ABCD180102"));
}

TEST(Limits, ANewNodeNumberIsUsedAtOnce) {
    TestEngine node;
    node.engine.set_node(NodeId{6});
    const CallHandle call = node.call("1801");
    EXPECT_THAT(node.transmit(), ElementsAre("466 100005ABCD180102"));
    node.receive("4A3 110003ABCD00");  // to 5
    EXPECT_EQ(node.result(call), "waiting");
    node.receive("4C3 110003ABCD00");  // to 6
    EXPECT_EQ(node.result(call), "NO_EXCEPTION ");
    EXPECT_EQ(node.send("3001"), "own");
    EXPECT_EQ(node.send("2801"), "queued");
}

// ---- objects of this node

TEST(OwnNode, ACallNeverReachesTheBus) {
    TestEngine node;
    const CallHandle call = node.call("2801", 7, "2A");
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_FALSE(node.engine.message_of(call).has_value());
    EXPECT_TRUE(node.engine.has_request());
    EXPECT_THAT(node.requests(), ElementsAre("object 1 operation 7 2A"));
    EXPECT_EQ(node.result(call), "waiting");
    node.answer("2B");
    EXPECT_EQ(node.result(call), "NO_EXCEPTION 2B");
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_EQ(node.counted(), Counted{});
}

TEST(OwnNode, ExceptionsComeBackAsFromAfar) {
    TestEngine node;
    CallHandle call = node.call("2801");
    EXPECT_EQ(node.requests().size(), 1U);
    node.answer("0100", giop::ReplyStatus::user_exception);
    EXPECT_EQ(node.result(call), "USER_EXCEPTION 0100");
    call = node.call("2801");
    EXPECT_EQ(node.requests().size(), 1U);
    node.engine.refuse(node.caller, {SystemErrorKind::object_not_exist, Completion::no}, node.now);
    EXPECT_EQ(node.result(call), "OBJECT_NOT_EXIST NO");
    EXPECT_THAT(node.transmit(), IsEmpty());
}

TEST(OwnNode, ACallNotBegunAtItsDeadlineIsNeverExecuted) {
    TestEngine node;
    const CallHandle call = node.call("2801", 2, "", 20ms);
    EXPECT_EQ(node.engine.next_deadline(), node.now + 20ms);
    node.advance(20ms);
    EXPECT_EQ(node.result(call), "TIMEOUT NO 3");
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_EQ(node.counted(), (Counted{{"calls_timed_out", 1}}));
}

TEST(OwnNode, ACallBegunAtItsDeadlineMayHaveHappened) {
    TestEngine node;
    const CallHandle call = node.call("2801", 2, "", 20ms);
    EXPECT_EQ(node.requests().size(), 1U);
    node.advance(20ms);
    EXPECT_EQ(node.result(call), "TIMEOUT MAYBE 2");
    node.answer("2B");
    node.engine.refuse(node.caller, {}, node.now);
    EXPECT_EQ(node.counted(), (Counted{{"calls_timed_out", 1}, {"unmatched_replies", 2}}));
}

TEST(OwnNode, TooManyWaitingIsTransient) {
    auto options = TestEngine::options();
    options.max_incoming_requests = 1;
    TestEngine node{options};
    EXPECT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    EXPECT_EQ(node.send("2801", 3, "2A"), "own");
    EXPECT_EQ(describe(node.try_call("2801").error()), "TRANSIENT NO 15");
    EXPECT_EQ(node.send("2801"), "TRANSIENT NO 15");
    // A multicast that some members could not get does not begin.
    EXPECT_EQ(node.multicast(7), "TRANSIENT NO 15");
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_THAT(node.requests(), ElementsAre("object 1 operation 3 2A"));
    EXPECT_EQ(node.multicast(7), "queued");
}

TEST(OwnNode, OnewayNeedsNoAnswer) {
    TestEngine node;
    EXPECT_EQ(node.send("2801", 3, "2A"), "own");
    EXPECT_THAT(node.requests(), ElementsAre("object 1 operation 3 2A"));
    node.answer("00");
    node.engine.refuse(node.caller, {}, node.now);
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_EQ(node.counted(), Counted{});
}

TEST(OwnNode, ItsGroupMembersGetAMulticastToo) {
    TestEngine node;
    EXPECT_EQ(node.multicast(7, 0x4DDB, 2, "2A"), "queued");
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    EXPECT_EQ(node.multicast(7, 0, 2, "2A"), "queued");
    EXPECT_EQ(node.multicast(8, 0, 2, "2A"), "queued");
    EXPECT_THAT(node.requests(), ElementsAre("group 7 key 0000 operation 2 2A"));
    EXPECT_TRUE(std::holds_alternative<NoAnswer>(node.caller));
    EXPECT_THAT(node.transmit(), ElementsAre("0E5 100006ABCD"
                                             "4DDB"
                                             "02",
                                             "0E5 812A",
                                             "0E5 100006ABCE"
                                             "0000"
                                             "02",
                                             "0E5 812A",
                                             "105 100006ABCF"
                                             "0000"
                                             "02",
                                             "105 812A"));
}

}  // namespace
}  // namespace canorb::core
