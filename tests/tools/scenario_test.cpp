// Scenarios in virtual time: what is told of them, with times counted in bits by hand. At 1 Mbit/s
// a bit is a microsecond. Frame 123#DEADBEEF00000000 has 115 bits up to the end of EOF.

#include "tools/scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orb/can/sim/fault_injector.hpp"
#include "tools/bus_table.hpp"

namespace canorb::tools {
namespace {

using namespace std::chrono_literals;
using can::Frame;
using testing::ElementsAre;
using testing::HasSubstr;

struct Played {
    std::string events;
    std::string table;
};

Played played(std::string_view text, const PlayOptions& options = {},
              std::string_view faults = "") {
    constexpr std::uint32_t bitrate = 1'000'000;
    const auto scenario = parse_scenario(text);
    EXPECT_TRUE(scenario) << (scenario ? "" : scenario.error().front());
    auto script = can::sim::parse_fault_script(faults);
    EXPECT_TRUE(script);
    can::sim::Bus bus{bitrate};
    can::sim::FaultInjector injector{std::move(*script), bitrate};
    if (!faults.empty()) bus.set_disturbance(&injector);
    Played result;
    result.table = bus_table(play(*scenario, options, bus,
                                  [&](const std::string& line) { result.events += line + '\n'; }));
    return result;
}

std::string events(std::string_view text, const PlayOptions& options = {},
                   std::string_view faults = "") {
    return played(text, options, faults).events;
}

PlayOptions with_listeners(std::vector<std::string> names) {
    PlayOptions options;
    options.listeners = std::move(names);
    return options;
}

constexpr std::string_view one_frame = "(0.000000) a 123#DEADBEEF00000000\n";

TEST(Scenario, IsRead) {
    const auto scenario = parse_scenario(
        "# who sends what\n"
        "\n"
        "(0.002000) pump-3 1ABCDEF0#R2\r\n"
        "  (0.001000) valve 123#DEAD  \n"
        "(0.001000) pump-3 124#");
    ASSERT_TRUE(scenario);
    ASSERT_EQ(scenario->lines.size(), 3U);
    EXPECT_EQ(scenario->lines[0].time, TimePoint{1ms});
    EXPECT_EQ(scenario->lines[0].node, "valve");
    EXPECT_EQ(scenario->lines[0].frame.id, 0x123U);
    EXPECT_EQ(scenario->lines[0].frame.length, 2);
    EXPECT_EQ(scenario->lines[1].node, "pump-3");
    EXPECT_EQ(scenario->lines[1].frame.id, 0x124U);
    EXPECT_EQ(scenario->lines[2].time, TimePoint{2ms});
    EXPECT_TRUE(scenario->lines[2].frame.extended);
    EXPECT_TRUE(scenario->lines[2].frame.remote);
}

TEST(Scenario, MayBeEmpty) {
    const Played nothing = played("# nothing\n");
    EXPECT_EQ(nothing.events, "");
    EXPECT_EQ(nothing.table,
              "1000000 bit/s, 0.000000 s, load 0.00 %, 0 frames, 0 error frames\n"
              "no nodes\n");
}

TEST(Scenario, SaysWhatIsWrongInWhichLine) {
    const auto scenario = parse_scenario(
        "(0.0) a 123#00\n"
        "(0.000000) a 123#00\n"
        "(0.000000) a 800#00\n"
        "(0.000000) 123#00\n"
        "(0.000000) a 123#00 x\n"
        "(0.000000) a 123##0112233\n"
        "(0.000000) a 20000004#0000000000000000");
    ASSERT_FALSE(scenario);
    EXPECT_THAT(
        scenario.error(),
        ElementsAre(
            HasSubstr("1: bad time stamp, which has six decimals; a line is (SECONDS) NODE FRAME"),
            HasSubstr("3: bad identifier"), HasSubstr("4: bad interface"),
            HasSubstr("5: text after the frame"),
            "6: only data and remote frames of classic CAN can be played",
            "7: only data and remote frames of classic CAN can be played"));
}

TEST(Scenario, DurationsHaveUnits) {
    EXPECT_EQ(parse_duration("20ms"), 20ms);
    EXPECT_EQ(parse_duration("1.5s"), 1500ms);
    EXPECT_EQ(parse_duration("300us"), 300us);
    EXPECT_EQ(parse_duration("7ns"), 7ns);
    EXPECT_EQ(parse_duration("0s"), 0s);
    EXPECT_EQ(parse_duration("1000000s"), 1'000'000s);
    for (const std::string_view bad :
         {"", "20", "ms", "20 ms", "-1s", "1e3s", "20msx", "1000001s", "20m", "nans", "infs"}) {
        EXPECT_FALSE(parse_duration(bad)) << bad;
    }
}

TEST(Play, TellsWhoReceivedAFrame) {
    const Played result = played(one_frame, with_listeners({"b", "c"}));
    EXPECT_EQ(result.events, "  0.000115  a  123#DEADBEEF00000000  received by b, c\n");
    EXPECT_EQ(result.table,
              "1000000 bit/s, 0.000115 s, load 100.00 %, 1 frame, 0 error frames\n"
              "node  state         TEC  REC  sent  received  arbitrations lost  errors\n"
              "a     error active    0    0     1         0                  0       0\n"
              "b     error active    0    0     0         1                  0       0\n"
              "c     error active    0    0     0         1                  0       0\n");
}

// 7FF#01 has 57 bits and loses at once; 0x555#55 has 54 bits.
TEST(Play, TellsWhoLostAnArbitration) {
    EXPECT_EQ(
        events("(0.000100) pump-3 7FF#01\n"
               "(0.000100) a 123#DEADBEEF00000000\n"
               "(0.000500) valve 555#55\n"),
        "  0.000215  a       123#DEADBEEF00000000  received by pump-3, valve; pump-3 lost the "
        "arbitration at id.1\n"
        "  0.000275  pump-3  7FF#01                received by a, valve\n"
        "  0.000554  valve   555#55                received by pump-3, a\n");
}

// RTR of a standard remote frame and SRR of an extended one are both the 12th bit after SOF: a
// node that has both may have lost with either.
TEST(Play, NamesThe12thBitWhereItKnowsWithWhichFrameANodeLost) {
    const auto place = [](const std::string& loser) {
        const std::string told = events("(0.000100) a 123#\n" + loser);
        const std::size_t at = told.find(" lost the arbitration at ");
        if (at == std::string::npos) return told;
        return told.substr(at + 25, told.find('\n') - at - 25);
    };
    EXPECT_EQ(place("(0.000100) b 123#R\n"), "rtr");
    EXPECT_EQ(place("(0.000100) b 048C0000#\n"), "srr");
    EXPECT_EQ(place("(0.000100) b 048C0000#\n(0.000100) b 555#\n"), "srr");
    EXPECT_EQ(place("(0.000100) b 123#R\n(0.000110) b 048C0000#\n"), "rtr/srr");
}

TEST(Play, TellsOfTwoNodesThatSendOneFrame) {
    EXPECT_EQ(events("(0.000000) a 123#DEADBEEF00000000\n"
                     "(0.000000) b 123#DEADBEEF00000000\n",
                     with_listeners({"c"})),
              "  0.000115  a, b  123#DEADBEEF00000000  received by c\n");
}

// Data begins with the 20th bit. Its sender sees the first of it wrong and destroys the frame: the
// other one sees six dominant bits, 21 to 26. Two flags, 8 bits of delimiter, 3 of intermission:
// again from the 44th bit on.
TEST(Play, TellsOfErrors) {
    EXPECT_EQ(events(one_frame, with_listeners({"b"}), "frame 123 attempt 1 at data.1 flip a"),
              "  0.000020  a  bit error at data.1, sending, active flag, TEC 8, REC 0\n"
              "  0.000026  b  stuff error at the stuff bit after data.6, receiving, active flag, "
              "TEC 0, REC 1\n"
              "  0.000158  a  123#DEADBEEF00000000  received by b\n");
}

// The ACK slot is bit 107. Flag, delimiter and intermission have 17 bits: 124 bits for each of the
// first 16 attempts, then a passive flag and 8 bits of suspend transmission, 132.
TEST(Play, ALoneSenderIsErrorPassiveAndRepeatsWithoutEnd) {
    PlayOptions options;
    options.length = 2200us;
    std::string expected;
    for (int attempt = 1; attempt <= 16; ++attempt) {
        const std::string time = std::to_string(1'000'000 + 107 + 124 * (attempt - 1)).substr(1);
        expected += "  0." + time + "  a  ACK error at ack, sending, active flag, TEC " +
                    std::to_string(8 * attempt) + ", REC 0\n";
    }
    expected +=
        "  0.001967  a  is error passive, TEC 128, REC 0\n"
        "  0.002099  a  ACK error at ack, sending, passive flag, TEC 128, REC 0\n"
        "  0.002200  a  123#DEADBEEF00000000  still waits\n";
    EXPECT_EQ(events(one_frame, options), expected);
}

// Receivers take a frame after the last but one bit of EOF, its sender after the last. Flags of 6
// and 7 bits, 8 bits of delimiter, 3 of intermission: again from bit 133 on.
TEST(Play, TellsWhoHasAFrameThatItsSenderRepeats) {
    const Played result =
        played(one_frame, with_listeners({"b", "c"}), "frame 123 attempt 1 at eof.6 dominant b");
    EXPECT_EQ(
        result.events,
        "  0.000114  b  form error at eof.6, receiving, active flag, TEC 0, REC 1\n"
        "  0.000115  a  form error at eof.7, sending, active flag, TEC 8, REC 0\n"
        "  0.000115  c  overload flag, for a dominant bit at eof.7\n"
        "  0.000115  a  123#DEADBEEF00000000  received by c, not by b; not sent as a sees it\n"
        "  0.000247  a  123#DEADBEEF00000000  received by b, c\n");
    // b: 1, 8 for the dominant bit after its own flag, and 1 less for the good frame.
    EXPECT_THAT(result.table, HasSubstr("b     error active    0    8     0         1"));
    EXPECT_THAT(result.table, HasSubstr("c     error active    0    0     0         2"));
    EXPECT_THAT(result.table, HasSubstr(", 1 frame, 1 error frame\n"));
}

// 16 attempts of 43 bits (as in TellsOfErrors) make the sender error passive, at 665. After 8 bits
// of suspend transmission 16 attempts of 50 bits follow: at 716, and at 1466 the last one. b sees
// six recessive bits 5 bits later, and sends 6 dominant ones; 128 times 11 recessive bits after
// those the sender is back.
TEST(Play, TellsOfBusOffAndOfTheWayBack) {
    const std::string_view faults = "frame from a at data.1 flip a";
    PlayOptions options = with_listeners({"b"});
    const std::string bus_off =
        "  0.001466  a  bit error at data.1, sending, no flag, TEC 256, REC 0\n"
        "  0.001466  a  is bus off, TEC 256, REC 0\n"
        "  0.001466  a  123#DEADBEEF00000000  failed\n"
        "  0.001471  b  stuff error at the stuff bit after data.5, receiving, active flag, TEC 0, "
        "REC 32\n";
    EXPECT_THAT(events(one_frame, options, faults), testing::EndsWith(bus_off));
    options.automatic_recovery = true;
    EXPECT_THAT(events(one_frame, options, faults),
                testing::EndsWith(bus_off + "  0.002885  a  is error active, TEC 0, REC 0\n"));
}

TEST(Play, TellsOfFramesThatCannotBeHandedOver) {
    std::string text;
    for (int i = 0; i < 33; ++i) text += "(0.000000) a 123#DEADBEEF00000000\n";
    EXPECT_THAT(
        events(text, with_listeners({"b"})),
        testing::StartsWith("  0.000000  a  123#DEADBEEF00000000  refused, all mailboxes are full\n"
                            "  0.000115  a  123#DEADBEEF00000000  received by b\n"));
    const std::string late = std::string{one_frame} + "(0.002000) a 123#DEADBEEF00000000\n";
    EXPECT_THAT(events(late, with_listeners({"b"}), "frame from a at data.1 flip a"),
                testing::EndsWith("  0.002000  a  123#DEADBEEF00000000  refused, bus-off\n"));
}

TEST(Play, EndsASecondAfterTheLastLineWhileFaultsAreToCome) {
    EXPECT_THAT(played(one_frame, with_listeners({"b"}), "at 100us every 1s flip wire").table,
                testing::StartsWith("1000000 bit/s, 1.000000 s"));
}

TEST(Play, AdvisesAnotherNodeWhereOneIsAloneWithItsFrames) {
    std::string advice;
    const auto play_with = [&](PlayOptions options) {
        advice.clear();
        options.advise = [&](const std::string& sentence) { advice += sentence; };
        events("(0.000000) can0 123#\n(0.000000) can0 124#\n", options);
        return advice;
    };
    EXPECT_EQ(play_with({}),
              "nobody could acknowledge the frames of can0: name another node with --nodes");
    EXPECT_EQ(play_with(with_listeners({"b"})), "");
    PlayOptions options;
    options.length = 1ms;
    EXPECT_EQ(play_with(options), "");
}

TEST(Play, EndsWhenItIsToldTo) {
    PlayOptions options = with_listeners({"b"});
    options.length = 236us;
    EXPECT_THAT(played(one_frame, options).table,
                testing::StartsWith("1000000 bit/s, 0.000236 s, load 50.00 %"));
    options.length = 100us;
    EXPECT_EQ(events(one_frame, options), "  0.000100  a  123#DEADBEEF00000000  still waits\n");
}

TEST(Play, IsTheSameEachTime) {
    constexpr std::string_view text =
        "(0.000000) a 123#DEADBEEF00000000\n"
        "(0.000000) b 7FF#01\n"
        "(0.000000) c 1ABCDEF0#0102\n";
    constexpr std::string_view faults = "bit-error-rate 1e-3 each-node\nseed 5";
    const Played first = played(text, {}, faults);
    const Played second = played(text, {}, faults);
    EXPECT_GT(first.events.size(), 1000U);
    EXPECT_EQ(first.events, second.events);
    EXPECT_EQ(first.table, second.table);
}

TEST(Play, PassesOnWhatItsTracesTell) {
    PlayOptions options = with_listeners({"b"});
    std::vector<TimePoint> frames;
    std::vector<TimePoint> errors;
    options.trace = [&](const can::sim::CompletedFrame& frame) { frames.push_back(frame.time); };
    options.error_trace = [&](const can::sim::NodeError& error) { errors.push_back(error.time); };
    events(one_frame, options, "frame 123 attempt 1 at data.1 flip a");
    EXPECT_THAT(frames, ElementsAre(TimePoint{158us}));
    EXPECT_THAT(errors, ElementsAre(TimePoint{20us}, TimePoint{26us}));
}

}  // namespace
}  // namespace canorb::tools
