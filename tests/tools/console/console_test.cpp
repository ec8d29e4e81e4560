// canorb as people run it: a process of its own, on the bus of a daemon, with nodes of the test.

#include <gmock/gmock.h>
#include <signal.h>

#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "canorb/orb.hpp"
#include "tests/can/bus_server_fixture.hpp"
#include "tests/support/child.hpp"
#include "tests/support/shell.hpp"
#include "things.hpp"

namespace canorb::console {
namespace {

using canorb::test::shell;
using canorb::test::ShellResult;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

class Motor final : public Things::MotorServant {
  public:
    void ring(std::uint8_t times, const std::string&) override { rung += times; }
    void note(const std::string& text) override {
        const std::lock_guard lock{mutex_};
        notes_ += text;
        ++noted;
    }
    float limit() override { return limit_; }
    void limit(float value) override { limit_ = value; }
    Things::Settings adjust(const Things::Settings& wanted, std::int32_t& offset,
                            bool& changed) override {
        offset -= 1;
        changed = true;
        return {static_cast<std::uint16_t>(wanted.speed + 1), Things::Working::busy};
    }
    void start(std::uint8_t how) override {
        if (how == 1) throw Things::Refused{"no \x1Bpower", 7};
        if (how == 2) throw NO_PERMISSION{"the key is off", Completion::yes, 9};
        if (how == 3) throw std::runtime_error{"a bug"};
    }
    std::vector<std::uint8_t> raw(std::uint8_t count) override { return {count, 2, 3}; }
    Things::Lamp peer() override { return {}; }

    std::atomic<int> rung = 0;
    std::atomic<int> noted = 0;

  private:
    float limit_ = 0.5F;
    std::mutex mutex_;
    std::string notes_;
};

/// Node 3 with a motor, which is in group 5, and node 7 without anything.
class Console : public can::test::BusServerTest {
  protected:
    void SetUp() override {
        start(options(false));
        bus_ = open_bus(address());
        OrbOptions three;
        three.node = 3;
        three.name = "pump-3";
        three.vendor = "Acme";
        three.product =
            "P\xC2\x9B"
            "7";  // a control character
        three.serial = 66;
        three.software_version = "1.2.3";
        three.log = [](std::string_view) {};
        orb_ = std::make_unique<Orb>(*bus_, three);
        orb_->object_join(orb_->root_poa().activate_object_with_id(1, motor_), GroupId{5});
        OrbOptions seven;
        seven.node = 7;
        seven.log = [](std::string_view) {};
        idle_ = std::make_unique<Orb>(*bus_, seven);
        threads_.emplace_back([this] { orb_->run(); });
        threads_.emplace_back([this] { idle_->run(); });
    }
    void TearDown() override {
        orb_->shutdown();
        idle_->shutdown();
        for (auto& thread : threads_) thread.join();
    }

    /// Standard output and errors together.
    ShellResult canorb(const std::string& arguments) const {
        return shell("env -u CANORB_NODE CANORB_BUS=" + address() + " " CANORB_CONSOLE " " +
                     arguments + " 2>&1");
    }
    ShellResult call(const std::string& arguments) const {
        return canorb("call --timeout 20s --idl " + idl + ' ' + arguments);
    }
    nlohmann::json json_of(const ShellResult& result) const {
        return nlohmann::json::parse(result.output, nullptr, false);
    }

    const std::string idl = CANORB_THINGS_IDL;
    const std::string motor = "corbaloc:caniop:3/1 ";
    Motor motor_;
    std::unique_ptr<Bus> bus_;
    std::unique_ptr<Orb> orb_;
    std::unique_ptr<Orb> idle_;
    std::vector<std::thread> threads_;
};

TEST_F(Console, CallsWhatTheObjectSaysItHas) {
    const ShellResult read = call(motor + "limit");
    EXPECT_EQ(read.output, "0.5\n");
    EXPECT_EQ(read.exit_code, 0);
    EXPECT_EQ(call(motor + "limit -2.5").output, "");
    EXPECT_EQ(call(motor + "_get_limit").output, "-2.5\n");
    EXPECT_EQ(call(motor + R"(adjust '{"speed": 70, "mode": "idle"}' -5)").output,
              "result = {\"speed\":71,\"mode\":\"busy\"}\noffset = -6\nchanged = true\n");
    EXPECT_EQ(call(motor + "raw 1").output, "[1,2,3]\n");
    EXPECT_EQ(call(motor + "peer").output, "\"nil\"\n");
    const ShellResult rung = call(motor + "ring 3 ''");
    EXPECT_EQ(rung.output, "");
    EXPECT_EQ(rung.exit_code, 0);
    EXPECT_EQ(motor_.rung, 3);
}

TEST_F(Console, SaysWhenNobodyHearsACallWithoutAnAnswer) {
    can::test::TemporaryDirectory directory;
    can::BusServerOptions empty_bus;
    empty_bus.path = directory.path() + "/empty";
    can::test::RunningServer empty{empty_bus};
    for (const char* target : {"corbaloc:caniop:group/5", "corbaloc:caniop:3/1"}) {
        const ShellResult rung =
            canorb("call --timeout 200ms --bus sim:" + empty_bus.path + " --idl " + idl +
                   " --interface Things::Motor " + target + " ring 2 x");
        EXPECT_THAT(rung.output, HasSubstr("TIMEOUT")) << target;
        EXPECT_EQ(rung.exit_code, 1) << target;
    }
}

TEST_F(Console, CallsByEveryKindOfReference) {
    const std::string ior = orb_->object_to_string(orb_->string_to_object("corbaloc:caniop:3/1"));
    EXPECT_EQ(call(ior + " limit").output, "0.5\n");
    const ShellResult group = call(orb_->group_to_string(GroupId{5}) + " ring 2 x");
    EXPECT_EQ(group.output, "");
    EXPECT_EQ(group.exit_code, 0);
    // The call is asynchronous, but the next one to the same node comes behind it.
    EXPECT_EQ(call(motor + "limit").exit_code, 0);
    EXPECT_EQ(motor_.rung, 2);
    const ShellResult unknown = call("corbaloc:caniop:group/5 ring 2 x");
    EXPECT_THAT(unknown.output, HasSubstr("does not say which interface its members have"));
    EXPECT_THAT(unknown.output, HasSubstr("Things::Motor"));
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_EQ(call("--interface Things::Lamp corbaloc:caniop:group/5 ring 4 x").exit_code, 0);
    EXPECT_EQ(call(motor + "limit").exit_code, 0);
    EXPECT_EQ(motor_.rung, 6);
    const ShellResult not_groupable =
        call("--interface Things::Motor corbaloc:caniop:group/5 limit");
    EXPECT_THAT(not_groupable.output, HasSubstr("cannot be sent to a group"));
    EXPECT_EQ(not_groupable.exit_code, 2);
    EXPECT_EQ(call("--interface IDL:Things/Lamp:1.0 " + motor + "note hello").exit_code, 0);
    EXPECT_EQ(call(motor + "limit").exit_code, 0);
    EXPECT_EQ(motor_.noted, 1);
}

TEST_F(Console, CallsWhatEveryObjectHas) {
    EXPECT_EQ(canorb("call " + motor + "_interface").output, "\"IDL:Things/Motor:1.0\"\n");
    EXPECT_EQ(canorb("call " + motor + "_is_a IDL:Things/Lamp:1.0").output, "true\n");
    EXPECT_EQ(canorb("call corbaloc:caniop:3/9 _non_existent").output, "true\n");
    EXPECT_EQ(canorb("call " + motor + "_is_a").exit_code, 2);
    // The management object's interface is known.
    EXPECT_THAT(canorb("call corbaloc:caniop:3/0 identity").output,
                HasSubstr(R"("name":"pump-3")"));
}

TEST_F(Console, NamesExceptions) {
    const ShellResult user = call(motor + "start 1");
    EXPECT_EQ(user.output,
              "canorb: start raised Things::Refused (\"IDL:Things/Refused:1.0\"): "
              "{reason: \"no \\u001bpower\", code: 7}\n");
    EXPECT_EQ(user.exit_code, 1);
    const ShellResult system = call(motor + "start 2");
    EXPECT_THAT(system.output, HasSubstr("NO_PERMISSION (completed YES, minor 9)"));
    EXPECT_EQ(system.exit_code, 1);
    EXPECT_THAT(call(motor + "start 3").output, HasSubstr("UNKNOWN (completed MAYBE, minor 40)"));
    const ShellResult nobody = call("corbaloc:caniop:3/9 limit");
    EXPECT_THAT(nobody.output, HasSubstr("OBJECT_NOT_EXIST (completed NO, minor 16)"));
    EXPECT_EQ(nobody.exit_code, 1);
    const ShellResult late = canorb("call --timeout 20ms corbaloc:caniop:9/1 _interface");
    EXPECT_THAT(late.output, AllOf(HasSubstr("TIMEOUT (completed "), HasSubstr("--timeout")));
    EXPECT_EQ(late.exit_code, 1);
}

TEST_F(Console, PrintsJsonForScripts) {
    const auto results =
        json_of(call("--json " + motor + R"(adjust '{"speed": 1, "mode": "busy"}' 5)"));
    EXPECT_EQ(results["results"]["result"]["speed"], 2);
    EXPECT_EQ(results["results"]["changed"], true);
    const ShellResult raised =
        shell("CANORB_BUS=" + address() + " " CANORB_CONSOLE " call --json --idl " + idl + ' ' +
              motor + "start 1 2>/dev/null");
    EXPECT_EQ(raised.exit_code, 1);
    const auto user = json_of(raised)["exception"];
    EXPECT_EQ(user["kind"], "user");
    EXPECT_EQ(user["name"], "Things::Refused");
    EXPECT_EQ(user["members"]["code"], 7);
    const auto system =
        json_of(shell("CANORB_BUS=" + address() + " " CANORB_CONSOLE " call --json --idl " + idl +
                      ' ' + motor + "start 2 2>/dev/null"))["exception"];
    EXPECT_EQ(system["name"], "NO_PERMISSION");
    EXPECT_EQ(system["completed"], "YES");
    EXPECT_EQ(system["minor"], 9);
}

TEST_F(Console, SaysWhatIsWrongWithWhatWasAsked) {
    const auto expect_usage_error = [&](const ShellResult& result, const std::string& text) {
        EXPECT_THAT(result.output, HasSubstr(text));
        EXPECT_EQ(result.exit_code, 2);
    };
    expect_usage_error(call(motor + R"(adjust '{"speed": 70000, "mode": "idle"}' 5)"),
                       "argument 1 (wanted.speed: unsigned short): 70000 is not 0 to 65535");
    expect_usage_error(call(motor + "limit 1 2"), "_set_limit takes 1 argument, not 2");
    expect_usage_error(call(motor + "stop"),
                       "Things::Motor has no operation or attribute 'stop'. It has:\n"
                       "  void ring(in octet times, in string why)\n");
    expect_usage_error(canorb("call " + motor + "limit"),
                       "the interface IDL:Things/Motor:1.0 is not in the IDL given");
    expect_usage_error(call("corbaloc:caniop:31/1 limit"), "the node is not a number from 0 to 30");
    expect_usage_error(call("CAN_IOR:0100ff limit"), "this reference is nil");
    expect_usage_error(canorb("call"), "call needs a REF and an OPERATION");
    expect_usage_error(canorb("call --nonsense " + motor + "limit"), "--nonsense");
    expect_usage_error(canorb("call --idl /nonexistent.idl " + motor + "limit"),
                       "did not compile /nonexistent.idl");
    expect_usage_error(canorb("call --idl-json " + idl + ' ' + motor + "limit"),
                       "is not what canorb-idlc --emit json writes");
    expect_usage_error(canorb("call --timeout 0s " + motor + "_interface"),
                       "--timeout takes a time");
    expect_usage_error(canorb("nodes --node 31"), "'31' is no node id");
    expect_usage_error(canorb("show 30"), "30 is the number that this program takes itself");
    expect_usage_error(canorb("watch 32"), "'32' is no group");
    expect_usage_error(canorb("nodes --bus nowhere"), "nowhere");
    expect_usage_error(canorb(""), "subcommand");
}

TEST_F(Console, TakesTheCompilersJson) {
    const std::string json = directory_.path() + "/things.json";
    ASSERT_EQ(shell(CANORB_IDLC " --emit json " + idl + " > " + json).exit_code, 0);
    EXPECT_EQ(canorb("call --idl-json " + json + ' ' + motor + "limit").output, "0.5\n");
}

TEST_F(Console, ListsNodes) {
    const ShellResult list = canorb("nodes --timeout 2s");
    EXPECT_EQ(list.exit_code, 0);
    EXPECT_THAT(list.output, HasSubstr("NODE  NAME    VENDOR"));
    EXPECT_THAT(
        list.output,
        testing::ContainsRegex("3     pump-3  Acme    P.u009B7  66      1.2.3    .*error active"));
    EXPECT_THAT(list.output, testing::ContainsRegex("7     node-7  -       -"));
    const auto json = json_of(canorb("nodes --json --timeout 2s --node 29"))["nodes"];
    ASSERT_EQ(json.size(), 2U);
    EXPECT_EQ(json[0]["node"], 3);
    EXPECT_EQ(json[0]["serial"], 66);
    EXPECT_EQ(json[1]["name"], "node-7");
}

TEST_F(Console, ShowsOneNode) {
    const ShellResult shown = canorb("show 3");
    EXPECT_EQ(shown.exit_code, 0);
    EXPECT_THAT(shown.output, HasSubstr("vendor      Acme\n"));
    EXPECT_THAT(shown.output,
                testing::ContainsRegex("1       IDL:Things/Motor:1.0  [0-9A-F]{8}\n"));
    EXPECT_THAT(shown.output, HasSubstr("5      1        IDL:Things/Motor:1.0\n"));
    const auto json = json_of(canorb("show --json 3"));
    EXPECT_EQ(json["objects"][1]["type_id"], "IDL:Things/Motor:1.0");
    EXPECT_EQ(json["groups"][0]["objects"][0], 1);
    const ShellResult nobody = canorb("show 9 --timeout 20ms");
    EXPECT_THAT(nobody.output, HasSubstr("TIMEOUT"));
    EXPECT_EQ(nobody.exit_code, 1);
}

TEST_F(Console, ShowsGroups) {
    EXPECT_EQ(canorb("groups --timeout 2s").output,
              "GROUP  NODE  OBJECTS  INTERFACE\n5      3     1        IDL:Things/Motor:1.0\n");
    const auto json = json_of(canorb("groups --json --timeout 2s"))["groups"];
    EXPECT_EQ(json[0]["group"], 5);
    EXPECT_EQ(json[0]["members"][0]["node"], 3);
}

TEST_F(Console, ListsEveryMemberOfALargeGroup) {
    std::vector<std::unique_ptr<Motor>> motors;
    for (int i = 0; i < 40; ++i) {
        motors.push_back(std::make_unique<Motor>());
        orb_->object_join(orb_->root_poa().activate_object(*motors.back()), GroupId{6});
    }
    const auto json = json_of(canorb("groups --json --timeout 2s"))["groups"];
    ASSERT_EQ(json.size(), 2U);
    EXPECT_EQ(json[1]["members"][0]["objects"].size(), 40U);
    EXPECT_EQ(json_of(canorb("show --json 3"))["objects"].size(), 42U);
    // The servants go before the node does.
    for (int i = 0; i < 40; ++i) {
        orb_->root_poa().deactivate_object(static_cast<ObjectIndex>(first_system_index + i));
    }
}

TEST_F(Console, PrintsCounters) {
    const ShellResult text = canorb("counters 3");
    EXPECT_EQ(text.exit_code, 0);
    EXPECT_THAT(text.output, testing::ContainsRegex("frames_received +[1-9]"));
    const auto json = json_of(canorb("counters --json 3"));
    EXPECT_GT(json["messages_received"], 0);
    EXPECT_EQ(json.size(), counter_count);
}

TEST_F(Console, RestartsANodeThatAllowsIt) {
    const ShellResult refused = canorb("restart 3");
    EXPECT_THAT(refused.output, AllOf(HasSubstr("node 3 does not restart when others ask it to"),
                                      HasSubstr("NO_PERMISSION")));
    EXPECT_EQ(refused.exit_code, 1);
    std::promise<void> restarted;
    orb_->on_restart([&] { restarted.set_value(); });
    EXPECT_EQ(canorb("restart 3").output, "node 3 restarts\n");
    EXPECT_EQ(restarted.get_future().wait_for(20s), std::future_status::ready);
}

TEST_F(Console, WatchesAGroup) {
    test::Child watcher{
        {CANORB_CONSOLE, "watch", "--bus", address(), "--idl", idl, "--count", "4", "5"}};
    ASSERT_TRUE(watcher.says("watching group 5"));
    const auto lamps =
        orb_->string_to_object("corbaloc:caniop:group/5").unchecked_narrow<Things::Lamp>();
    const std::string why(30, 'x');  // several frames
    lamps.ring(7, why);
    lamps.note("two");
    EXPECT_TRUE(watcher.says("node 3 Things::Lamp.ring(times: 7, why: \"" + why + "\")\n"));
    EXPECT_TRUE(watcher.says("node 3 Things::Lamp.note(text: \"two\")\n"));
    const auto from_seven = idle_->string_to_object("corbaloc:caniop:group/5");
    const std::vector<std::uint8_t> octets{0xAB};
    from_seven.invoke(99, octets);
    from_seven.unchecked_narrow<Things::Motor>().limit(1.5F);
    EXPECT_TRUE(watcher.says("node 7 interface 0000, operation 99: octets AB\n"));
    EXPECT_TRUE(watcher.says("node 7 Things::Motor._set_limit(value: 1.5)\n"));
    EXPECT_EQ(watcher.wait(), 0);
}

TEST_F(Console, WatchesUntilCtrlCOrItsTime) {
    test::Child watcher{{CANORB_CONSOLE, "watch", "--json", "--bus", address(), "5"}};
    ASSERT_TRUE(watcher.says("watching group 5"));
    const std::vector<std::uint8_t> octets{1};
    idle_->string_to_object("corbaloc:caniop:group/5").invoke(0, octets);
    ASSERT_TRUE(watcher.says("\"octets\":\"01\"}\n"));
    watcher.send_signal(SIGINT);
    EXPECT_EQ(watcher.wait(), 0);
    EXPECT_EQ(canorb("watch --seconds 10ms 5").exit_code, 0);
}

TEST_F(Console, EndsACallAtOnceOnCtrlC) {
    test::Child caller{{CANORB_CONSOLE, "call", "--bus", address(), "--timeout", "1000s",
                        "corbaloc:caniop:9/1", "_interface"},
                       test::Child::Input::terminal};
    ASSERT_TRUE(caller.says("Ctrl-C ends it"));
    caller.send_signal(SIGINT);
    EXPECT_EQ(caller.wait(), 130);
    EXPECT_THAT(caller.text(), Not(HasSubstr("BAD_INV_ORDER")));
}

TEST_F(Console, SaysThatTheBusWent) {
    test::Child caller{{CANORB_CONSOLE, "call", "--bus", address(), "--timeout", "1000s",
                        "corbaloc:caniop:9/1", "_interface"},
                       test::Child::Input::terminal};
    test::Child watcher{{CANORB_CONSOLE, "watch", "--bus", address(), "5"}};
    ASSERT_TRUE(caller.says("Ctrl-C ends it"));
    ASSERT_TRUE(watcher.says("watching group 5"));
    server_.reset();
    EXPECT_EQ(caller.wait(), 3);
    EXPECT_THAT(caller.text(), HasSubstr("COMM_FAILURE"));
    EXPECT_EQ(watcher.wait(), 3);
    EXPECT_THAT(watcher.text(), HasSubstr("the bus is gone"));
}

TEST_F(Console, SaysThatItsNumberIsTaken) {
    OrbOptions options;
    options.node = 30;
    options.log = [](std::string_view) {};
    Orb other{*bus_, options};
    std::atomic<bool> done = false;
    std::thread chatter{[&] {
        const auto pump = other.string_to_object("corbaloc:caniop:3/1");
        while (!done) {
            try {
                pump._interface_id();
            } catch (const SystemException&) {
            }
        }
    }};
    EXPECT_THAT(canorb("call --timeout 300ms corbaloc:caniop:9/1 _interface").output,
                HasSubstr("another node has the number 30"));
    done = true;
    chatter.join();
}

TEST(ConsoleWithoutABus, SaysHowToStartOne) {
    const can::test::TemporaryDirectory directory;
    const std::string bus = "--bus sim:" + directory.path() + "/bus ";
    for (const std::string& command :
         {"nodes " + bus, "watch " + bus + "5", "call " + bus + "corbaloc:caniop:3/1 _interface"}) {
        const ShellResult result = shell(CANORB_CONSOLE " " + command + " 2>&1");
        EXPECT_THAT(result.output, HasSubstr("start one with: canorb-bus --listen sim:"));
        EXPECT_EQ(result.exit_code, 3);
    }
}

TEST(ConsoleWithoutABus, TellsWhatItIs) {
    EXPECT_THAT(shell(CANORB_CONSOLE " --version").output, testing::StartsWith("canorb 0."));
    const ShellResult help = shell(CANORB_CONSOLE " --help");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.output, AllOf(HasSubstr("restart"), HasSubstr("Exit codes")));
    EXPECT_THAT(shell(CANORB_CONSOLE " call --help").output, HasSubstr("Examples:"));
}

}  // namespace
}  // namespace canorb::console
