// The Orb on the bus of a daemon that goes away and comes back.

#include <future>
#include <thread>

#include "orb/can/link/bus_server.hpp"
#include "tests/can/temporary_directory.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Daemon {
  public:
    explicit Daemon(const std::string& path) {
        can::BusServerOptions options;
        options.path = path;
        options.paced = false;
        auto opened = can::BusServer::open(options);
        if (!opened) throw std::runtime_error{opened.error()};
        server_ = std::move(*opened);
        thread_ = std::thread{[this] { server_->run(); }};
    }
    ~Daemon() {
        server_->stop();
        thread_.join();
    }
    Daemon(const Daemon&) = delete;
    Daemon& operator=(const Daemon&) = delete;

  private:
    std::unique_ptr<can::BusServer> server_;
    std::thread thread_;
};

class OverDaemon : public testing::Test {
  protected:
    OrbOptions node(int number) {
        OrbOptions options;
        options.node = number;
        options.default_timeout = 20s;
        options.inter_frame_timeout = 10s;  // threads may be kept waiting on a busy machine
        options.log = [](std::string_view) {};
        return options;
    }
    static ObjectRef object(Orb& orb) { return orb.string_to_object("corbaloc:caniop:1/1"); }

    can::test::TemporaryDirectory directory;
    std::string path = directory.path() + "/bus";
    std::unique_ptr<Daemon> daemon = std::make_unique<Daemon>(path);
};

TEST_F(OverDaemon, CallsWork) {
    const auto bus = open_bus("sim:" + path);
    Orb server{*bus, node(1)};
    TestServant servant{{{1, echo}}};
    server.root_poa().activate_object_with_id(1, servant);
    std::thread loop{[&] { server.run(); }};
    Orb client{*bus, node(2)};
    const std::vector<std::uint8_t> octets(300, 7);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(object(client).invoke(1, octets), octets);
    server.shutdown();
    loop.join();
}

TEST_F(OverDaemon, ThatGoesFailsCallsAndComesBack) {
    const auto bus = open_bus("sim:" + path);
    Orb server{*bus, node(1)};
    TestServant servant{{{0, nothing}}};
    server.root_poa().activate_object_with_id(1, servant);
    Orb client{*bus, node(2)};
    std::vector<std::string> events;
    bool up = false;
    const auto note = [&](const Event& event) {
        events.push_back(event.text);
        up = event.text.find("error active") != std::string::npos;
    };
    client.on_event(note);

    // Nobody runs the server's loop: the call is out there when the daemon goes.
    std::thread killer;
    const ObjectRef target =
        object(client).with_sent([&] { killer = std::thread{[&] { daemon.reset(); }}; });
    EXPECT_EQ(error_of([&] { target.invoke(0, {}); }),
              (SystemError{SystemErrorKind::comm_failure, Completion::maybe, 6}));
    killer.join();
    // Whoever calls while the link is down learns it at once.
    EXPECT_EQ(error_of([&] { object(client).invoke(0, {}); }),
              (SystemError{SystemErrorKind::comm_failure, Completion::no, 4}));
    EXPECT_THROW(call_through(object(client), ring_oneway), COMM_FAILURE);
    client.poll();
    ASSERT_EQ(events.size(), 1U);
    EXPECT_THAT(events[0], testing::HasSubstr("node-2: the CAN controller is stopped"));
    EXPECT_EQ(client.error_status().state, can::ControllerState::stopped);
    EXPECT_THROW(open_bus("sim:" + path), COMM_FAILURE);
    EXPECT_THROW(Orb(*bus, node(3)), COMM_FAILURE);

    daemon = std::make_unique<Daemon>(path);
    while (server.error_status().state != can::ControllerState::stopped) server.poll();
    server.poll();  // the call that nobody waits for any more
    servant.calls = 0;
    client.recover();
    server.recover();
    std::promise<void> server_up;
    server.on_event([&](const Event& event) {
        if (event.text.find("error active") != std::string::npos) server_up.set_value();
    });
    std::thread loop{[&] { server.run(); }};
    server_up.get_future().wait();
    while (!up) client.run_for(1ms);
    object(client).invoke(0, {});
    EXPECT_EQ(servant.calls, 1);
    server.shutdown();
    loop.join();
}

TEST_F(OverDaemon, SocketCanIsNotThereYet) {
    EXPECT_THAT(what<COMM_FAILURE>([] { open_bus("socketcan:can0"); }),
                testing::HasSubstr("socketcan:can0: "));
}

}  // namespace
}  // namespace canorb::test
