#include "orb/caniop/reassembler.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/caniop/test_format.hpp"
#include "tests/support/octets.hpp"

namespace canorb::caniop {
namespace {

using canorb::test::hex;
using canorb::test::octets;
using namespace std::chrono_literals;

constexpr Identifier from_5{true, 3, 5};
constexpr Identifier from_6{true, 3, 6};
constexpr Identifier group_from_5{false, 3, 5};

std::string describe(const Reception& reception) {
    if (const auto* message = std::get_if<Message>(&reception)) return hex(message->octets);
    if (const auto* oversize = std::get_if<Oversize>(&reception))
        return "oversize " + hex(oversize->first_frame);
    if (const auto* malformed = std::get_if<Malformed>(&reception))
        return "malformed " + hex(malformed->first_frame);
    return "";
}

std::map<std::string, std::uint64_t> non_zero(const Counters& counters) {
    std::map<std::string, std::uint64_t> result;
    for (std::size_t i = 0; i < counter_count; ++i) {
        const auto counter = static_cast<Counter>(i);
        if (counters[counter] != 0) result[std::string(name(counter))] = counters[counter];
    }
    return result;
}

struct Step {
    std::string frame;        // payload
    std::string result = "";  // what accept() gives
    int at_ms = 0;
    Identifier from = from_5;
};

struct Rule {
    std::string name;
    std::vector<Step> steps;
    std::map<std::string, std::uint64_t> counters;
    ReassemblerLimits limits = {.max_message = 40};
};

// 22 octets, 3 frames; and the same header with other octets.
const std::string a0 = "1000130102030405", a1 = "81060708090A0B0C", a2 = "820D0E0F10111213";
const std::string whole_a =
    "10001301020304050607"
    "08090A0B0C0D0E0F10111213";
const std::string b0 = "100013A1A2A3A4A5", b1 = "81A6A7A8A9AAABAC", b2 = "82ADAEAFB0B1B2B3";
const std::string whole_b =
    "100013A1A2A3A4A5A6A7"
    "A8A9AAABACADAEAFB0B1B2B3";
// 43 octets, 6 frames: above the limit of 40.
const std::string big0 = "1000280102030405";

const Rule rules[] = {
    {"AMessageOfOneFrame", {{"120000", "120000"}}, {{"messages_received", 1}}},
    {"AMessageOfAFullFrame",
     {{"1000051234567890", "1000051234567890"}},
     {{"messages_received", 1}}},
    {"AMessageOfThreeFrames", {{a0}, {a1}, {a2, whole_a}}, {{"messages_received", 1}}},
    {"ALastFrameWithOneOctet",
     {{"1000060102030405"}, {"8106", "100006010203040506"}},
     {{"messages_received", 1}}},
    {"IdentifiersDoNotMix",
     {{a0},
      {b0, "", 0, from_6},
      {a0, "", 0, group_from_5},
      {b1, "", 0, from_6},
      {a1},
      {a1, "", 0, group_from_5},
      {a2, whole_a},
      {a2, whole_a, 0, group_from_5},
      {b2, whole_b, 0, from_6}},
     {{"messages_received", 3}}},
    {"ARepeatedContinuationIsADuplicate",
     {{a0}, {a1}, {a1}, {a2, whole_a}},
     {{"messages_received", 1}, {"duplicate_frames", 1}}},
    {"ARepeatedFirstFrameIsADuplicate",
     {{a0}, {a0}, {a1}, {a2, whole_a}},
     {{"messages_received", 1}, {"duplicate_frames", 1}}},
    {"ARepeatedLastFrameIsADuplicate",
     {{a0}, {a1}, {a2, whole_a}, {a2}, {b0}, {b1}, {b2, whole_b}},
     {{"messages_received", 2}, {"duplicate_frames", 1}}},
    {"ADuplicateDoesNotHoldAMessageOpen",
     {{a0, "", 0}, {a0, "", 80}, {a1, "", 120}},
     {{"duplicate_frames", 1}, {"reassembly_timeouts", 1}, {"continuations_without_message", 1}}},
    {"TheFirstFrameAgainAfterAContinuationIsANewMessage",
     {{a0}, {a1}, {a0}, {a1}, {a2, whole_a}},
     {{"messages_received", 1}, {"interrupted_messages", 1}}},
    {"ALostContinuation",
     {{a0}, {a2}, {b0}, {b1}, {b2, whole_b}},
     {{"messages_received", 1}, {"sequence_errors", 1}}},
    {"AfterASequenceErrorTheRestHasNoMessage",
     {{a0}, {a2}, {a1}, {a2}},
     {{"sequence_errors", 1}, {"continuations_without_message", 2}}},
    {"ContinuationZeroIsNotADuplicateOfTheFirstFrame",
     {{a0}, {"80060708090A0B0C"}},
     {{"sequence_errors", 1}}},
    {"ALostFirstFrame",
     {{a1}, {a2}, {b0}, {b1}, {b2, whole_b}},
     {{"messages_received", 1}, {"continuations_without_message", 2}}},
    {"AContinuationBehindAWholeMessage",
     {{a0}, {a1}, {a2, whole_a}, {"8314"}, {a2}},
     {{"messages_received", 1}, {"continuations_without_message", 2}}},
    {"AContinuationBehindAMessageOfOneFrame",
     {{a0}, {a1}, {a2, whole_a}, {"120000", "120000"}, {a2}},
     {{"messages_received", 2}, {"continuations_without_message", 1}}},
    {"AnEmptyContinuationWithoutMessage", {{"81"}}, {{"continuations_without_message", 1}}},
    {"AnotherFirstFrameInterrupts",
     {{a0}, {b0}, {b1}, {b2, whole_b}},
     {{"messages_received", 1}, {"interrupted_messages", 1}}},
    {"AMessageOfOneFrameInterrupts",
     {{a0}, {a1}, {"120000", "120000"}, {a2}},
     {{"messages_received", 1}, {"interrupted_messages", 1}, {"continuations_without_message", 1}}},
    {"AnEmptyFrameIsAShortFirstFrame",
     {{""}, {"120000", "120000"}},
     {{"messages_received", 1}, {"short_first_frames", 1}}},
    {"TwoOctetsAreAShortFirstFrame",
     {{"1000"}, {"8101"}},
     {{"short_first_frames", 1}, {"continuations_without_message", 1}}},
    {"AShortFirstFrameInterrupts",
     {{a0}, {"10"}, {a1}},
     {{"short_first_frames", 1},
      {"interrupted_messages", 1},
      {"continuations_without_message", 1}}},
    {"AFirstFrameBeyondItsMessage",
     {{"11000301020304"}, {"120000", "120000"}},
     {{"messages_received", 1}, {"excess_octets", 1}}},
    {"AFirstFrameThatIsNeitherFullNorTheLast",
     {{"10001301020304"}, {a1}, {a2}},
     {{"short_frames", 1}, {"continuations_without_message", 2}}},
    {"AFirstFrameShorterThanItsMessageOfOneFrame", {{"11000301"}}, {{"short_frames", 1}}},
    {"AHeaderAloneWhereMoreMustFollow", {{"100013"}}, {{"short_frames", 1}}},
    {"AContinuationThatIsNeitherFullNorTheLast",
     {{a0}, {"81060708090A0B"}, {a2}},
     {{"short_frames", 1}, {"continuations_without_message", 1}}},
    {"ALastFrameThatEndsTooEarly", {{a0}, {a1}, {"820D0E"}}, {{"short_frames", 1}}},
    {"AnEmptyContinuation", {{a0}, {"81"}}, {{"short_frames", 1}}},
    {"ALastFrameBeyondTheMessage",
     {{"1000060102030405"}, {"810607"}, {"120000", "120000"}},
     {{"messages_received", 1}, {"excess_octets", 1}}},
    {"AFrameJustInTime",
     {{a0, "", 7}, {a1, "", 107}, {a2, whole_a, 207}},
     {{"messages_received", 1}}},
    {"AContinuationTooLate",
     {{a0, "", 7}, {a1, "", 108}, {a2, "", 109}},
     {{"reassembly_timeouts", 1}, {"continuations_without_message", 2}}},
    {"AFirstFrameAfterTheTimeoutDoesNotInterrupt",
     {{a0, "", 0}, {a1, "", 50}, {b0, "", 151}, {b1, "", 152}, {b2, whole_b, 153}},
     {{"messages_received", 1}, {"reassembly_timeouts", 1}}},
    {"TheSameFirstFrameAfterTheTimeoutIsANewMessage",
     {{a0, "", 0}, {a0, "", 101}, {a1, "", 102}, {a2, whole_a, 103}},
     {{"messages_received", 1}, {"reassembly_timeouts", 1}}},
    {"AMalformedMessageIsToldAtOnce",
     {{"3F00130102030405", "malformed 3F00130102030405"}, {a1}, {a2}, {"120000", "120000"}},
     {{"messages_received", 1}, {"malformed_messages", 1}, {"continuations_without_message", 2}}},
    {"AMalformedMessageInterrupts",
     {{a0}, {"3F0000", "malformed 3F0000"}, {a1}},
     {{"malformed_messages", 1},
      {"interrupted_messages", 1},
      {"continuations_without_message", 1}}},
    {"AMalformedFirstFrameWithoutAHeaderIsShort", {{"3F"}}, {{"short_first_frames", 1}}},
    {"ALengthOfExactlyTheLimit",
     {{"1000250102030405"},
      {"8101020304050607"},
      {"8201020304050607"},
      {"8301020304050607"},
      {"8401020304050607"},
      {"8501020304",
       "1000250102030405"
       "01020304050607"
       "01020304050607"
       "01020304050607"
       "01020304050607"
       "01020304"}},
     {{"messages_received", 1}}},
    {"AnOversizeMessageIsToldAtItsEnd",
     {{big0},
      {a1},
      {a2},
      {"8314151617181920"},
      {"8421222324252627"},
      {"8528292A2B2C2D2E", "oversize " + big0},
      {"8528292A2B2C2D2E"},
      {"120000", "120000"}},
     {{"messages_received", 1}, {"oversize_messages", 1}, {"duplicate_frames", 1}}},
    {"AnOversizeMessageMayRepeatItsFrames",
     {{big0},
      {big0},
      {a1},
      {a1},
      {a2},
      {"8314151617181920"},
      {"8421222324252627"},
      {"8528292A2B2C2D2E", "oversize " + big0}},
     {{"oversize_messages", 1}, {"duplicate_frames", 2}}},
    {"AnOversizeMessageThatBreaksIsNotTold",
     {{big0}, {a1}, {"8314151617181920"}, {"8421222324252627"}, {"8528292A2B2C2D2E"}},
     {{"sequence_errors", 1}, {"continuations_without_message", 2}}},
    {"AnOversizeMessageThatIsInterruptedIsNotTold",
     {{big0}, {a1}, {"120000", "120000"}},
     {{"messages_received", 1}, {"interrupted_messages", 1}}},
    {"AnOversizeMessageThatIsLateIsNotTold",
     {{big0, "", 0}, {a1, "", 101}},
     {{"reassembly_timeouts", 1}, {"continuations_without_message", 1}}},
    {"AnOversizeMessageOfOneFrameIsToldAtOnce",
     {{"1000051234567890", "oversize 1000051234567890"}, {"120000", "120000"}},
     {{"messages_received", 1}, {"oversize_messages", 1}},
     {.max_message = 3}},
    {"ASmallLimitStillSkipsLongerMessages",
     {{"1000060102030405"}, {"8106", "oversize 1000060102030405"}},
     {{"oversize_messages", 1}},
     {.max_message = 3}},
    {"TheMessageWhoseLastFrameIsTheOldestGivesWay",
     {{a0, "", 1, from_5},
      {b0, "", 2, from_6},
      {a1, "", 3, from_5},
      {a0, "", 4, group_from_5},
      {b1, "", 5, from_6},
      {a2, whole_a, 6, from_5},
      {a1, "", 7, group_from_5},
      {a2, whole_a, 8, group_from_5}},
     {{"messages_received", 2}, {"reassemblies_evicted", 1}, {"continuations_without_message", 1}},
     {.max_message = 40, .max_reassemblies = 2}},
    {"AStaleMessageThatGivesWayHasTimedOut",
     {{b0, "", 0, from_6}, {a0, "", 101}, {a1, "", 102}, {a2, whole_a, 103}},
     {{"messages_received", 1}, {"reassembly_timeouts", 1}},
     {.max_message = 40, .max_reassemblies = 1}},
    {"AFinishedMessageGivesWayToAnOpenOne",
     {{a0},
      {a1},
      {a2, whole_a},
      {b0, "", 0, from_6},
      {a2},
      {b1, "", 0, from_6},
      {b2, whole_b, 0, from_6}},
     {{"messages_received", 2}, {"continuations_without_message", 1}},
     {.max_message = 40, .max_reassemblies = 1}},
    {"AMessageOfOneFrameNeedsNoPlace",
     {{a0}, {"120000", "120000", 0, from_6}, {a1}, {a2, whole_a}},
     {{"messages_received", 2}},
     {.max_message = 40, .max_reassemblies = 1}},
};

class ReassemblerRule : public testing::TestWithParam<Rule> {};

TEST_P(ReassemblerRule, Holds) {
    Counters counters;
    Reassembler reassembler(GetParam().limits, test::message_format, counters);
    std::size_t number = 0;
    for (const Step& step : GetParam().steps) {
        const auto payload = octets(step.frame);
        const Reception reception =
            reassembler.accept(step.from, payload, TimePoint{} + step.at_ms * 1ms);
        EXPECT_EQ(describe(reception), step.result) << "step " << number << ": " << step.frame;
        ++number;
    }
    EXPECT_EQ(non_zero(counters), GetParam().counters);

    // Whatever happened, the next message works.
    if (GetParam().limits.max_message < 22) return;
    const auto later = TimePoint{} + 200ms;
    EXPECT_EQ(describe(reassembler.accept(from_5, octets(b0), later)), "");
    EXPECT_EQ(describe(reassembler.accept(from_5, octets(b1), later)), "");
    EXPECT_EQ(describe(reassembler.accept(from_5, octets(b2), later)), whole_b);
}

INSTANTIATE_TEST_SUITE_P(Table, ReassemblerRule, testing::ValuesIn(rules),
                         [](const auto& rule) { return rule.param.name; });

TEST(Reassembler, DropsEveryPartialMessageWhenTheLinkLostFrames) {
    Counters counters;
    Reassembler reassembler({}, test::message_format, counters);
    const auto accept = [&](Identifier from, const std::string& frame) {
        return describe(reassembler.accept(from, octets(frame), TimePoint{}));
    };
    EXPECT_EQ(accept(from_5, a0), "");
    EXPECT_EQ(accept(from_6, b0), "");
    EXPECT_EQ(reassembler.open(), 2U);
    reassembler.drop_all();
    EXPECT_EQ(reassembler.open(), 0U);
    EXPECT_EQ(accept(from_5, a1), "");
    EXPECT_EQ(accept(from_6, b1), "");
    EXPECT_EQ(accept(from_5, a0), "");
    EXPECT_EQ(accept(from_5, a1), "");
    EXPECT_EQ(accept(from_5, a2), whole_a);
    reassembler.drop_all();
    EXPECT_EQ(non_zero(counters),
              (std::map<std::string, std::uint64_t>{{"partials_lost_with_frames", 2},
                                                    {"continuations_without_message", 2},
                                                    {"messages_received", 1}}));
}

TEST(Reassembler, SaysWhoSentTheMessageAndDoesNotCopyOneFrame) {
    Counters counters;
    Reassembler reassembler({}, test::message_format, counters);
    const auto payload = octets("1100030A0B0C");
    const Reception one = reassembler.accept(group_from_5, payload, TimePoint{});
    ASSERT_TRUE(std::holds_alternative<Message>(one));
    EXPECT_EQ(std::get<Message>(one).from, group_from_5);
    EXPECT_EQ(std::get<Message>(one).octets.data(), payload.data());
    const auto refused = octets("3F0000");
    const Reception malformed = reassembler.accept(from_6, refused, TimePoint{});
    ASSERT_TRUE(std::holds_alternative<Malformed>(malformed));
    EXPECT_EQ(std::get<Malformed>(malformed).from, from_6);
}

TEST(Reassembler, CountsOpenMessages) {
    Counters counters;
    Reassembler reassembler({.max_reassemblies = 2}, test::message_format, counters);
    for (std::uint8_t sender = 0; sender < 20; ++sender) {
        EXPECT_EQ(describe(reassembler.accept({true, 3, sender}, octets(a0), TimePoint{})), "");
        EXPECT_EQ(reassembler.open(), std::min<std::size_t>(sender + 1U, 2U));
    }
    EXPECT_EQ(counters[Counter::reassemblies_evicted], 18U);
}

}  // namespace
}  // namespace canorb::caniop
