// Interfaces that are not there, go away and come back, and who may use them.

#include <atomic>
#include <filesystem>

#include "tests/socketcan/can_test.hpp"

namespace canorb::test {
namespace {

using can::ControllerState;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

/// How long the end of an interface may take to end a call.
constexpr auto limit = 100ms;

void expect_comm_failure_in_time(const CallInProgress::End& end,
                                 CallInProgress::Clock::time_point since) {
    ASSERT_TRUE(end.error.has_value()) << "it was answered";
    EXPECT_EQ(end.error->kind, SystemErrorKind::comm_failure);
    EXPECT_LT(end.time - since, limit);
}

class Interface : public VcanTest {
  protected:
    void SetUp() override {
        VcanTest::SetUp();
        if (IsSkipped()) return;
        if (::geteuid() != 0) GTEST_SKIP() << "changes interfaces, which only root may do";
    }
    void TearDown() override {
        if (IsSkipped()) return;
        if (::if_nametoindex(interface.c_str()) == 0) add();
        set_up(interface, true);
    }
    void add() {
        ip("link add " + interface + " type vcan");
        set_up(interface, true);
    }

    /// Starts a call that is not answered, and returns when it is on the bus.
    CallInProgress call_nobody(Node& client) {
        RawSocket observer{interface};
        observer.accept_only(0b1'01001'00101);  // to node 9 from node 5
        CallInProgress call{client.object_on(9)};
        EXPECT_TRUE(observer.receive_within(20s));
        return call;
    }
    /// The same to a servant of node 3, operation 7, that waits until `release` is set.
    CallInProgress call_slow_servant(Node& client) {
        CallInProgress call{client.object_on(3)};
        EXPECT_TRUE(wait_until([&] { return in_servant.load(); }));
        return call;
    }

    /// Both tell that they are error active, and a call between them is answered.
    void expect_to_work(Node& server, Node& client) {
        EXPECT_TRUE(server.tells(ControllerState::error_active));
        EXPECT_TRUE(client.tells(ControllerState::error_active));
        const std::vector<std::uint8_t> octets(30, 7);
        EXPECT_EQ(client.object_on(3).invoke(8, octets), octets);
    }
    /// The interface is gone. Both tell so, and work again when it is back.
    void expect_to_work_again(Node& server, Node& client, const std::function<void()>& bring_back) {
        EXPECT_TRUE(server.tells(ControllerState::stopped));
        EXPECT_TRUE(client.tells(ControllerState::stopped));
        bring_back();
        expect_to_work(server, client);
    }

    std::atomic<bool> in_servant = false;
    std::atomic<bool> release = false;
    TestServant servant{{{7,
                          [this](ServerCall& call) {
                              in_servant = true;
                              wait_until([&] { return release.load(); });
                              nothing(call);
                          }},
                         {8, echo}}};
};

TEST_F(Interface, GoesDownInACall) {
    Node client{address, 5};
    CallInProgress call = call_nobody(client);
    const auto since = CallInProgress::Clock::now();
    set_up(interface, false);
    expect_comm_failure_in_time(call.end(), since);
    EXPECT_EQ(client->error_status().state, ControllerState::stopped);
    EXPECT_TRUE(client.tells(ControllerState::stopped));
    EXPECT_THAT(client.events(Event::Kind::controller_state).at(0).text,
                AllOf(HasSubstr("stopped"), HasSubstr("ip link set " + interface + " up"),
                      Not(HasSubstr("\n"))));

    // Nothing waits for what cannot be sent.
    const auto called = CallInProgress::Clock::now();
    expect_comm_failure_in_time(CallInProgress{client.object_on(9)}.end(), called);
}

TEST_F(Interface, WorksAgainWhenItIsUp) {
    Node server{address, 3};
    Node client{address, 5};
    server->root_poa().activate_object_with_id(1, servant);
    for (int round = 0; round < 3; ++round) {
        in_servant = release = false;
        CallInProgress call = call_slow_servant(client);
        const auto since = CallInProgress::Clock::now();
        set_up(interface, false);
        expect_comm_failure_in_time(call.end(), since);
        release = true;
        expect_to_work_again(server, client, [&] { set_up(interface, true); });
    }
}

TEST_F(Interface, IsSetDownWithIp) {
    Node client{address, 5};
    CallInProgress call = call_nobody(client);
    const auto since = CallInProgress::Clock::now();
    ip("link set " + interface + " down");
    const auto down = CallInProgress::Clock::now();
    const CallInProgress::End end = call.end();
    EXPECT_GT(end.time, since);
    expect_comm_failure_in_time(end, down);
}

TEST_F(Interface, IsRemovedAndAddedAgain) {
    Node server{address, 3};
    Node client{address, 5};
    server->root_poa().activate_object_with_id(1, servant);
    for (int round = 0; round < 2; ++round) {
        in_servant = release = false;
        CallInProgress call = call_slow_servant(client);
        ip("link delete " + interface);
        const auto deleted = CallInProgress::Clock::now();
        expect_comm_failure_in_time(call.end(), deleted);
        release = true;
        expect_to_work_again(server, client, [&] { add(); });
    }
}

TEST_F(Interface, IsDownAtFirst) {
    set_up(interface, false);
    Node server{address, 3};
    Node client{address, 5};
    server->root_poa().activate_object_with_id(1, servant);
    const auto called = CallInProgress::Clock::now();
    expect_comm_failure_in_time(CallInProgress{client.object_on(3)}.end(), called);
    set_up(interface, true);
    expect_to_work(server, client);
}

// The kernel drops its news of interfaces when there are too many for who does not read them.
TEST_F(Interface, IsUpAgainAfterMoreNewsThanTheKernelKeeps) {
    ip("link add vcan8 type vcan");
    {
        const std::unique_ptr<Bus> bus = open_bus(address);
        OrbOptions options;
        options.node = 5;
        options.log = [](std::string_view) {};
        Orb orb{*bus, options};
        orb.poll();
        EXPECT_EQ(orb.error_status().state, ControllerState::error_active);

        set_up(interface, false);
        for (int i = 0; i < 400; ++i) {
            set_up("vcan8", true);
            set_up("vcan8", false);
        }
        set_up(interface, true);

        RawSocket observer{interface};
        observer.accept_only(0b0'00101'00101);  // to group 5 from node 5
        // The first ones may still be lost: it is not known that it was down.
        EXPECT_TRUE(wait_until([&] {
            orb.poll();
            if (orb.error_status().state != ControllerState::error_active) return false;
            try {
                orb.group_reference(GroupId{5}).invoke(7, {});
            } catch (const COMM_FAILURE&) {
                return false;
            }
            return observer.receive_within(1ms).has_value();
        }));
        EXPECT_TRUE(orb.run_for(20ms));
        EXPECT_EQ(orb.error_status().state, ControllerState::error_active);

        // And it knows of what comes later.
        set_up(interface, false);
        EXPECT_TRUE(wait_until([&] {
            orb.poll();
            return orb.error_status().state == ControllerState::stopped;
        }));
        set_up(interface, true);
        EXPECT_TRUE(wait_until([&] {
            orb.poll();
            return orb.error_status().state == ControllerState::error_active;
        }));
    }
    ip("link delete vcan8");
}

TEST_F(Interface, OfARealDriverGoesDownInACall) {
    const std::optional<Interfaces> pair = can_pair();
    if (!pair) GTEST_SKIP() << "CANORB_TEST_CAN_PAIR names no interfaces";
    Node server{"socketcan:" + pair->first, 3};
    Node client{"socketcan:" + pair->second, 5};
    server->root_poa().activate_object_with_id(1, servant);
    EXPECT_EQ(client->link_capabilities().bitrate, 500'000U);

    CallInProgress call = call_slow_servant(client);
    const auto since = CallInProgress::Clock::now();
    set_up(pair->second, false);
    expect_comm_failure_in_time(call.end(), since);
    release = true;
    EXPECT_TRUE(client.tells(ControllerState::stopped));
    set_up(pair->second, true);
    EXPECT_TRUE(client.tells(ControllerState::error_active));
    const std::vector<std::uint8_t> octets(30, 7);
    EXPECT_EQ(client.object_on(3).invoke(8, octets), octets);

    set_up(pair->first, false);
    EXPECT_TRUE(server.tells(ControllerState::stopped));
    set_up(pair->first, true);
    EXPECT_TRUE(server.tells(ControllerState::error_active));
    EXPECT_EQ(client.object_on(3).invoke(8, octets), octets);
}

TEST_F(Interface, HasNoCarrierWhileItsOtherEndIsDown) {
    ip("link add vxcan8 type vxcan peer name vxcan9");
    set_up("vxcan8", true);
    {
        Node server{"socketcan:vxcan8", 3};
        EXPECT_TRUE(server.tells(ControllerState::stopped));
        EXPECT_THAT(server.events(Event::Kind::controller_state).at(0).text,
                    HasSubstr("vxcan8 has no carrier"));
        server->root_poa().activate_object_with_id(1, servant);
        set_up("vxcan9", true);
        Node client{"socketcan:vxcan9", 5};
        EXPECT_TRUE(server.tells(ControllerState::error_active));
        EXPECT_EQ(client.object_on(3).invoke(8, std::vector<std::uint8_t>{1}),
                  std::vector<std::uint8_t>{1});
        set_up("vxcan9", false);
        EXPECT_TRUE(server.tells(ControllerState::stopped));
    }
    ip("link delete vxcan8");
}

TEST_F(Interface, IsSharedByTwoNetworkNamespaces) {
    ip("netns add canorb-a");
    ip("netns add canorb-b");
    ip("link add vxcan0 netns canorb-a type vxcan peer name vxcan1 netns canorb-b");
    ip("-n canorb-a link set vxcan0 up");
    ip("-n canorb-b link set vxcan1 up");
    {
        Child server{{"/sbin/ip", "netns", "exec", "canorb-a", SOCKETCAN_NODE, "socketcan:vxcan0",
                      "3", "serve"}};
        EXPECT_TRUE(server.says("ready\n")) << server.text();
        Child client{{"/sbin/ip", "netns", "exec", "canorb-b", SOCKETCAN_NODE, "socketcan:vxcan1",
                      "5", "call", "corbaloc:caniop:3/1", "8", "00112233445566778899"}};
        EXPECT_EQ(client.wait(), 0);
        EXPECT_EQ(client.text(), "00112233445566778899\n");
        EXPECT_TRUE(server.says("called\n"));
    }
    ip("netns delete canorb-a");
    ip("netns delete canorb-b");
}

TEST_F(Interface, IsForEveryUser) {
    // Where the repository is, the user may not be able to read.
    const TemporaryDirectory directory;
    std::filesystem::permissions(directory.path(), std::filesystem::perms{0755});
    const std::string program = directory.path() + "/node";
    std::filesystem::copy_file(SOCKETCAN_NODE, program);
    const std::vector<std::string> as_nobody{
        "/usr/bin/setpriv", "--reuid=65534",   "--regid=65534",
        "--clear-groups",   "--inh-caps=-all", "--bounding-set=-all",
        "--no-new-privs",   program,           address};
    const auto with = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), as_nobody.begin(), as_nobody.end());
        return arguments;
    };
    Child server{with({"3", "serve"})};
    EXPECT_TRUE(server.says("ready\n")) << server.text();
    Child client{with({"5", "call", "corbaloc:caniop:3/1", "7"})};
    EXPECT_EQ(client.wait(), 0) << client.text();
    EXPECT_TRUE(server.says("called\n"));
    EXPECT_EQ(server.text(), "ready\ncalled\n");
}

/// What open_bus() says, which is to be one line.
std::string error_of_opening(const std::string& address) {
    const std::string text = what<COMM_FAILURE>([&] { (void)open_bus(address); });
    EXPECT_THAT(text, Not(HasSubstr("\n")));
    return text;
}

TEST_F(Interface, DoesNotExist) {
    EXPECT_THAT(error_of_opening("socketcan:can77"),
                AllOf(HasSubstr("can77"), HasSubstr("ip link")));
}

TEST_F(Interface, IsNotForCan) {
    EXPECT_THAT(error_of_opening("socketcan:lo"), AllOf(HasSubstr("lo"), HasSubstr("CAN")));
}

}  // namespace
}  // namespace canorb::test
