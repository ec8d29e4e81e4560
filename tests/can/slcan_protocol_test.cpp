// The octets of doc/wire/slcan.md, written by hand.

#include "orb/can/link/slcan_protocol.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace canorb::can::slcan {
namespace {

using testing::ElementsAre;

Frame frame_of(std::uint32_t id, bool extended, bool remote, std::uint8_t length,
               std::vector<std::uint8_t> data = {}) {
    Frame frame;
    frame.id = id;
    frame.extended = extended;
    frame.remote = remote;
    frame.length = length;
    std::copy(data.begin(), data.end(), frame.data.begin());
    return frame;
}

struct Sample {
    std::string line;
    Frame frame;
};

const std::vector<Sample>& frames() {
    static const std::vector<Sample> samples{
        {"t0000", frame_of(0x000, false, false, 0)},
        {"t1234DEADBEEF", frame_of(0x123, false, false, 4, {0xDE, 0xAD, 0xBE, 0xEF})},
        {"t7FF80102030405060708", frame_of(0x7FF, false, false, 8, {1, 2, 3, 4, 5, 6, 7, 8})},
        {"T000001001FF", frame_of(0x100, true, false, 1, {0xFF})},
        {"T1FFFFFFF8A1B2C3D4E5F60718",
         frame_of(0x1FFFFFFF, true, false, 8, {0xA1, 0xB2, 0xC3, 0xD4, 0xE5, 0xF6, 0x07, 0x18})},
        {"r3210", frame_of(0x321, false, true, 0)},
        {"r3218", frame_of(0x321, false, true, 8)},
        {"R0ABCDEF13", frame_of(0x0ABCDEF1, true, true, 3)},
    };
    return samples;
}

/// A message as one word and what is in it.
std::string words(const Message& message) {
    if (const auto* frame = std::get_if<Frame>(&message)) {
        return "frame " + std::string{transmit_command(*frame).text()};
    }
    if (const auto* refused = std::get_if<Refused>(&message)) {
        return refused->cut_line ? "refused in a line" : "refused";
    }
    if (const auto* flags = std::get_if<Flags>(&message)) {
        return "flags " + std::to_string(flags->bits);
    }
    if (const auto* status = std::get_if<ErrorStatus>(&message)) {
        return std::string{name(status->state)} + " tec " + std::to_string(status->tec) + " rec " +
               std::to_string(status->rec);
    }
    if (std::holds_alternative<Done>(message)) return "done";
    if (std::holds_alternative<Version>(message)) return "version";
    if (std::holds_alternative<Ignored>(message)) return "ignored";
    return "malformed";
}

std::vector<std::string> received(Receiver& receiver, std::string_view octets) {
    std::vector<std::string> messages;
    for (const char octet : octets) {
        if (const auto message = receiver.add(octet)) messages.push_back(words(*message));
    }
    return messages;
}

TEST(SlcanCommands, Golden) {
    EXPECT_EQ(flush_command, "\r\r\rC\r");
    EXPECT_EQ(version_command, "V\r");
    EXPECT_EQ(auto_poll_command, "X1\r");
    EXPECT_EQ(open_command, "O\r");
    EXPECT_EQ(listen_command, "L\r");
    EXPECT_EQ(flags_command, "F\r");
    EXPECT_EQ(close_command, "C\r");
    const std::vector<std::pair<std::uint32_t, std::string>> rates{
        {10'000, "S0\r"},  {20'000, "S1\r"},  {50'000, "S2\r"},
        {100'000, "S3\r"}, {125'000, "S4\r"}, {250'000, "S5\r"},
        {500'000, "S6\r"}, {800'000, "S7\r"}, {1'000'000, "S8\r"}};
    for (const auto& [bitrate, text] : rates) EXPECT_EQ(bitrate_command(bitrate).text(), text);
    EXPECT_EQ(bitrate_digit(83'333), std::nullopt);
}

TEST(SlcanCommands, GoldenFrames) {
    for (const Sample& sample : frames()) {
        EXPECT_EQ(transmit_command(sample.frame).text(), sample.line + '\r');
    }
}

TEST(SlcanLines, Frames) {
    for (const Sample& sample : frames()) {
        for (const char* time_stamp : {"", "0000", "EA5F", "ffff"}) {
            const Message message = parse_line(sample.line + time_stamp);
            ASSERT_TRUE(std::holds_alternative<Frame>(message)) << sample.line << time_stamp;
            EXPECT_EQ(std::get<Frame>(message), sample.frame) << sample.line << time_stamp;
        }
    }
    EXPECT_EQ(words(parse_line("t7ff2ab0c")), "frame t7FF2AB0C\r");
}

TEST(SlcanLines, AnswersAndStates) {
    const std::vector<std::pair<std::string, std::string>> lines{
        {"", "done"},
        {"z", "done"},
        {"Z", "done"},
        {"V1013", "version"},
        {"V2.2 of an adapter with much to say", "version"},
        {"F00", "flags 0"},
        {"F29", "flags 41"},
        {"Fa0", "flags 160"},
        {"sa057033", "error active tec 33 rec 57"},
        {"sw096100", "error active tec 100 rec 96"},
        {"sp000128", "error passive tec 128 rec 0"},
        {"sb256256", "bus off tec 256 rec 256"},
    };
    for (const auto& [line, meaning] : lines) EXPECT_EQ(words(parse_line(line)), meaning) << line;
}

TEST(SlcanLines, ThatSayNothingHere) {
    for (const char* line : {"C",        "O",      "L",        "S6",        "X1",  "Z0",   "Z1",
                             "F",        "V",      "N",        "N4242",     "Fx0", "F000", "s031C",
                             "sx000000", "sa0570", "sa0a0000", "sa0000000", "e1a", "e3bcO"}) {
        EXPECT_EQ(words(parse_line(line)), "ignored") << line;
    }
}

TEST(SlcanLines, MalformedOnes) {
    for (const char* line : {
             "t",        "t12",      "t123",       "t1239",        "t123A",      "t1231",  "t1231A",
             "t1231AG",  "t1231AB0", "t1231AB000", "t1231AB00000", "t8000",      "tG000",  "t12 0",
             "t-120",    "T1230",    "T200000000", "TFFFFFFFF0",   "T000001009", "r12311", "r1239",
             "R0000010", "q1230",    "1230",       " t1230",       "\nt1230",    "\x80",
         }) {
        EXPECT_EQ(words(parse_line(line)), "malformed") << line;
    }
    EXPECT_EQ(words(parse_line({"t12\0"
                                "0",
                                5})),
              "malformed");
}

TEST(SlcanReceiver, TakesLinesHoweverTheyAreCut) {
    const std::string octets = "t1231AB\rz\r\rF20\rR0ABCDEF13\rV1013\r";
    const auto expected =
        ElementsAre("frame t1231AB\r", "done", "done", "flags 32", "frame R0ABCDEF13\r", "version");
    Receiver receiver;
    EXPECT_THAT(received(receiver, octets), expected);
    for (std::size_t cut = 0; cut <= octets.size(); ++cut) {
        auto messages = received(receiver, std::string_view{octets}.substr(0, cut));
        const auto rest = received(receiver, std::string_view{octets}.substr(cut));
        messages.insert(messages.end(), rest.begin(), rest.end());
        EXPECT_THAT(messages, expected) << cut;
    }
}

TEST(SlcanReceiver, ABellIsARefusalAndEndsALine) {
    Receiver receiver;
    EXPECT_THAT(received(receiver, "\a\at12\az\r"),
                ElementsAre("refused", "refused", "refused in a line", "done"));
}

TEST(SlcanReceiver, DropsOverlongLines) {
    Receiver receiver;
    const std::string line(64, 'V');
    EXPECT_THAT(received(receiver, line + "\r"), ElementsAre("version"));
    EXPECT_THAT(received(receiver, line + "V\rt1230\r"), ElementsAre("malformed", "frame t1230\r"));
    EXPECT_THAT(received(receiver, std::string(1'000'000, 'x') + "\rt1230\r"),
                ElementsAre("malformed", "frame t1230\r"));
    EXPECT_THAT(received(receiver, line + line + "\a"), ElementsAre("refused in a line"));
}

TEST(SlcanReceiver, ForgetsAHalfLine) {
    Receiver receiver;
    EXPECT_THAT(received(receiver, "t123"), ElementsAre());
    receiver.reset();
    EXPECT_THAT(received(receiver, "t4560\r"), ElementsAre("frame t4560\r"));
}

}  // namespace
}  // namespace canorb::can::slcan
