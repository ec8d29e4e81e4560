// The programs as people run them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/child.hpp"

namespace tank {
namespace {

using canorb::test::Child;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

// A folder of its own for each test, removed with it.
class ProgramTest : public testing::Test {
  protected:
    ProgramTest() {
        std::string path = (std::filesystem::temp_directory_path() / "canorb-tank-XXXXXX").string();
        if (::mkdtemp(path.data()) == nullptr) throw std::runtime_error("no temporary folder");
        folder_ = path;
    }
    ~ProgramTest() override { std::filesystem::remove_all(folder_); }

    std::string file(const std::string& name) const { return folder_ / name; }
    static std::string content(const std::string& path) {
        std::ifstream stream{path, std::ios::binary};
        EXPECT_TRUE(stream.is_open()) << path;
        return {std::istreambuf_iterator<char>{stream}, {}};
    }

    std::filesystem::path folder_;
};

using Tank = ProgramTest;

TEST_F(Tank, writes_the_same_files_every_time) {
    Child tank{{TANK, "--virtual", "--seconds", "10", "--orders", "0.7:h,1.5:c,2:x,2.2:l,4:h",
                "--temperature", "5:300,6:20", "--csv", file("csv"), "--log", file("log"), "--plot",
                file("svg")}};
    EXPECT_EQ(tank.wait(), 0) << tank.text();
    EXPECT_EQ(content(file("csv")), content(TANK_GOLDEN "/tank.csv"));
    EXPECT_EQ(content(file("log")), content(TANK_GOLDEN "/tank.log"));
    EXPECT_EQ(content(file("svg")), content(TANK_GOLDEN "/tank.svg"));
    EXPECT_THAT(tank.text(), HasSubstr("A: setpoint 100 cm\n"));
    EXPECT_THAT(tank.text(), HasSubstr("A: 'x' is no order\n"));
}

TEST_F(Tank, without_a_terminal_prints_status_lines_and_stops) {
    Child tank{{TANK, "--seconds", "2"}};
    EXPECT_EQ(tank.wait(), 0);
    EXPECT_THAT(tank.text(), HasSubstr("mode normal, slot 50 ms, setpoint 50 cm, temperature 20 C, "
                                       "level "));
    EXPECT_THAT(tank.text(), HasSubstr("VS open\n"));
}

TEST_F(Tank, shows_itself_on_a_terminal_and_gives_it_back) {
    Child tank{{TANK}, Child::Input::terminal};
    EXPECT_TRUE(tank.says("node A, the controller"));
    EXPECT_TRUE(tank.says("operator station"));
    tank.type("c");
    EXPECT_TRUE(tank.says("setpoint 100 cm"));
    tank.type("q");
    EXPECT_EQ(tank.wait(), 0);
    // The terminal's other screen is left.
    EXPECT_THAT(tank.text(), HasSubstr("\x1b[?1049l"));
}

TEST_F(Tank, gives_the_terminal_back_when_interrupted) {
    Child tank{{TANK}, Child::Input::terminal};
    EXPECT_TRUE(tank.says("operator station"));
    tank.type("\x03");
    EXPECT_EQ(tank.wait(), 0);
    EXPECT_THAT(tank.text(), HasSubstr("\x1b[?1049l"));
}

struct BadCommandLine {
    std::vector<std::string> arguments;
    std::vector<std::string> message;
};

TEST_F(Tank, names_the_option_and_the_value_that_are_wrong) {
    const std::vector<BadCommandLine> cases{
        {{TANK, "--virtual"}, {"--virtual", "--seconds"}},
        {{TANK, "--orders", "1:c"}, {"--orders", "--virtual"}},
        {{TANK, "--seconds", "soon"}, {"--seconds", "'soon'"}},
        {{TANK, "--virtual", "--seconds", "1", "--orders", "1:cc"}, {"--orders", "'1:cc'"}},
        {{TANK, "--virtual", "--seconds", "1", "--temperature", "1:25"},
         {"--temperature", "'1:25'"}},
        {{TANK, "--virtual", "--seconds", "1", "--bitrate", "9"}, {"--bitrate", "9"}},
        {{TANK, "--virtual", "--seconds", "1", "--csv", "/nonexistent/file"},
         {"--csv", "/nonexistent/file", "No such file"}},
        {{TANK, "--bus", "canbus:0"}, {"canbus:0"}},
        {{TANK, "--level", "9"}, {"--level"}},
        {{TANK_NODE_A, "--node", "31"}, {"--node", "'31'"}},
        {{TANK_NODE_B, "--node", "pump"}, {"--node", "'pump'"}},
        {{TANK_NODE_B, "--bus", "sim:/nonexistent/bus"}, {"sim:/nonexistent/bus", "canorb-bus"}},
        {{TANK_OPERATOR}, {"--serial"}},
        {{TANK_OPERATOR, "--serial", "/dev/null"}, {"--serial /dev/null"}},
        {{TANK_OPERATOR, "--serial", "/nonexistent"}, {"--serial /nonexistent", "No such file"}},
    };
    for (const BadCommandLine& bad : cases) {
        Child child{bad.arguments};
        EXPECT_GT(child.wait(), 0) << child.text();
        for (const std::string& wanted : bad.message) EXPECT_THAT(child.text(), HasSubstr(wanted));
    }
}

TEST_F(Tank, programs_know_help_and_version) {
    for (const char* program : {TANK, TANK_NODE_A, TANK_NODE_B, TANK_OPERATOR}) {
        Child help{{program, "--help"}};
        EXPECT_EQ(help.wait(), 0);
        EXPECT_THAT(help.text(), HasSubstr("Usage: tank"));
        Child version{{program, "--version"}};
        EXPECT_EQ(version.wait(), 0);
        EXPECT_THAT(version.text(), StartsWith("tank"));
        EXPECT_THAT(version.text(), EndsWith("\n"));
    }
}

TEST_F(Tank, nodes_do_without_each_other_and_find_each_other_again) {
    const std::string address = "sim:" + file("bus");
    Child bus{{CANORB_BUS, "--listen", address}};
    ASSERT_TRUE(bus.says(address));

    const auto start = [&](const char* program) {
        return std::make_unique<Child>(std::vector<std::string>{program, "--bus", address});
    };
    auto b = start(TANK_NODE_B);
    auto a = start(TANK_NODE_A);
    ASSERT_TRUE(a->says("operator station at "));
    ASSERT_TRUE(a->says("\n"));
    const std::string path = a->text().substr(a->text().find("/dev/"));
    // VS open, so B hears A.
    ASSERT_TRUE(b->says("VS A")) << b->text();

    // Through the serial line, from a pipe.
    Child station{{TANK_OPERATOR, "--serial", path.substr(0, path.find('\n'))}, Child::Input::pipe};
    station.type("dh\n");
    station.end_input();
    EXPECT_TRUE(station.says("setpoint 125 cm")) << station.text();
    EXPECT_TRUE(station.says("slot 5 ms")) << station.text();
    EXPECT_TRUE(b->says("|  5ms")) << b->text();

    // The controller dies while the tank fills.
    EXPECT_TRUE(b->says("VE A VS A")) << b->text();
    a->send_signal(SIGKILL);
    EXPECT_TRUE(b->says("no actuation for 3 rounds of 5 ms slots: both valves closed"))
        << b->text();
    EXPECT_TRUE(b->says("LOST|")) << b->text();
    EXPECT_TRUE(b->says("VE C VS C")) << b->text();
    EXPECT_GT(station.wait(), 0);
    EXPECT_THAT(station.text(), HasSubstr("node A has closed the line"));
    a = start(TANK_NODE_A);
    EXPECT_TRUE(b->says("the controller is back")) << b->text();
    EXPECT_TRUE(b->says("| 50ms")) << b->text();

    // The node at the tank dies.
    b->send_signal(SIGKILL);
    EXPECT_TRUE(a->says("no level for 3 rounds: both valves ordered closed")) << a->text();
    EXPECT_TRUE(a->says("STALE")) << a->text();
    b = start(TANK_NODE_B);
    EXPECT_TRUE(a->says("the level is back")) << a->text();
    EXPECT_TRUE(b->says("VS A")) << b->text();

    // A polite end.
    a->send_signal(SIGTERM);
    EXPECT_EQ(a->wait(), 0);
    b->send_signal(SIGINT);
    EXPECT_EQ(b->wait(), 0);
}

}  // namespace
}  // namespace tank
