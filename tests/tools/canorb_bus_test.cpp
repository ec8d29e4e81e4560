// canorb-bus as people run it: a process of its own.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
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
#include "orb/can/link/sim_socket.hpp"
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

    /// From now on a write to its output would block, but for what another one reads.
    void fill_its_output() const {
        const std::string end = "/proc/" + std::to_string(pid_) + "/fd/1";
        const int output = ::open(end.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
        ASSERT_GE(output, 0);
        while (::write(output, "x", 1) == 1) continue;
        ::close(output);
    }

    /// The exit code, while nobody reads.
    int wait_unread() {
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

    std::unique_ptr<Controller> attach() const { return attach_as("test"); }
    std::unique_ptr<Controller> attach_as(std::string_view name) const {
        auto link = open_link(address());
        EXPECT_TRUE(link) << link.error();
        if (!link) return nullptr;
        auto controller = (*link)->attach(name);
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

    std::string file(const std::string& name, const std::string& text) const {
        const std::string file_path = directory_.path() + '/' + name;
        std::ofstream{file_path} << text;
        return file_path;
    }
    static std::string content(const std::string& file_path) {
        std::ifstream stream{file_path, std::ios::binary};
        return {std::istreambuf_iterator<char>{stream}, {}};
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
    for (const char* option :
         {"--listen", "--bitrate", "--unpaced", "--recover-automatically", "--fault", "--log",
          "--vcd", "--pcapng", "--status", "--quiet", "--play", "--nodes", "--for"}) {
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
    int exit_code = 2;
};

TEST_F(CanorbBus, SaysWhatIsWrong) {
    for (const BadCommand& bad : {
             BadCommand{{"--listen", "sim:/missing/directory/bus"}, "directory does not exist", 1},
             BadCommand{{"--listen", "local:x"}, "--listen takes sim:PATH"},
             BadCommand{{"--listen", "/tmp/x"}, "is not a bus address"},
             BadCommand{{"--listen", "sim:"}, "needs the path"},
             BadCommand{{"--listen", address(), "--bitrate", "4999"}, "is not a bit rate"},
             BadCommand{{"--listen", address(), "--bitrate", "fast"}, "is not a bit rate"},
             BadCommand{
                 {"--listen", address(), "--log", "/missing/directory/x"}, "cannot write", 1},
             BadCommand{
                 {"--listen", address(), "--vcd", "/missing/directory/x"}, "cannot write", 1},
             BadCommand{
                 {"--listen", address(), "--pcapng", "/missing/directory/x"}, "cannot write", 1},
             BadCommand{
                 {"--listen", address(), "--fault", "/missing/x"}, "cannot read /missing/x: No", 1},
             BadCommand{
                 {"--listen", address(), "--fault", "/tmp"}, "cannot read /tmp: Is a dir", 1},
             BadCommand{{"--lisen", address()}, "--lisen"},
             BadCommand{{"--listen", "socketcan:x"}, "--listen takes sim:PATH"},
             BadCommand{{"--bitrate", "1"}, "is not a bit rate"},
             BadCommand{{"--listen", address(), "--log", file("x", ""), "--vcd", file("x", "")},
                        "only one recording can go to"},
             BadCommand{{"--listen", address(), "--vcd", file("x", ""), "--pcapng",
                         directory_.path() + "/./x"},
                        "only one recording can go to"},
             BadCommand{{"--play", "/missing/x"}, "cannot read /missing/x", 1},
             BadCommand{{"--play", "/dev/null", "--for", "20"}, "--for takes a time such as 20ms"},
             BadCommand{{"--play", "/dev/null", "--for", "99999999s"}, "at most 1000000s, not"},
             BadCommand{{"--play", "/dev/null", "--nodes", ""}, "none is empty"},
             BadCommand{{"--play", "/dev/null", "--nodes", "a,b,a"}, "--nodes has a twice"},
             BadCommand{{"--play", "/dev/null", "--listen", address()}, "--listen"},
             BadCommand{{"--nodes", "a"}, "--play"},
         }) {
        Process bus = run(bad.arguments);
        EXPECT_EQ(bus.wait(), bad.exit_code) << bad.says;
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

TEST_F(CanorbBus, PrintsTheStatusOfTheBusThatRuns) {
    Process bus = run({"--listen", address(), "--bitrate", "5000"});
    ASSERT_TRUE(bus.says("bit/s\n"));
    const auto controller = attach();
    Process status = run({"--listen", address(), "--status"});
    EXPECT_EQ(status.wait(), 0);
    EXPECT_THAT(status.text(), StartsWith("5000 bit/s, "));
    EXPECT_THAT(status.text(), HasSubstr(", load 0.00 %, 0 frames, 0 error frames\n"));
    EXPECT_THAT(status.text(), HasSubstr("\ntest  error active    0    0     0         0 "));
    // What else is asked for needs a bus of its own.
    Process second = run({"--listen", address(), "--status", "--unpaced"});
    EXPECT_EQ(second.wait(), 1);
    EXPECT_THAT(second.text(), HasSubstr("already running"));
}

TEST_F(CanorbBus, PrintsItsOwnStatusEachSecondAndAtTheEnd) {
    Process bus = run({"--listen", address(), "--status"});
    ASSERT_TRUE(bus.says("bit/s\n"));
    const auto controller = attach();
    EXPECT_TRUE(bus.says("500000 bit/s, 1.0")) << bus.text();
    EXPECT_TRUE(bus.says("\ntest  error active"));
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
    EXPECT_THAT(bus.text(), testing::ContainsRegex("500000 bit/s, .*500000 bit/s, "));
}

TEST_F(CanorbBus, SaysWhyABusDoesNotTellItsStatus) {
    const auto silent = listen_at(path());  // which never answers
    ASSERT_TRUE(silent);
    std::thread hang_up{[&] {
        pollfd descriptor{silent->get(), POLLIN, 0};
        ::poll(&descriptor, 1, patience_ms);
        ::close(::accept(silent->get(), nullptr, nullptr));
    }};
    Process status = run({"--listen", address(), "--status"});
    EXPECT_EQ(status.wait(), 1);
    hang_up.join();
    EXPECT_EQ(status.text(), "canorb-bus: the bus at " + address() + " closed the connection\n");
}

TEST_F(CanorbBus, SaysOnceASecondThatItHasNoDescriptorForAClient) {
    Process bus = Process::program(
        {"/bin/bash", "-c", "ulimit -n 16; exec " CANORB_BUS " --listen " + address()});
    ASSERT_TRUE(bus.says("bit/s\n")) << bus.text();
    const auto controller = attach();
    std::vector<Descriptor> connections;
    for (int i = 0; i < 20; ++i) {
        auto connection = connect_to_bus(path());
        ASSERT_TRUE(connection);
        connections.push_back(std::move(*connection));
    }
    ASSERT_TRUE(bus.says("cannot accept a client: Too many open files\n"));
    // Each of these is a turn of the daemon.
    const TimePoint begin = monotonic_now();
    for (int i = 0; i < 200; ++i) ASSERT_TRUE(controller->set_listen_only(i % 2 == 0));
    connections.clear();
    expect_working_bus();
    const auto seconds = static_cast<int>((monotonic_now() - begin) / 1s);
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
    int said = 0;
    for (auto at = bus.text().find("cannot accept"); at != std::string::npos;
         at = bus.text().find("cannot accept", at + 1)) {
        ++said;
    }
    EXPECT_LE(said, seconds + 2);
}

TEST_F(CanorbBus, ServesOnWhenNobodyReadsItsStatus) {
    Process bus = run({"--listen", address(), "--status"});
    ASSERT_TRUE(bus.says("bit/s\n"));
    bus.fill_its_output();
    const auto controller = attach();
    // Its own report each second, and the messages about clients, have nowhere to go.
    const TimePoint end = monotonic_now() + 2500ms;
    while (monotonic_now() < end) expect_working_bus();
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait_unread(), 0);
}

TEST_F(CanorbBus, SaysThatAVcdHasNoRoomForMoreNames) {
    const std::string vcd = directory_.path() + "/bits.vcd";
    Process bus = run({"--listen", address(), "--vcd", vcd, "--quiet"});
    while (!open_link(address())) std::this_thread::yield();
    for (int i = 0; i < 130; ++i) attach_as("node-" + std::to_string(i));
    EXPECT_TRUE(bus.says("the VCD has lines for 128 different names of nodes"));
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
    EXPECT_EQ(bus.text().find("the VCD"), bus.text().rfind("the VCD"));
}

TEST_F(CanorbBus, RecordsWhatHappens) {
    const std::string log = directory_.path() + "/frames.log";
    const std::string vcd = directory_.path() + "/bits.vcd";
    const std::string pcapng = directory_.path() + "/frames.pcapng";
    Process bus = run({"--listen", address(), "--log", log, "--vcd", vcd, "--pcapng", pcapng});
    ASSERT_TRUE(bus.says("bit/s\n"));
    expect_working_bus();
    // One that is refused leaves the files alone.
    Process second = run({"--listen", address(), "--log", log, "--vcd", vcd, "--pcapng", pcapng});
    EXPECT_EQ(second.wait(), 1);
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
    EXPECT_THAT(content(log), testing::EndsWith(") can0 123#CAFE\n"));
    EXPECT_THAT(content(vcd), HasSubstr("test_tx"));
    EXPECT_THAT(content(vcd), HasSubstr("\n#"));
    EXPECT_THAT(content(pcapng), StartsWith("\x0A\x0D\x0D\x0A"));
    EXPECT_THAT(content(pcapng), HasSubstr("test, "));
}

TEST_F(CanorbBus, SaysAtOnceThatItsLogCannotBeWritten) {
    Process bus = run({"--listen", address(), "--log", "/dev/full"});
    ASSERT_TRUE(bus.says("bit/s\n"));
    expect_working_bus();
    EXPECT_TRUE(bus.says("cannot write all of /dev/full: No space left on device\n"));
    expect_working_bus();  // which goes on
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 1);
    // Only once.
    EXPECT_EQ(bus.text().find("No space"), bus.text().rfind("No space"));
}

TEST_F(CanorbBus, OutlivesARecordingThatIsAsLargeAsItMayBe) {
    struct Limit {
        std::string option;
        std::string kibibytes;  // there is room for a header
    };
    for (const Limit& limit : {Limit{"--vcd", "24"}, Limit{"--pcapng", "1"}}) {
        const std::string recording = directory_.path() + "/recording";
        Process bus =
            Process::program({"/bin/bash", "-c",
                              "ulimit -f " + limit.kibibytes + "; exec " CANORB_BUS " --listen " +
                                  address() + ' ' + limit.option + ' ' + recording});
        ASSERT_TRUE(bus.says("bit/s\n")) << bus.text();
        for (int i = 0; i < 30; ++i) expect_working_bus();
        EXPECT_TRUE(bus.says("cannot write all of " + recording + ": File too large\n"))
            << bus.text();
        bus.send_signal(SIGTERM);
        EXPECT_EQ(bus.wait(), 1);
    }
}

TEST_F(CanorbBus, DoesWhatAFaultScriptSays) {
    const std::string script = file("faults",
                                    "frame 123 attempt 1 at data.1 flip wire\n"
                                    "frame 456 at crc.1 flip pump-3\n");
    Process bus = run({"--listen", address(), "--fault", script, "--status"});
    ASSERT_TRUE(bus.says("bit/s\n"));
    expect_working_bus();
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
    EXPECT_THAT(bus.text(), HasSubstr("1 frame, 1 error frame\n"));
    EXPECT_THAT(bus.text(), HasSubstr("canorb-bus: " + script + ":2: this fault never acted\n"));
    EXPECT_THAT(bus.text(),
                HasSubstr("canorb-bus: " + script + ": no node was called \"pump-3\"\n"));
}

TEST_F(CanorbBus, SaysWhereAFaultScriptIsWrong) {
    const std::string script = file("faults", "at 1s flip wire\nat x flip wire\nframe 123\n");
    for (const std::string& other : {"--listen=" + address(), std::string{"--play=/dev/null"}}) {
        Process bus = run({other, "--fault", script});
        EXPECT_EQ(bus.wait(), 2);
        EXPECT_THAT(bus.text(), StartsWith(script + ":2:4: "));
        EXPECT_THAT(bus.text(), HasSubstr("\n" + script + ":3:"));
    }
    EXPECT_FALSE(std::filesystem::exists(path()));
}

TEST_F(CanorbBus, PlaysAScenario) {
    const std::string scenario = file("scenario", "(0.000000) pump-3 123#DEADBEEF00000000\n");
    const std::string script = file("faults", "frame 123 at sof recessive nobody\n");
    const std::string log = directory_.path() + "/frames.log";
    Process play = run({"--play", scenario, "--nodes", "valve,panel", "--bitrate", "1000000",
                        "--log", log, "--fault", script});
    EXPECT_EQ(play.wait(), 0);
    EXPECT_THAT(play.text(),
                HasSubstr("  0.000115  pump-3  123#DEADBEEF00000000  received by valve, panel\n"
                          "\n"
                          "1000000 bit/s, 0.000118 s, load 100.00 %, 1 frame, 0 error frames\n"
                          "node    state "));
    EXPECT_THAT(play.text(), HasSubstr(script + ":1: this fault never acted\n"));
    EXPECT_EQ(content(log), "(0000000000.000115) pump-3 123#DEADBEEF00000000\n");
    // It can be played again.
    Process again = run({"--play", log, "--nodes", "valve", "--bitrate", "1000000"});
    EXPECT_EQ(again.wait(), 0);
    EXPECT_THAT(again.text(),
                StartsWith("  0.000230  pump-3  123#DEADBEEF00000000  received by valve\n"));
}

TEST_F(CanorbBus, SaysWhereAScenarioIsWrong) {
    const std::string scenario = file("scenario", "(0.000000) a 123#00\nx\n(0.000000) a 1#00\n");
    Process play = run({"--play", scenario});
    EXPECT_EQ(play.wait(), 2);
    EXPECT_THAT(play.text(), StartsWith(scenario + ":2: bad time stamp"));
    EXPECT_THAT(play.text(), HasSubstr("\n" + scenario + ":3: bad identifier"));
}

TEST_F(CanorbBus, DoesNotRecordOverWhatItReads) {
    const std::string text = "(0.000000) a 123#00\n(0.000000) b 124#00\n";
    const std::string scenario = file("scenario", text);
    const std::string script = file("faults", "# nothing\n");
    const std::string symbolic = directory_.path() + "/symbolic";
    const std::string hard = directory_.path() + "/hard";
    std::filesystem::create_symlink("scenario", symbolic);
    std::filesystem::create_hard_link(scenario, hard);
    for (const std::string& log : {scenario, symbolic, hard, directory_.path() + "/./scenario"}) {
        Process play = run({"--play", scenario, "--log", log});
        EXPECT_EQ(play.wait(), 2);
        EXPECT_EQ(play.text(),
                  "canorb-bus: no recording can go to " + log + ": " + scenario + " is read\n");
        EXPECT_EQ(content(scenario), text);
    }
    for (const std::string& other : {"--listen=" + address(), "--play=" + scenario}) {
        Process bus = run({other, "--fault", script, "--vcd", script});
        EXPECT_EQ(bus.wait(), 2);
        EXPECT_EQ(content(script), "# nothing\n");
    }
    Process pipes = run({"--play", "/dev/null", "--log", "/dev/null", "--vcd", "/dev/null"});
    EXPECT_EQ(pipes.wait(), 0) << pipes.text();
}

TEST_F(CanorbBus, DoesNotRecordTwiceToOneFile) {
    // Neither of them exists before.
    const std::string recording = directory_.path() + "/recording";
    const std::string symbolic = directory_.path() + "/symbolic";
    std::filesystem::create_symlink("recording", symbolic);
    Process play = run({"--play", "/dev/null", "--log", recording, "--pcapng", symbolic});
    EXPECT_EQ(play.wait(), 2);
    EXPECT_THAT(play.text(), HasSubstr("only one recording can go to " + recording));
    EXPECT_FALSE(std::filesystem::exists(recording));
}

TEST_F(CanorbBus, SaysThatStandardOutputCannotBeWritten) {
    const std::string scenario = file("scenario", "(0.000000) a 123#00\n(0.000000) b 124#00\n");
    Process play = Process::program(
        {"/bin/bash", "-c", "exec " CANORB_BUS " --play " + scenario + " >/dev/full"});
    EXPECT_EQ(play.wait(), 1);
    EXPECT_EQ(play.text(),
              "canorb-bus: cannot write all of standard output: No space left on device\n");
}

TEST_F(CanorbBus, SaysThatItStartsABusWhereNoneRuns) {
    Process bus = run({"--listen", address(), "--status"});
    ASSERT_TRUE(bus.says("bit/s\n"));
    EXPECT_THAT(bus.text(),
                StartsWith("canorb-bus: no bus runs at " + address() + ": starting one\n"));
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
}

TEST_F(CanorbBus, AdvisesAnotherNodeForALogOfOneName) {
    const std::string scenario = file("scenario", "(0.000000) can0 123#00\n");
    Process play = run({"--play", scenario});
    EXPECT_EQ(play.wait(), 0);
    EXPECT_THAT(play.text(), HasSubstr("canorb-bus: nobody could acknowledge the frames of can0: "
                                       "name another node with --nodes\n"));
}

TEST_F(CanorbBus, CannotWriteARecordingOfAScenario) {
    const std::string scenario = file("scenario", "(0.000000) a 123#00\n(0.000000) b 124#00\n");
    Process play = run({"--play", scenario, "--log", "/dev/full"});
    EXPECT_EQ(play.wait(), 1);
    EXPECT_THAT(play.text(), HasSubstr("cannot write all of /dev/full"));
    EXPECT_THAT(play.text(), HasSubstr(", 2 frames"));
}

TEST_F(CanorbBus, HasControllersThatRecoverByThemselves) {
    const std::string script = file("faults", "frame from test at data.1 flip test\n");
    Process bus = run({"--listen", address(), "--fault", script, "--recover-automatically"});
    ASSERT_TRUE(bus.says("bit/s\n"));
    const auto sender = attach();
    const auto listener = attach_as("listener");
    const std::array<std::uint8_t, 1> data{0xFF};
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(1, data))));
    std::vector<ControllerState> states;
    pollfd descriptor{sender->event_fd(), POLLIN, 0};
    while ((states.empty() || states.back() != ControllerState::error_active) &&
           ::poll(&descriptor, 1, patience_ms) == 1) {
        while (const auto event = sender->poll()) {
            const auto* change = std::get_if<StateChanged>(&*event);
            if (change != nullptr) states.push_back(change->status.state);
        }
    }
    // A client that is late hears of the last of several changes.
    if (!states.empty() && states.front() == ControllerState::error_passive) {
        states.erase(states.begin());
    }
    EXPECT_THAT(states,
                testing::ElementsAre(ControllerState::bus_off, ControllerState::error_active));
}

}  // namespace
}  // namespace canorb::can
