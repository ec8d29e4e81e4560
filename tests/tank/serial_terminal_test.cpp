#include "serial_terminal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <optional>
#include <string>

namespace tank {
namespace {

// The operator's terminal program.
class Station {
  public:
    explicit Station(const std::string& path) : line_(::open(path.c_str(), O_RDWR | O_NOCTTY)) {
        EXPECT_GE(line_.number(), 0) << path;
    }

    void type(std::string_view text) const {
        EXPECT_EQ(::write(line_.number(), text.data(), text.size()),
                  static_cast<ssize_t>(text.size()));
    }
    // All that comes until nothing more does.
    std::string read() const {
        std::string text;
        pollfd waiting{.fd = line_.number(), .events = POLLIN, .revents = 0};
        while (::poll(&waiting, 1, 50) > 0) {
            char buffer[4096];
            const ssize_t count = ::read(line_.number(), buffer, sizeof buffer);
            if (count <= 0) break;
            text.append(buffer, static_cast<std::size_t>(count));
        }
        return text;
    }
    int number() const { return line_.number(); }

  private:
    FileDescriptor line_;
};

std::string read_all(SerialTerminal& terminal, std::size_t count) {
    std::string text;
    // What was written is there at once or soon.
    for (int i = 0; i < 1000 && text.size() < count; ++i) {
        if (const auto character = terminal.read()) {
            text += *character;
        } else {
            ::usleep(1000);
        }
    }
    return text;
}

TEST(SerialTerminal, carries_characters_unchanged_both_ways) {
    SerialTerminal terminal;
    const Station station{terminal.path()};
    terminal.write("status\r\nmore\n\t\x04");
    EXPECT_EQ(station.read(), "status\r\nmore\n\t\x04");
    station.type("a\r\nb\x03");
    EXPECT_EQ(read_all(terminal, 5), "a\r\nb\x03");
    EXPECT_EQ(terminal.read(), std::nullopt);
    // No echo.
    EXPECT_EQ(station.read(), "");
}

TEST(SerialTerminal, is_115200_8n1) {
    const SerialTerminal terminal;
    const Station station{terminal.path()};
    termios settings{};
    ASSERT_EQ(::tcgetattr(station.number(), &settings), 0);
    EXPECT_EQ(::cfgetospeed(&settings), speed_t{B115200});
    EXPECT_EQ(settings.c_cflag & (CSIZE | PARENB | CSTOPB), tcflag_t{CS8});
    EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG), tcflag_t{0});
}

TEST(SerialTerminal, loses_what_nobody_hears) {
    SerialTerminal terminal;
    terminal.write("before anybody came\r\n");
    EXPECT_EQ(terminal.read(), std::nullopt);
    {
        const Station station{terminal.path()};
        terminal.write("first\r\n");
        EXPECT_EQ(station.read(), "first\r\n");
        station.type("c");
    }
    terminal.write("between\r\n");
    EXPECT_EQ(read_all(terminal, 1), "c");
    const Station station{terminal.path()};
    terminal.write("second\r\n");
    EXPECT_EQ(station.read(), "second\r\n");
    station.type("d");
    EXPECT_EQ(read_all(terminal, 1), "d");
}

TEST(SerialTerminal, does_not_wait_for_a_station_that_does_not_read) {
    SerialTerminal terminal;
    const Station station{terminal.path()};
    const std::string line(100, 'x');
    for (int i = 0; i < 10'000; ++i) terminal.write(line + "\r\n");
    // It reads after all: what was in the buffer, and then what comes from now on, on a new line.
    EXPECT_LT(station.read().size(), 100'000U);
    terminal.write("now\r\n");
    EXPECT_EQ(station.read(), "\r\nnow\r\n");
}

TEST(SerialTerminal, is_gone_with_its_object) {
    std::optional<SerialTerminal> terminal{std::in_place};
    const std::string path = terminal->path();
    terminal.reset();
    struct stat status{};
    EXPECT_NE(::stat(path.c_str(), &status), 0);
}

}  // namespace
}  // namespace tank
