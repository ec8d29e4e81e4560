// Our programs and everybody else's on one interface: candump, canplayer, python-can.

#include <fstream>
#include <iterator>
#include <regex>

#include "tests/socketcan/can_test.hpp"

namespace canorb::test {
namespace {

using testing::MatchesRegex;

class Frames : public VcanTest {
  protected:
    std::unique_ptr<Child> server() {
        auto child = std::make_unique<Child>(
            std::vector<std::string>{SOCKETCAN_NODE, address, "3", "serve"});
        EXPECT_TRUE(child->says("ready\n")) << child->text();
        return child;
    }
    /// A void call: operation 7 of object 1 on node 3, by node 5.
    void call() {
        Child client{{SOCKETCAN_NODE, address, "5", "call", "corbaloc:caniop:3/1", "7"}};
        EXPECT_EQ(client.wait(), 0) << client.text();
    }
    static std::string content(const std::string& path) {
        std::ifstream stream{path};
        return {std::istreambuf_iterator<char>{stream}, {}};
    }
    /// Sends a frame that no ORB receives until `condition`: whoever starts to listen says so
    /// only by what he hears.
    void mark_until(const std::function<bool()>& condition) {
        RawSocket socket{interface};
        EXPECT_TRUE(wait_until([&] {
            socket.send(0x7FF, {});
            return condition();
        }));
    }
};

TEST_F(Frames, CandumpShowsTheOctetsOfAVoidCall) {
    const TemporaryDirectory directory;
    const std::string output = directory.path() + "/output";
    Child candump{{"/bin/sh", "-c", "exec candump " + interface + " >" + output}};
    mark_until([&] { return content(output).find("7FF") != std::string::npos; });
    {
        const auto node = server();
        call();
    }
    std::string text;
    mark_until([&] {
        text = content(output);
        const std::size_t reply = text.rfind("4A3");
        return reply != std::string::npos && text.find("7FF", reply) != std::string::npos;
    });

    // Without the marks, and with one blank where there are several.
    text = std::regex_replace(text, std::regex{".*  7FF  .*\n"}, "");
    text = std::regex_replace(text, std::regex{" +"}, " ");
    // Request and Reply, version 1.0; octets that follow; request id, which starts at random;
    // then node 3, index 1, operation 7, and NO_EXCEPTION.
    const std::regex expected{" " + interface +
                              " 465 \\[8\\] 10 00 05 (.. ..) 18 01 07\n"
                              " " +
                              interface + " 4A3 \\[6\\] 11 00 03 \\1 00\n"};
    EXPECT_TRUE(std::regex_match(text, expected)) << text;
}

TEST_F(Frames, CanplayerRepeatsRecordedCalls) {
    const TemporaryDirectory directory;
    const auto node = server();
    Child candump{{"/bin/sh", "-c", "cd " + directory.path() + " && exec candump -l " + interface}};
    // It writes when it ends. That it listens the kernel tells: a socket for all frames.
    EXPECT_TRUE(wait_until([&] {
        return std::regex_search(content("/proc/net/can/rcvlist_all"),
                                 std::regex{" " + interface + " .*raw"});
    }));
    // A server drops a Request with the id of the one before it, so there are two.
    call();
    call();
    EXPECT_TRUE(node->says("called\n"));
    EXPECT_TRUE(node->says("called\n"));
    candump.send_signal(SIGINT);
    EXPECT_EQ(candump.wait(), 0) << candump.text();

    run_command("canplayer -I " + directory.path() + "/candump-*.log");
    EXPECT_TRUE(node->says("called\n")) << node->text();
    EXPECT_TRUE(node->says("called\n")) << node->text();
}

TEST_F(Frames, PythonCallsAndIsCalled) {
    const auto node = server();
    Child python{{"/usr/bin/python3", SOCKETCAN_SOURCES "/frames.py", interface}};
    EXPECT_TRUE(python.says("4A3#110003ABCD00\n")) << python.text();
    EXPECT_TRUE(node->says("called\n"));
    EXPECT_TRUE(python.says("serving\n")) << python.text();

    Child client{{SOCKETCAN_NODE, address, "7", "call", "corbaloc:caniop:6/2", "9"}};
    EXPECT_EQ(client.wait(), 0) << client.text();
    EXPECT_EQ(client.text(), "\n");
    EXPECT_EQ(python.wait(), 0);
    // To node 6 from node 7; node 6, index 2 = 3002, operation 9.
    EXPECT_THAT(python.text(), MatchesRegex(".*serving\n4C7#100005....300209\n"));
}

}  // namespace
}  // namespace canorb::test
