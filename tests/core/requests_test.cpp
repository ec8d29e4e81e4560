// The engine as a server: Requests in, for servants or refused, and answers out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/test_engine.hpp"

namespace canorb::core {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::IsEmpty;

// Node 5, object 1 is 2801. Replies to node 3 go on 465.

TEST(Requests, AVoidCallIsOneFrameInAndOneBack) {
    TestEngine node;
    node.receive("4A3 1000051234280102");
    EXPECT_TRUE(node.engine.has_request());
    EXPECT_THAT(node.requests(), ElementsAre("object 1 operation 2 "));
    EXPECT_FALSE(node.engine.has_request());
    node.answer();
    EXPECT_THAT(node.transmit(), ElementsAre("465 110003123400"));
    EXPECT_EQ(node.counted(), (Counted{{"frames_received", 1},
                                       {"messages_received", 1},
                                       {"frames_sent", 1},
                                       {"messages_sent", 1}}));
}

TEST(Requests, ParametersAndResultsGoInFurtherFrames) {
    TestEngine node;
    node.receive("4A3 100019ABCD280107");
    node.receive("4A3 81116D61785F6163");
    node.receive("4A3 8263656C65726174");
    EXPECT_FALSE(node.engine.has_request());
    node.receive("4A3 83696F6E00032A");
    EXPECT_THAT(node.requests(),
                ElementsAre("object 1 operation 7 116D61785F616363656C65726174696F6E00032A"));
    node.answer("0102030405060708090A", giop::ReplyStatus::user_exception);
    EXPECT_THAT(node.transmit(),
                ElementsAre("465 11000DABCD010102", "465 8103040506070809", "465 820A"));
}

TEST(Requests, AGroupsRequestIsNeverAnswered) {
    TestEngine node;
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    node.receive(
        "0E3 1000061234"
        "4DDB"
        "02");
    node.receive("0E3 812A");
    EXPECT_THAT(node.requests(), ElementsAre("group 7 key 4DDB operation 2 2A"));
    node.answer("01");
    node.engine.refuse(node.caller, {SystemErrorKind::bad_operation, Completion::no}, node.now);
    EXPECT_THAT(node.transmit(), IsEmpty());
}

// ---- refused

TEST(Requests, AnExceptionIsItsIdMinorAndCompletion) {
    TestEngine node;
    node.receive("4A3 1000051234280102");
    EXPECT_EQ(node.requests().size(), 1U);
    node.engine.refuse(node.caller, {SystemErrorKind::timeout, Completion::maybe, 2}, node.now);
    // "IDL:omg.org/CORBA/TIMEOUT:1.0"
    EXPECT_THAT(node.transmit(),
                ElementsAre("465 1100241234021E49", "465 81444C3A6F6D672E", "465 826F72672F434F52",
                            "465 8342412F54494D45", "465 844F55543A312E30", "465 85000202"));
}

TEST(Requests, AnotherNodeInTheKeyIsObjectNotExist) {
    TestEngine node;
    node.receive("4A3 1000051234180102");  // node 3
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_THAT(node.transmit(),
                ElementsAreArray(frames_of(
                    "465", system_exception_reply("1234", "OBJECT_NOT_EXIST", "11", "01"))));
    EXPECT_EQ(node.counted()["requests_refused"], 1U);
}

TEST(Requests, TooManyWaitingIsTransient) {
    auto options = TestEngine::options();
    options.max_incoming_requests = 2;
    TestEngine node{options};
    node.receive("4A3 1000050001280102");
    node.receive("4A3 1000050002280102");
    node.receive("4A3 1000050003280102");
    EXPECT_THAT(node.transmit(),
                ElementsAreArray(
                    frames_of("465", system_exception_reply("0003", "TRANSIENT", "0D", "01"))));
    EXPECT_EQ(node.counted()["requests_refused"], 1U);
    EXPECT_EQ(node.requests().size(), 2U);
    node.receive("4A3 1000050004280102");
    EXPECT_EQ(node.requests().size(), 1U);
}

TEST(Requests, OfGroupsTooManyAreDroppedAndCounted) {
    auto options = TestEngine::options();
    options.max_incoming_requests = 1;
    TestEngine node{options};
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    node.receive(
        "0E3 1000050001"
        "4DDB"
        "02");
    node.receive(
        "0E3 1000050002"
        "4DDB"
        "02");
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_EQ(node.requests().size(), 1U);
    EXPECT_EQ(
        node.counted(),
        (Counted{{"frames_received", 2}, {"messages_received", 2}, {"group_requests_dropped", 1}}));
}

TEST(Requests, ALongOneIsImpLimit) {
    auto options = TestEngine::options();
    options.receive.max_message = 16;
    TestEngine node{options};
    const Texts long_request = frames_of("4A3",
                                         "10000E1234280102"
                                         "000102030405060708");
    node.receive(Texts{long_request.begin(), long_request.end() - 1});
    EXPECT_THAT(node.transmit(), IsEmpty());  // not before its end
    node.receive(long_request.back());
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_THAT(node.transmit(),
                ElementsAreArray(
                    frames_of("465", system_exception_reply("1234", "IMP_LIMIT", "1F", "01"))));
    EXPECT_EQ(node.counted(), (Counted{{"frames_received", 3},
                                       {"oversize_messages", 1},
                                       {"requests_refused", 1},
                                       {"frames_sent", 6},
                                       {"messages_sent", 1}}));
    // One octet less is not too long.
    node.receive(frames_of("4A3",
                           "10000D1235280102"
                           "0001020304050607"));
    EXPECT_THAT(node.requests(), ElementsAre("object 1 operation 2 0001020304050607"));
}

TEST(Requests, ALongOneToAGroupIsOnlyCounted) {
    auto options = TestEngine::options();
    options.receive.max_message = 16;
    TestEngine node{options};
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    node.receive(frames_of("0E3",
                           "10000E1234"
                           "4DDB"
                           "02"
                           "000102030405060708"));
    EXPECT_THAT(node.requests(), IsEmpty());
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_EQ(node.counted(), (Counted{{"frames_received", 3}, {"oversize_messages", 1}}));
}

// ---- at most once

TEST(Duplicates, ARequestOfOneFrameThatCanDeliversTwiceRunsOnce) {
    TestEngine node;
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    node.receive("4A3 1000051234280102");
    node.receive("4A3 1000051234280102");
    node.receive(
        "0E3 1000051235"
        "4DDB"
        "02");
    node.receive(
        "0E3 1000051235"
        "4DDB"
        "02");
    EXPECT_THAT(node.requests(),
                ElementsAre("object 1 operation 2 ", "group 7 key 4DDB operation 2 "));
    EXPECT_EQ(node.counted()["duplicate_requests"], 2U);
}

TEST(Duplicates, NoTimeIsInvolved) {
    TestEngine node;
    node.receive("4A3 1000051234280102");
    node.advance(1h);
    node.receive("4A3 1000051234280102");
    EXPECT_EQ(node.requests().size(), 1U);
}

TEST(Duplicates, OnlyTheRequestBeforeCounts) {
    TestEngine node;
    node.receive("4A3 1000050000280102");  // 0 is an id like others, and the first here
    node.receive("4A3 1000050001280102");
    node.receive("4A3 1000050000280102");
    EXPECT_EQ(node.requests().size(), 3U);
    EXPECT_EQ(node.counted().count("duplicate_requests"), 0U);
}

TEST(Duplicates, EachIdentifierIsOnItsOwn) {
    TestEngine node;
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    ASSERT_TRUE(node.engine.join(GroupId{8}, {1, &bell}));
    node.receive("4A3 1000051234280102");
    node.receive("4A4 1000051234280102");
    node.receive(
        "0E3 1000051234"
        "4DDB"
        "02");
    node.receive(
        "103 1000051234"
        "4DDB"
        "02");
    EXPECT_EQ(node.requests().size(), 4U);
}

TEST(Duplicates, AWholeMessageOfManyFramesToo) {
    TestEngine node;
    const Texts frames = frames_of("4A3",
                                   "100007"
                                   "1234"
                                   "2801"
                                   "02"
                                   "0102");
    node.receive(frames);
    node.receive(frames);
    EXPECT_EQ(node.requests().size(), 1U);
    EXPECT_EQ(node.counted()["duplicate_requests"], 1U);
}

TEST(Duplicates, ARefusedRequestIsRefusedOnce) {
    auto options = TestEngine::options();
    options.receive.max_message = 16;
    TestEngine node{options};
    node.receive("4A3 1000051234180102");
    node.receive("4A3 1000051234180102");
    EXPECT_EQ(
        node.transmit().size(),
        frames_of("465", system_exception_reply("1234", "OBJECT_NOT_EXIST", "11", "01")).size());
    const Texts long_request = frames_of("4A3",
                                         "10000E1235280102"
                                         "000102030405060708");
    node.receive(long_request);
    node.receive(long_request);
    const Counted counted = node.counted();
    EXPECT_EQ(counted.at("requests_refused"), 2U);
    EXPECT_EQ(counted.at("duplicate_requests"), 2U);
}

// ---- what is no GIOP/CAN 1.0

struct MalformedRow {
    std::string name;
    Texts frames;
    bool answered;  ///< with a MessageError
    Counted counters;
};

class MalformedMessages : public testing::TestWithParam<MalformedRow> {};

TEST_P(MalformedMessages, AreRefused) {
    TestEngine node;
    ASSERT_TRUE(node.engine.join(GroupId{7}, {1, &bell}));
    node.receive(GetParam().frames);
    EXPECT_THAT(node.requests(), IsEmpty());
    Counted counters = node.counted();
    counters.erase("frames_received");
    EXPECT_EQ(counters, GetParam().counters);
    EXPECT_EQ(node.transmit(), GetParam().answered ? Texts{"465 120000"} : Texts{});
    // The next call works.
    node.receive("4A3 1000051234280102");
    EXPECT_EQ(node.requests().size(), 1U);
}

const Counted refused{{"malformed_messages", 1}, {"message_errors_sent", 1}};
const Counted ignored{{"malformed_messages", 1}};

INSTANTIATE_TEST_SUITE_P(
    All, MalformedMessages,
    testing::Values(
        MalformedRow{"UnknownType", {"4A3 1300051234280102"}, true, refused},
        MalformedRow{"MinorVersion1", {"4A3 1400051234280102"}, true, refused},
        MalformedRow{"MajorVersion0", {"4A3 0000051234280102"}, true, refused},
        MalformedRow{"MajorVersion2", {"4A3 2000051234280102"}, true, refused},
        MalformedRow{"Bit6", {"4A3 5000051234280102"}, true, refused},
        MalformedRow{"RequestTooSmall", {"4A3 10000412342801"}, true, refused},
        MalformedRow{"RequestOfNothing", {"4A3 100000"}, true, refused},
        MalformedRow{"ItsOtherFramesAreDropped",
                     {"4A3 1400101234280102", "4A3 8101020304050607", "4A3 8208"},
                     true,
                     {{"malformed_messages", 1},
                      {"message_errors_sent", 1},
                      {"continuations_without_message", 2}}},
        // Never in answer to a Reply, a MessageError, or what came to a group.
        MalformedRow{"ReplyTooSmall", {"4A3 1100021234"}, false, ignored},
        MalformedRow{"MessageErrorWithASize", {"4A3 120005123428"}, false, ignored},
        MalformedRow{"ToAGroup",
                     {"0E3 140005123428"
                      "4DDB"},
                     false,
                     ignored},
        MalformedRow{"RequestToAGroupTooSmall", {"0E3 10000412344DDB"}, false, ignored},
        // Nothing is said to what is no message at all.
        MalformedRow{"FirstFrameTooShort", {"4A3 1000"}, false, {{"short_first_frames", 1}}},
        MalformedRow{"EmptyFrame", {"4A3 "}, false, {{"short_first_frames", 1}}},
        MalformedRow{
            "ContinuationOfNothing", {"4A3 8100"}, false, {{"continuations_without_message", 1}}},
        MalformedRow{"ShorterThanItSays", {"4A3 10000512342801"}, false, {{"short_frames", 1}}},
        MalformedRow{"LongerThanItSays", {"4A3 12000000"}, false, {{"excess_octets", 1}}},
        // Well formed, but not for a group.
        MalformedRow{"ReplyToAGroup",
                     {"0E3 110003123400"},
                     false,
                     {{"messages_received", 1}, {"replies_on_group", 1}}},
        MalformedRow{"BadReplyToAGroup",
                     {"0E3 110003123409"},
                     false,
                     {{"messages_received", 1}, {"replies_on_group", 1}}},
        MalformedRow{"MessageErrorToAGroup",
                     {"0E3 120000"},
                     false,
                     {{"messages_received", 1}, {"replies_on_group", 1}}}),
    [](const auto& param) { return param.param.name; });

TEST(MessageErrors, OneForEachPeerWithinAnInterFrameTimeout) {
    TestEngine node;
    node.receive("4A3 130000");
    node.receive("4A3 130000");
    node.receive("4A4 130000");
    EXPECT_THAT(node.transmit(), ElementsAre("465 120000", "485 120000"));
    node.advance(100ms - 1ns);
    node.receive("4A3 130000");
    EXPECT_THAT(node.transmit(), IsEmpty());
    node.advance(1ns);
    node.receive("4A3 130000");
    EXPECT_THAT(node.transmit(), ElementsAre("465 120000"));
    const Counted counted = node.counted();
    EXPECT_EQ(counted.at("malformed_messages"), 5U);
    EXPECT_EQ(counted.at("message_errors_sent"), 3U);
    EXPECT_EQ(counted.at("message_errors_suppressed"), 2U);
}

// ---- answers that do not get through

TEST(Answers, DroppedAndCountedWhenTheQueueIsFull) {
    auto options = TestEngine::options();
    options.transmit.max_messages = 1;
    TestEngine node{options};
    node.receive("4A3 1000051234280102");
    EXPECT_EQ(node.requests().size(), 1U);
    EXPECT_EQ(node.send("2001"), "queued");
    node.answer();
    node.receive("4A3 130000");
    const Counted counted = node.counted();
    EXPECT_EQ(counted.at("answers_dropped"), 2U);
    EXPECT_EQ(counted.count("message_errors_sent"), 0U);
    EXPECT_EQ(node.transmit().size(), 1U);
}

TEST(Answers, DroppedAndCountedWhenTheLinkIsDownOrTheNumberGone) {
    TestEngine node;
    node.receive("4A3 1000050001280102");
    node.receive("4A3 1000050002280102");
    node.receive("4A3 1000050003280102");
    auto first = node.engine.next_request(node.now);
    auto second = node.engine.next_request(node.now);
    auto third = node.engine.next_request(node.now);
    std::vector<std::uint8_t> message(giop::reply_header_size);
    node.state(can::ControllerState::bus_off);
    node.engine.answer(first->answer_to, giop::ReplyStatus::no_exception, message, node.now);
    node.state(can::ControllerState::error_active);
    node.engine.set_node({});
    node.engine.answer(second->answer_to, giop::ReplyStatus::no_exception, message, node.now);
    EXPECT_EQ(node.counted()["answers_dropped"], 2U);
    EXPECT_THAT(node.transmit(), IsEmpty());
    node.engine.set_node(NodeId{5});
    node.engine.answer(third->answer_to, giop::ReplyStatus::no_exception, message, node.now);
    EXPECT_THAT(node.transmit(), ElementsAre("465 110003000300"));
}

TEST(Answers, ExpireLikeOtherMessages) {
    auto options = TestEngine::options();
    options.answer_lifetime = 30ms;
    TestEngine node{options};
    node.receive("4A3 1000051234280102");
    EXPECT_EQ(node.requests().size(), 1U);
    node.answer();
    EXPECT_EQ(node.engine.next_deadline(), node.now + 30ms);
    node.advance(30ms);
    EXPECT_THAT(node.transmit(), IsEmpty());
    EXPECT_EQ(node.counted()["messages_expired"], 1U);
}

TEST(Answers, TooLongForTheFormatIsImpLimit) {
    TestEngine node;
    node.receive("4A3 1000051234280102");
    EXPECT_EQ(node.requests().size(), 1U);
    std::vector<std::uint8_t> message(65539);
    node.engine.answer(node.caller, giop::ReplyStatus::no_exception, message, node.now);
    EXPECT_THAT(node.transmit(),
                ElementsAreArray(
                    frames_of("465", system_exception_reply("1234", "IMP_LIMIT", "21", "00"))));
    const CallHandle own = node.call("2801");
    EXPECT_EQ(node.requests().size(), 1U);
    node.engine.answer(node.caller, giop::ReplyStatus::no_exception, message, node.now);
    EXPECT_EQ(node.result(own), "IMP_LIMIT YES 33");
}

TEST(Answers, GoToTheCallerEvenWhenOthersAskedMeanwhile) {
    TestEngine node;
    node.receive("4A3 1000051234280102");
    node.receive("4A4 1000051234280103");
    auto first = node.engine.next_request(node.now);
    auto second = node.engine.next_request(node.now);
    node.caller = second->answer_to;
    node.answer("02");
    node.caller = first->answer_to;
    node.answer("01");
    // 465 goes before 485.
    EXPECT_THAT(node.transmit(), ElementsAre("465 11000412340001", "485 11000412340002"));
}

}  // namespace
}  // namespace canorb::core
