#include "line_reader.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <string>
#include <string_view>
#include <vector>

namespace plant {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class LineReaderTest : public testing::Test {
  protected:
    LineReaderTest() { EXPECT_EQ(::pipe2(pipe_, O_CLOEXEC), 0); }
    ~LineReaderTest() override {
        ::close(pipe_[0]);
        close_input();
    }
    void write(std::string_view text) const {
        EXPECT_EQ(::write(pipe_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    }
    void close_input() {
        if (pipe_[1] >= 0) ::close(pipe_[1]);
        pipe_[1] = -1;
    }
    static std::vector<std::string> lines(LineReader& reader) {
        std::vector<std::string> lines;
        reader.read([&](std::string_view line) { lines.emplace_back(line); });
        return lines;
    }

    int pipe_[2] = {-1, -1};
};

TEST_F(LineReaderTest, gives_whole_lines_and_never_waits) {
    LineReader reader{pipe_[0]};
    EXPECT_THAT(lines(reader), IsEmpty());
    write("one\ntw");
    EXPECT_THAT(lines(reader), ElementsAre("one"));
    write("o\n\nthree");
    EXPECT_THAT(lines(reader), ElementsAre("two", ""));
    EXPECT_FALSE(reader.at_end());
    close_input();
    EXPECT_THAT(lines(reader), IsEmpty());
    EXPECT_TRUE(reader.at_end());
}

TEST_F(LineReaderTest, does_not_grow_for_a_line_without_end) {
    LineReader reader{pipe_[0]};
    for (int i = 0; i < 100; ++i) {
        write(std::string(1000, 'x'));
        EXPECT_THAT(lines(reader), IsEmpty());
    }
    write("\nafter\n");
    EXPECT_EQ(lines(reader).back(), "after");
}

TEST_F(LineReaderTest, follows_a_file_that_grows) {
    std::string path = testing::TempDir() + "canorb-lines-XXXXXX";
    const int file = ::mkstemp(path.data());
    ASSERT_GE(file, 0);
    const int reading = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    LineReader reader{reading, LineReader::End::may_grow};
    EXPECT_THAT(lines(reader), IsEmpty());
    EXPECT_FALSE(reader.at_end());
    EXPECT_EQ(::write(file, "later\n", 6), 6);
    EXPECT_THAT(lines(reader), ElementsAre("later"));
    ::close(reading);
    ::close(file);
    ::unlink(path.c_str());
}

}  // namespace
}  // namespace plant
