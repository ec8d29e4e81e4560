#include "orb/can/record/vcd_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/can/record/record_fixture.hpp"

namespace canorb::can {
namespace {

using sim::NodeIndex;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

using Levels = std::vector<std::uint8_t>;

class VcdWriterTest : public RecordTest {
  protected:
    void open(const VcdOptions& options = {}) {
        auto writer = VcdWriter::create(path(), options);
        ASSERT_TRUE(writer) << writer.error();
        writer_ = std::move(*writer);
    }

    /// A bit of 2000 ns that begins at `start`, in nanoseconds.
    void bit(int start, std::uint8_t bus, const Levels& driven, const Levels& seen) {
        writer_->bit(
            {TimePoint{Duration{start}}, TimePoint{Duration{start + 2000}}, bus, driven, seen});
    }

    /// The file without the room in it: neither empty lines nor blanks at the end of one.
    std::string text() {
        writer_->flush();
        std::istringstream lines{content()};
        std::string result;
        for (std::string line; std::getline(lines, line);) {
            line.erase(line.find_last_not_of(' ') + 1);
            if (!line.empty()) result += line + '\n';
        }
        return result;
    }

    std::unique_ptr<VcdWriter> writer_;
};

TEST_F(VcdWriterTest, HasTheBusAlone) {
    open();
    EXPECT_EQ(text(),
              "$version canorb $end\n"
              "$timescale 1 ns $end\n"
              "$scope module can $end\n"
              "$var wire 1 A bus $end\n"
              "$upscope $end\n"
              "$enddefinitions $end\n"
              "#0\n"
              "$dumpvars\n"
              "1A\n"
              "$end\n");
}

TEST_F(VcdWriterTest, WritesWhatChanges) {
    open({.comment = "500000 bit/s"});
    writer_->node_attached(NodeIndex{0}, "pump");
    writer_->node_attached(NodeIndex{1}, "valve");
    bit(10'000, 0, {0, 1}, {0, 0});  // SOF of the pump
    bit(12'000, 0, {0, 1}, {0, 0});
    bit(14'000, 1, {1, 1}, {1, 0});  // the valve sees the wrong level
    bit(16'000, 0, {1, 0}, {0, 0});
    bit(18'000, 1, {1, 1}, {1, 1});
    bit(20'000, 1, {1, 1}, {1, 1});
    EXPECT_EQ(text(),
              "$version canorb $end\n"
              "$comment 500000 bit/s $end\n"
              "$timescale 1 ns $end\n"
              "$scope module can $end\n"
              "$var wire 1 A bus $end\n"
              "$var wire 1 B pump_tx $end\n"
              "$var wire 1 C pump_rx $end\n"
              "$var wire 1 D valve_tx $end\n"
              "$var wire 1 E valve_rx $end\n"
              "$upscope $end\n"
              "$enddefinitions $end\n"
              "#0\n"
              "$dumpvars\n"
              "1A\n1B\n1C\n1D\n1E\n"
              "$end\n"
              "#10000\n0A\n0B\n0C\n0E\n"
              "#14000\n1A\n1B\n1C\n"
              "#16000\n0A\n0C\n0D\n"
              "#18000\n1A\n1C\n1D\n1E\n"
              "#22000\n");
    EXPECT_THAT(writer_->error(), IsEmpty());
}

TEST_F(VcdWriterTest, IsRecessiveWhereNoBitIs) {
    open();
    writer_->node_attached(NodeIndex{0}, "pump");
    bit(0, 0, {0}, {0});
    bit(9'000, 0, {0}, {0});
    EXPECT_THAT(text(), EndsWith("$end\n"
                                 "0A\n0B\n0C\n"
                                 "#2000\n1A\n1B\n1C\n"
                                 "#9000\n0A\n0B\n0C\n"
                                 "#11000\n"));
}

TEST_F(VcdWriterTest, CountsTimeFromItsStart) {
    open({.start = TimePoint{Duration{5'000}}});
    bit(7'000, 0, {}, {});
    EXPECT_THAT(text(), EndsWith("$end\n#2000\n0A\n#4000\n"));
}

TEST_F(VcdWriterTest, DeclaresANodeThatComesLater) {
    open();
    bit(0, 0, {}, {});
    writer_->flush();
    const std::size_t size_before = content().size();
    writer_->node_attached(NodeIndex{2}, "late");
    EXPECT_EQ(content().size(), size_before) << "only the header's room is written";
    bit(2'000, 0, {1, 1, 0}, {1, 1, 0});
    EXPECT_THAT(text(), AllOf(HasSubstr("$var wire 1 B late_tx $end\n"
                                        "$var wire 1 C late_rx $end\n"
                                        "$upscope $end\n"),
                              HasSubstr("$dumpvars\n1A\n1B\n1C\n$end\n"),
                              EndsWith("#2000\n0B\n0C\n#4000\n")));
}

TEST_F(VcdWriterTest, MakesNamesLegalAndUnique) {
    open();
    const std::string long_name(60, 'x');
    const char* const names[] = {"pump 3",     "pump-3",          "3pump",           "",
                                 "$end",       long_name.c_str(), long_name.c_str(), "pump_3_2",
                                 "tank\n.flow"};
    for (std::uint16_t i = 0; i < std::size(names); ++i) {
        writer_->node_attached(NodeIndex{i}, names[i]);
    }
    const std::string written = text();
    for (const char* const wanted : {" pump_3_tx ", " pump_3_2_tx ", " _3pump_tx ", " node_3_tx ",
                                     " _end_tx ", " pump_3_2_2_tx ", " tank__flow_rx "}) {
        EXPECT_THAT(written, HasSubstr(wanted));
    }
    EXPECT_THAT(written, HasSubstr(' ' + std::string(48, 'x') + "_tx "));
    EXPECT_THAT(written, HasSubstr(' ' + std::string(46, 'x') + "_2_tx "));
}

TEST_F(VcdWriterTest, ACommentDoesNotEndItself) {
    open({.comment = "a $end $var wire 1 A x $end"});
    EXPECT_THAT(text(), StartsWith("$version canorb $end\n"
                                   "$comment a _end _var wire 1 A x _end $end\n"
                                   "$timescale 1 ns $end\n"));
}

TEST_F(VcdWriterTest, ANodeThatComesBackHasItsWiresAgain) {
    open();
    writer_->node_attached(NodeIndex{0}, "other");
    writer_->node_attached(NodeIndex{1}, "pump");
    bit(0, 0, {1, 0}, {0, 0});
    writer_->node_detached(NodeIndex{1});
    bit(2'000, 1, {1}, {1});
    writer_->node_detached(NodeIndex{0});
    writer_->node_attached(NodeIndex{0}, "pump");  // with another number
    bit(4'000, 0, {0}, {0});
    EXPECT_THAT(text(), EndsWith("1A\n1B\n1C\n1D\n1E\n$end\n"
                                 "0A\n0C\n0D\n0E\n"
                                 "#2000\n1D\n1E\n1A\n1C\n"
                                 "#4000\n0A\n0D\n0E\n"
                                 "#6000\n"));
    EXPECT_THAT(text(), Not(HasSubstr("pump_2")));
}

TEST_F(VcdWriterTest, ABusMayTellOfItsNodesAgain) {
    open();
    writer_->node_attached(NodeIndex{0}, "pump");
    bit(0, 0, {0}, {0});
    writer_->node_attached(NodeIndex{0}, "pump");
    bit(2'000, 0, {0}, {0});
    EXPECT_THAT(text(), EndsWith("1A\n1B\n1C\n$end\n"
                                 "0A\n0B\n0C\n"
                                 "#2000\n1B\n1C\n0B\n0C\n"
                                 "#4000\n"));
    writer_->node_detached(NodeIndex{7});  // never heard of: nothing
}

TEST_F(VcdWriterTest, CountsNodesThatItHasNoRoomFor) {
    open({.room = 1});
    writer_->node_attached(NodeIndex{0}, "first");
    EXPECT_EQ(writer_->nodes_without_lines(), 0U);
    writer_->node_attached(NodeIndex{1}, "second");
    writer_->node_attached(NodeIndex{2}, "third");
    EXPECT_EQ(writer_->nodes_without_lines(), 2U);
    bit(0, 0, {1, 0, 1}, {0, 0, 0});
    writer_->node_detached(NodeIndex{1});
    EXPECT_THAT(text(), AllOf(EndsWith("$end\n0A\n0C\n#2000\n"), Not(HasSubstr("second"))));
    EXPECT_THAT(writer_->error(), IsEmpty());
}

TEST_F(VcdWriterTest, DeclaresMoreNodesThanTheAlphabetHasLetters) {
    open();
    for (std::uint16_t i = 0; i < 100; ++i) {
        writer_->node_attached(NodeIndex{i}, "n" + std::to_string(i));
    }
    // 1 + 2 * 25 wires have one letter; the 26th node's have the 52nd letter and the first pair.
    EXPECT_THAT(text(), AllOf(HasSubstr("$var wire 1 z n25_tx $end\n"
                                        "$var wire 1 AA n25_rx $end\n"
                                        "$var wire 1 AB n26_tx $end\n"),
                              HasSubstr("1z\n1AA\n1AB\n")));
}

TEST_F(VcdWriterTest, HasWholeLinesInTheFileAtAnyMoment) {
    open();
    writer_->node_attached(NodeIndex{0}, "pump");
    std::size_t size = content().size();
    int pieces = 0;
    for (int i = 0; i < 20'000; ++i) {
        const auto level = static_cast<std::uint8_t>(i % 2);
        bit(2'000 * i, level, {level}, {level});
        if (i % 1000 != 0) continue;
        const std::string now = content();
        EXPECT_EQ(now.back(), '\n');
        if (now.size() != size) ++pieces;
        size = now.size();
    }
    EXPECT_GT(pieces, 3);
    writer_.reset();
    EXPECT_THAT(content(), EndsWith("#40000000\n")) << "the rest, with its end";
}

TEST_F(VcdWriterTest, SaysWhyItCannotWrite) {
    const auto missing = VcdWriter::create(path() + "/missing/bus.vcd");
    ASSERT_FALSE(missing);
    EXPECT_THAT(missing.error(), AllOf(StartsWith("cannot write "), HasSubstr("No such file")));

    const auto full = VcdWriter::create("/dev/full");
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error(), "cannot write all of /dev/full: No space left on device");

    // Opened for reading, too, so that opening it for writing does not wait for a reader.
    ASSERT_EQ(::mkfifo(path().c_str(), 0600), 0);
    std::fstream reader{path(), std::ios::in | std::ios::out};
    const auto pipe = VcdWriter::create(path());
    ASSERT_FALSE(pipe);
    EXPECT_THAT(pipe.error(), HasSubstr("must be a file, not a pipe"));
}

TEST_F(VcdWriterTest, KeepsTheFirstError) {
    open();
    writer_->node_attached(NodeIndex{0}, "pump");
    rlimit old_limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old_limit), 0);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit = old_limit;
    limit.rlim_cur = 64 * 1024;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    for (int i = 0; i < 20'000; ++i) {
        const auto level = static_cast<std::uint8_t>(i % 2);
        bit(2'000 * i, level, {level}, {level});
    }
    writer_->node_attached(NodeIndex{1}, "late");
    writer_->flush();
    ::setrlimit(RLIMIT_FSIZE, &old_limit);
    std::signal(SIGXFSZ, old_handler);
    EXPECT_EQ(writer_->error(), "cannot write all of " + path() + ": File too large");
    EXPECT_LE(content().size(), 64U * 1024);
}

}  // namespace
}  // namespace canorb::can
