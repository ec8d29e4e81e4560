// canorb-bus as people run it: a process of its own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "orb/can/candump.hpp"
#include "orb/can/link/link.hpp"
#include "tests/can/temporary_directory.hpp"

namespace canorb::can {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int patience_ms = 20'000;
constexpr std::array<Filter, 1> accept_all{Filter{}};

/// A child process whose output and errors the test reads.
class Process {
  public:
    /// Runs `body` in the child, which ends with its result.
    explicit Process(const std::function<int()>& body) {
        std::array<int, 2> ends{};
        if (::pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
        pid_ = ::fork();
        if (pid_ == 0) {
            ::dup2(ends[1], STDOUT_FILENO);
            ::dup2(ends[1], STDERR_FILENO);
            ::close(ends[0]);
            ::_exit(body());
        }
        ::close(ends[1]);
        output_ = ends[0];
    }

    static Process program(std::vector<std::string> arguments) {
        return Process{[&] {
            std::vector<char*> argv;
            for (std::string& argument : arguments) argv.push_back(argument.data());
            argv.push_back(nullptr);
            ::execv(argv[0], argv.data());
            return 127;
        }};
    }

    ~Process() {
        if (pid_ > 0) {
            ::kill(pid_, SIGKILL);
            ::waitpid(pid_, nullptr, 0);
        }
        ::close(output_);
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    void send_signal(int signal) const { ::kill(pid_, signal); }

    /// Reads until the output has this text in it.
    bool says(const std::string& wanted) {
        while (text_.find(wanted) == std::string::npos) {
            if (!read_more()) return false;
        }
        return true;
    }

    /// Reads to the end and returns the exit code, or minus the signal that ended it.
    int wait() {
        while (read_more()) {
        }
        int status = 0;
        ::waitpid(pid_, &status, 0);
        pid_ = 0;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

    const std::string& text() const { return text_; }

  private:
    bool read_more() {
        pollfd descriptor{output_, POLLIN, 0};
        if (::poll(&descriptor, 1, patience_ms) != 1) return false;
        std::array<char, 4096> buffer;
        const auto got = ::read(output_, buffer.data(), buffer.size());
        if (got <= 0) return false;
        text_.append(buffer.data(), static_cast<std::size_t>(got));
        return true;
    }

    pid_t pid_ = 0;
    int output_ = -1;
    std::string text_;
};

class CanorbBus : public testing::Test {
  protected:
    std::string path() const { return directory_.path() + "/bus"; }
    std::string address() const { return "sim:" + path(); }

    Process run(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), CANORB_BUS);
        return Process::program(std::move(arguments));
    }

    std::unique_ptr<Controller> attach() const {
        auto link = open_link(address());
        EXPECT_TRUE(link) << link.error();
        if (!link) return nullptr;
        auto controller = (*link)->attach("test");
        EXPECT_TRUE(controller) << controller.error();
        if (!controller) return nullptr;
        EXPECT_TRUE((*controller)->set_filters(accept_all));
        return std::move(*controller);
    }

    static std::optional<Received> next_received(Controller& controller) {
        pollfd descriptor{controller.event_fd(), POLLIN, 0};
        while (::poll(&descriptor, 1, patience_ms) == 1) {
            while (const auto event = controller.poll()) {
                if (const auto* received = std::get_if<Received>(&*event)) return *received;
            }
        }
        return std::nullopt;
    }

    void expect_working_bus(std::uint32_t id = 0x123) const {
        const auto sender = attach();
        const auto receiver = attach();
        ASSERT_TRUE(sender && receiver);
        const std::array<std::uint8_t, 2> data{0xCA, 0xFE};
        const SendResult sent = sender->send(Frame::standard(id, data));
        ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sent));
        while (const auto received = next_received(*receiver)) {
            if (received->frame == Frame::standard(id, data)) return;
        }
        ADD_FAILURE() << "the frame did not arrive";
    }

    test::TemporaryDirectory directory_;
};

TEST_F(CanorbBus, HasHelpAndVersion) {
    Process help = run({"--help"});
    EXPECT_EQ(help.wait(), 0);
    for (const char* option : {"--listen", "--bitrate", "--unpaced", "--log", "--quiet"}) {
        EXPECT_THAT(help.text(), HasSubstr(option));
    }
    Process version = run({"--version"});
    EXPECT_EQ(version.wait(), 0);
    EXPECT_THAT(version.text(), StartsWith("canorb-bus "));
}

TEST_F(CanorbBus, EndsWithASignalAndRemovesItsSocket) {
    for (const int signal : {SIGINT, SIGTERM}) {
        Process bus = run({"--listen", address()});
        ASSERT_TRUE(bus.says("500000 bit/s\n"));
        expect_working_bus();
        bus.send_signal(signal);
        EXPECT_EQ(bus.wait(), 0);
        EXPECT_FALSE(std::filesystem::exists(path()));
    }
}

TEST_F(CanorbBus, LogsFramesAsCandumpDoes) {
    const std::string log_path = directory_.path() + "/frames.log";
    Process bus = run({"--listen", address(), "--log", log_path});
    ASSERT_TRUE(bus.says("bit/s\n"));
    expect_working_bus();
    // The line is there as soon as the receiver has the frame.
    std::ifstream file{log_path};
    std::string text;
    ASSERT_TRUE(std::getline(file, text));
    EXPECT_EQ(file.peek(), std::ifstream::traits_type::eof());
    const auto line = parse_candump(text);
    ASSERT_TRUE(line) << text;
    EXPECT_THAT(text, testing::EndsWith(") can0 123#CAFE"));
    const auto unix_time = std::chrono::system_clock::now().time_since_epoch();
    EXPECT_LT(std::chrono::abs(unix_time - line->time.time_since_epoch()), 1h);
}

TEST_F(CanorbBus, RunsUnpaced) {
    Process bus = run({"--listen", address(), "--bitrate", "10000", "--unpaced"});
    ASSERT_TRUE(bus.says("10000 bit/s, unpaced\n"));
    const auto sender = attach();
    const auto receiver = attach();
    const TimePoint before = monotonic_now();
    Duration bus_time{};
    std::optional<TimePoint> first;
    constexpr int frames = 1000;  // 6 ms each: 6 s of bus time
    for (int i = 0; i < frames; ++i) {
        while (std::holds_alternative<SendError>(sender->send(Frame::standard(0x123, {})))) {
            while (sender->poll()) {
            }
        }
        const auto received = next_received(*receiver);
        ASSERT_TRUE(received);
        if (!first) first = received->time;
        bus_time = received->time - *first;
    }
    EXPECT_GT(bus_time, 4s);
    EXPECT_LT(monotonic_now() - before, bus_time);
}

TEST_F(CanorbBus, QuietSaysNothing) {
    Process bus = run({"--listen", address(), "--quiet"});
    // Without a word from it, its socket is the only sign.
    while (!open_link(address())) std::this_thread::yield();
    expect_working_bus();
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
    EXPECT_EQ(bus.text(), "");
}

TEST_F(CanorbBus, RefusesASecondDaemonAtTheSamePath) {
    Process first = run({"--listen", address()});
    ASSERT_TRUE(first.says("bit/s\n"));
    Process second = run({"--listen", address()});
    EXPECT_EQ(second.wait(), 1);
    EXPECT_EQ(second.text(), "canorb-bus: a bus is already running at " + address() + "\n");
    expect_working_bus();
}

TEST_F(CanorbBus, ReplacesTheSocketOfAKilledDaemon) {
    Process first = run({"--listen", address()});
    ASSERT_TRUE(first.says("bit/s\n"));
    first.send_signal(SIGKILL);
    EXPECT_EQ(first.wait(), -SIGKILL);
    EXPECT_TRUE(std::filesystem::exists(path()));
    Process second = run({"--listen", address()});
    ASSERT_TRUE(second.says("bit/s\n"));
    expect_working_bus();
}

struct BadCommand {
    std::vector<std::string> arguments;
    std::string says;
};

TEST_F(CanorbBus, SaysWhatIsWrong) {
    for (const BadCommand& bad : {
             BadCommand{{"--listen", "sim:/missing/directory/bus"}, "directory does not exist"},
             BadCommand{{"--listen", "local:x"}, "--listen takes sim:PATH"},
             BadCommand{{"--listen", "/tmp/x"}, "is not a bus address"},
             BadCommand{{"--listen", "sim:"}, "needs the path"},
             BadCommand{{"--listen", address(), "--bitrate", "4999"}, "is not a bit rate"},
             BadCommand{{"--listen", address(), "--bitrate", "fast"}, "is not a bit rate"},
             BadCommand{{"--listen", address(), "--log", "/missing/directory/x"}, "cannot write"},
             BadCommand{{"--lisen", address()}, "--lisen"},
         }) {
        Process bus = run(bad.arguments);
        EXPECT_GT(bus.wait(), 0) << bad.says;
        EXPECT_THAT(bus.text(), HasSubstr(bad.says));
    }
}

TEST_F(CanorbBus, OutlivesAClientThatIsKilledWhileItFloods) {
    Process bus = run({"--listen", address()});
    ASSERT_TRUE(bus.says("bit/s\n"));
    const auto witness = attach();
    for (int i = 0; i < 3; ++i) {
        Process flooder{[&] {
            const auto link = open_link(address());
            if (!link) return 1;
            const auto controller = (*link)->attach("flooder");
            if (!controller) return 1;
            while (true) {
                static_cast<void>((*controller)->send(Frame::standard(0x001, {})));
                while ((*controller)->poll()) {
                }
            }
        }};
        for (int frames = 0; frames < 20; ++frames) ASSERT_TRUE(next_received(*witness));
        flooder.send_signal(SIGKILL);
        EXPECT_EQ(flooder.wait(), -SIGKILL);
        ASSERT_TRUE(bus.says("client \"flooder\""));
        expect_working_bus();
    }
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
    EXPECT_THAT(bus.text(), HasSubstr("disconnected"));
}

}  // namespace
}  // namespace canorb::can
