// The programs as people run them, and the script that starts them all.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/support/child.hpp"

namespace plant {
namespace {

namespace fs = std::filesystem;
using canorb::test::Child;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// The script's temporary files are in a folder of each test's own, so that what belongs to it can
// be found, and must be gone in the end.
class PlantPrograms : public testing::Test {
  protected:
    PlantPrograms() {
        std::string path = (fs::temp_directory_path() / "canorb-plant-test-XXXXXX").string();
        if (::mkdtemp(path.data()) == nullptr) throw std::runtime_error("no temporary folder");
        folder_ = path;
        ::setenv("TMPDIR", path.c_str(), 1);
    }
    ~PlantPrograms() override {
        for (const auto& [id, command] : processes()) ::kill(id, SIGKILL);
        ::unsetenv("TMPDIR");
        fs::remove_all(folder_);
    }

    struct Process {
        pid_t id;
        std::string command;
    };

    // Those with the test's folder on their command lines: the bus and all nodes.
    std::vector<Process> processes() const {
        std::vector<Process> found;
        for (const auto& entry : fs::directory_iterator("/proc")) {
            const std::string name = entry.path().filename();
            if (!std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; })) continue;
            std::ifstream file{entry.path() / "cmdline", std::ios::binary};
            // Not by iterators: where the process has just ended, they throw.
            std::string command;
            std::getline(file, command, '\xFF');
            std::ranges::replace(command, '\0', ' ');
            if (command.find(folder_.string()) != std::string::npos)
                found.push_back({std::stoi(name), command});
        }
        return found;
    }
    pid_t process(std::string_view part_of_command) const {
        for (const auto& [id, command] : processes()) {
            if (command.find(part_of_command) != std::string::npos) return id;
        }
        return 0;
    }

    void expect_nothing_left() const {
        EXPECT_THAT(processes(), IsEmpty());
        EXPECT_TRUE(fs::is_empty(folder_));
    }

    std::unique_ptr<Child> script(Child::Input input) const {
        return std::make_unique<Child>(
            std::vector<std::string>{RUN_PLANT, "--bin", PROGRAMS, "--seconds", "120"}, input);
    }

    // Processes are not in step: what they say comes in any order.
    static testing::AssertionResult say(Child& child, std::vector<std::string> wanted) {
        while (true) {
            std::erase_if(wanted, [&](const std::string& text) {
                return child.text().find(text) != std::string::npos;
            });
            if (wanted.empty()) return testing::AssertionSuccess();
            if (!child.says("\n"))
                return testing::AssertionFailure()
                       << "without '" << wanted.front() << "': " << child.text();
        }
    }

    // On a terminal. It gets only what changed of each line, unless everything is drawn anew.
    static testing::AssertionResult show(Child& child, const std::string& wanted) {
        const std::size_t before = child.text().size();
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{30};
        while (std::chrono::steady_clock::now() < deadline) {
            child.type("\x0c");
            // The first line of one picture comes after all of the one before.
            if (!child.says("canorb: ")) break;
            if (child.text().find(wanted, before) != std::string::npos)
                return testing::AssertionSuccess();
            std::this_thread::sleep_for(std::chrono::milliseconds{20});
        }
        return testing::AssertionFailure()
               << "without '" << wanted << "': " << child.text().substr(before);
    }

    fs::path folder_;
};

TEST_F(PlantPrograms, run_from_one_script_and_take_commands_by_name) {
    auto run = script(Child::Input::pipe);
    ASSERT_TRUE(say(
        *run, {"sensor-12: joined group 2: CAN_IOR:", "actuator-23: joined group 1: CAN_IOR:",
               "controller: my reference: ", "controller: actuators on: all within their limits\n",
               "actuator-21: on\n", "actuator-22: on\n", "actuator-23: on\n"}));
    EXPECT_EQ(processes().size(), 8U);  // a bus, six nodes, and their panels
    EXPECT_NE(process("--sensors CAN_IOR:"), 0);

    run->type("actuator-22 leave 1\n");
    ASSERT_TRUE(say(*run, {"actuator-22: left group 1\n"}));
    run->type("sensor-12 value temperature 80\n");
    EXPECT_TRUE(say(*run, {"|!actuators OFF: temperature of sensor 12 over its limit|",
                           "actuator-21: off\n", "actuator-23: off\n"}));
    EXPECT_THAT(run->text(), Not(HasSubstr("actuator-22: off\n")));
    run->type("controller limit temperature 90\n");
    EXPECT_TRUE(say(*run, {"|+temperature       90.0 C        20.0       80.0 |"}));
    run->type("actuator-22 join 1\nsensor-12 quit\n");
    EXPECT_TRUE(
        say(*run, {"|!actuators OFF: sensor 12 is silent|", "STALE|", "actuator-22: off\n"}));
    run->type("pump-1 stop\nsensor-11 explode\n");
    EXPECT_TRUE(say(*run, {"'pump-1 stop': write quit, or a node and its command. There are "
                           "controller sensor-11 sensor-12 actuator-21 actuator-22 actuator-23\n",
                           "sensor-11: 'explode' is no command."}));
    run->type("quit\n");
    EXPECT_EQ(run->wait(), 0);
    expect_nothing_left();
}

TEST_F(PlantPrograms, end_together_when_one_dies) {
    auto run = script(Child::Input::pipe);
    ASSERT_TRUE(say(*run, {"actuators on"}));
    ::kill(process("--node 22"), SIGKILL);
    EXPECT_EQ(run->wait(), 1);
    EXPECT_THAT(run->text(), HasSubstr("run_plant: actuator-22 ended (signal 9): "));
    expect_nothing_left();
}

TEST_F(PlantPrograms, end_together_when_the_bus_dies_or_the_script_is_told_to) {
    {
        auto run = script(Child::Input::pipe);
        ASSERT_TRUE(say(*run, {"actuators on"}));
        ::kill(process("--listen"), SIGTERM);
        EXPECT_EQ(run->wait(), 1);
        EXPECT_THAT(run->text(), HasSubstr("run_plant: canorb-bus ended (exit code 0)"));
        expect_nothing_left();
    }
    auto run = script(Child::Input::pipe);
    ASSERT_TRUE(say(*run, {"actuators on"}));
    // One that does not run could not end by itself.
    ::kill(process("--node 12"), SIGSTOP);
    run->send_signal(SIGTERM);
    EXPECT_EQ(run->wait(), 0);
    expect_nothing_left();
}

TEST_F(PlantPrograms, share_a_terminal_and_give_it_back) {
    auto run = script(Child::Input::terminal);
    EXPECT_TRUE(show(*run, "actuator-23"));
    EXPECT_TRUE(show(*run, "all within their limits"));
    run->type("2T");
    EXPECT_TRUE(show(*run, "25.0 C"));
    run->type(":value temperature 80\n");
    EXPECT_TRUE(show(*run, "temperature of sensor 11 over its limit"));
    run->type("5v1\n");
    EXPECT_TRUE(show(*run, "left group 1"));
    run->type("\x03");
    EXPECT_EQ(run->wait(), 0);
    EXPECT_THAT(run->text(), HasSubstr("\x1b[?1049l"));
    expect_nothing_left();
}

TEST_F(PlantPrograms, have_a_screen_each_on_a_terminal_of_their_own) {
    const std::string address = "sim:" + (folder_ / "bus").string();
    Child bus{{PROGRAMS "/canorb-bus", "--listen", address}};
    ASSERT_TRUE(bus.says(address));
    Child sensor{{PROGRAMS "/plant_sensor", "--bus", address}, Child::Input::terminal};
    EXPECT_TRUE(show(sensor, "sensor-11"));
    sensor.type("TTT");
    EXPECT_TRUE(show(sensor, "35.0 C"));
    Child actuator{{PROGRAMS "/plant_actuator", "--bus", address}, Child::Input::pipe};
    // The default groups are the right ones.
    Child controller{{PROGRAMS "/plant_controller", "--bus", address}, Child::Input::pipe};
    EXPECT_TRUE(controller.says("|+actuators ON: all within their limits|"));
    EXPECT_TRUE(actuator.says("|+ON| controller node 1| in group 1|"));
    controller.type("quit\n");
    EXPECT_EQ(controller.wait(), 0);
    actuator.send_signal(SIGINT);
    EXPECT_EQ(actuator.wait(), 0);
    sensor.type("q");
    EXPECT_EQ(sensor.wait(), 0);
    EXPECT_THAT(sensor.text(), HasSubstr("\x1b[?1049l"));
    bus.send_signal(SIGTERM);
    EXPECT_EQ(bus.wait(), 0);
}

struct BadCommandLine {
    std::vector<std::string> arguments;
    std::vector<std::string> message;
};

TEST_F(PlantPrograms, name_what_is_wrong) {
    const std::vector<BadCommandLine> cases{
        {{RUN_PLANT, "--bin", "/nonexistent"}, {"/nonexistent/canorb-bus", "./run build plant"}},
        {{RUN_PLANT, "--nodes"}, {"--nodes"}},
        {{RUN_PLANT, "--log"}, {"--log needs a value"}},
        {{RUN_PLANT, "--bin", PROGRAMS, "--log", "/nonexistent/file"}, {"/nonexistent/file"}},
        {{RUN_PLANT, "--bin", PROGRAMS, "--seconds", "soon"}, {"--seconds"}},
        {{PROGRAMS "/plant_sensor", "--group", "32"}, {"--group", "'32'"}},
        {{PROGRAMS "/plant_actuator", "--node", "31"}, {"--node", "'31'"}},
        {{PROGRAMS "/plant_controller", "--bus", "sim:/nonexistent/bus"},
         {"sim:/nonexistent/bus", "canorb-bus"}},
        {{PROGRAMS "/plant_controller", "--bus", "local:plant", "--sensors", "corbaloc:caniop:1/1"},
         {"no group of sensors", "corbaloc:caniop:1/1"}},
        {{PROGRAMS "/plant_panels", "controller"}, {"--folder"}},
        {{PROGRAMS "/plant_panels", "--folder", "/nonexistent", "controller"},
         {"/nonexistent/controller.out", "No such file"}},
    };
    for (const BadCommandLine& bad : cases) {
        Child child{bad.arguments};
        EXPECT_GT(child.wait(), 0) << child.text();
        for (const std::string& wanted : bad.message) EXPECT_THAT(child.text(), HasSubstr(wanted));
    }
    expect_nothing_left();
}

TEST_F(PlantPrograms, know_help_and_version) {
    for (const char* program :
         {"plant_controller", "plant_sensor", "plant_actuator", "plant_panels"}) {
        Child help{{std::string{PROGRAMS "/"} + program, "--help"}};
        EXPECT_EQ(help.wait(), 0);
        EXPECT_THAT(help.text(), HasSubstr(std::string{"Usage: "} + program));
        Child version{{std::string{PROGRAMS "/"} + program, "--version"}};
        EXPECT_EQ(version.wait(), 0);
        EXPECT_THAT(version.text(), StartsWith(std::string{program} + " "));
    }
    Child help{{RUN_PLANT, "--help"}};
    EXPECT_EQ(help.wait(), 0);
    EXPECT_THAT(help.text(), HasSubstr("usage: run_plant"));
}

}  // namespace
}  // namespace plant
