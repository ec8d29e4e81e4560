#include "orb/can/candump.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace canorb::can {
namespace {

using namespace std::chrono_literals;
using test::octets;

Frame standard(std::uint32_t id, std::string_view data) {
    return Frame::standard(id, octets(data));
}

const TimePoint some_time = TimePoint{} + 1436509053s + 650713us;

TEST(FormatCandump, WritesWhatCandumpWrites) {
    EXPECT_EQ(format_candump(some_time, "can0", standard(0x123, "DEADBEEF")),
              "(1436509053.650713) can0 123#DEADBEEF");
    EXPECT_EQ(format_candump(some_time, "vcan12", standard(0x001, "")),
              "(1436509053.650713) vcan12 001#");
}

TEST(FormatCandump, FillsTheTimeWithZeros) {
    EXPECT_EQ(format_candump(TimePoint{} + 1234us + 999ns, "can0", standard(0x7EF, "00")),
              "(0000000000.001234) can0 7EF#00");
    EXPECT_EQ(format_candump(TimePoint{} - 1s, "can0", standard(0x7EF, "00")),
              "(0000000000.000000) can0 7EF#00");
}

TEST(FormatCandump, ExtendedRemoteErrorAndFd) {
    Frame frame = standard(0, "01");
    frame.id = 0x12ABC;
    frame.extended = true;
    EXPECT_EQ(format_candump(some_time, "can0", frame), "(1436509053.650713) can0 00012ABC#01");
    Frame remote;
    remote.id = 0x123;
    remote.remote = true;
    EXPECT_EQ(format_candump(some_time, "can0", remote), "(1436509053.650713) can0 123#R");
    remote.length = 5;
    EXPECT_EQ(format_candump(some_time, "can0", remote), "(1436509053.650713) can0 123#R5");
    Frame error = standard(0, "0004000000000000");
    error.id = 0x4;
    error.error = true;
    EXPECT_EQ(format_candump(some_time, "can0", error),
              "(1436509053.650713) can0 20000004#0004000000000000");
    EXPECT_EQ(format_candump(some_time, "can0", standard(0x123, "000102030405060708090A0B")),
              "(1436509053.650713) can0 123##0000102030405060708090A0B");
}

TEST(ParseCandump, ReadsALine) {
    const auto line = parse_candump("(1436509053.650713) can0 123#DEADBEEF");
    ASSERT_TRUE(line);
    EXPECT_EQ(line->time, some_time);
    EXPECT_EQ(line->interface, "can0");
    EXPECT_EQ(line->frame, standard(0x123, "DEADBEEF"));
}

TEST(ParseCandump, ReadsEveryKindOfFrame) {
    const auto frame_of = [](const std::string& text) {
        const auto line = parse_candump("(0.000000) can0 " + text);
        EXPECT_TRUE(line) << text << ": " << name(line.error());
        return line ? line->frame : Frame{};
    };
    EXPECT_EQ(frame_of("7ff#"), standard(0x7FF, ""));
    EXPECT_EQ(frame_of("123#de.ad"), standard(0x123, "DEAD"));
    EXPECT_EQ(frame_of("123#0102030405060708_F"), standard(0x123, "0102030405060708"));
    EXPECT_EQ(frame_of("123##5DEADBEEF").fd, true);
    EXPECT_EQ(frame_of("123##5DEADBEEF").length, 4);
    EXPECT_EQ(frame_of("123#DEAD R"), standard(0x123, "DEAD"));
    EXPECT_TRUE(frame_of("00000123#").extended);
    EXPECT_EQ(frame_of("00000123#").id, 0x123U);
    EXPECT_TRUE(frame_of("123#R").remote);
    EXPECT_EQ(frame_of("123#R8_9").length, 8);
    EXPECT_TRUE(frame_of("20000004#0004000000000000").error);
    EXPECT_EQ(frame_of("20000004#0004000000000000").id, 4U);
}

TEST(ParseCandump, ReadsWhatIsWritten) {
    for (const std::string_view text :
         {"(1436509053.650713) can0 123#DEADBEEF", "(0000000000.000001) x 1FFFFFFF#",
          "(9223372035.999999) can0 123#R4", "(0000000001.000000) can0 20000004#0004",
          "(0000000001.000000) can0 123##0000102030405060708090A0B"}) {
        const auto line = parse_candump(text);
        ASSERT_TRUE(line) << text;
        EXPECT_EQ(format_candump(line->time, line->interface, line->frame), text);
    }
}

struct BadLine {
    std::string_view text;
    CandumpError error;
};

TEST(ParseCandump, SaysWhatIsWrong) {
    for (const BadLine& bad : {
             BadLine{"", CandumpError::time},
             BadLine{"can0 123#", CandumpError::time},
             BadLine{"(1.000000 can0 123#", CandumpError::time},
             BadLine{"(1) can0 123#", CandumpError::time},
             BadLine{"(1.0) can0 123#", CandumpError::time},
             BadLine{"(.000000) can0 123#", CandumpError::time},
             BadLine{"(-1.000000) can0 123#", CandumpError::time},
             BadLine{"(99999999999.000000) can0 123#", CandumpError::time},
             BadLine{"(9999999999.000000) can0 123#", CandumpError::time},
             BadLine{"(1.00000x) can0 123#", CandumpError::time},
             BadLine{"(1.000000)can0 123#", CandumpError::time},
             BadLine{"(1.000000) 123#", CandumpError::interface},
             BadLine{"(1.000000)  123#", CandumpError::interface},
             BadLine{"(1.000000) abcdefghijklmnop 123#", CandumpError::interface},
             BadLine{"(1.000000) can0 123", CandumpError::identifier},
             BadLine{"(1.000000) can0 #", CandumpError::identifier},
             BadLine{"(1.000000) can0 800#", CandumpError::identifier},
             BadLine{"(1.000000) can0 12#", CandumpError::identifier},
             BadLine{"(1.000000) can0 12g#", CandumpError::identifier},
             BadLine{"(1.000000) can0 FFFFFFFF#", CandumpError::identifier},
             BadLine{"(1.000000) can0 123#1", CandumpError::data},
             BadLine{"(1.000000) can0 123#0g", CandumpError::data},
             BadLine{"(1.000000) can0 123#0102030405060708"
                     "09",
                     CandumpError::data},
             BadLine{"(1.000000) can0 123#01.", CandumpError::data},
             BadLine{"(1.000000) can0 123#01_9", CandumpError::data},
             BadLine{"(1.000000) can0 123#R9", CandumpError::data},
             BadLine{"(1.000000) can0 123#R01", CandumpError::data},
             BadLine{"(1.000000) can0 123##", CandumpError::data},
             BadLine{"(1.000000) can0 123##g", CandumpError::data},
             BadLine{"(1.000000) can0 123##0000102030405060708", CandumpError::data},
             BadLine{"(1.000000) can0 20000004#R", CandumpError::data},
             BadLine{"(1.000000) can0 123#01 X", CandumpError::trailing},
             BadLine{"(1.000000) can0 123#01\r", CandumpError::data},
         }) {
        const auto line = parse_candump(bad.text);
        ASSERT_FALSE(line) << bad.text;
        EXPECT_EQ(line.error(), bad.error) << bad.text << ": " << name(line.error());
    }
}

}  // namespace
}  // namespace canorb::can
