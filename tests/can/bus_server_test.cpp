// The daemon, its socket file, and clients that misbehave.

#include "orb/can/link/bus_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "orb/can/link/sim_link.hpp"
#include "orb/can/sim/fault_injector.hpp"
#include "orb/can/sim/fault_script.hpp"
#include "tests/can/bus_server_fixture.hpp"
#include "tests/support/octets.hpp"

namespace canorb::can::test {

namespace {

using namespace std::chrono_literals;
using canorb::test::octets;
using testing::HasSubstr;

sim::SendRequest send_request(std::uint64_t handle) {
    return {monotonic_now(), TransmitHandle{handle}, {}, Frame::standard(0x300, {})};
}

class BusServerSocket : public BusServerTest {};

TEST_F(BusServerSocket, IsRemovedAtTheEnd) {
    start();
    EXPECT_TRUE(std::filesystem::exists(path()));
    server_.reset();
    EXPECT_FALSE(std::filesystem::exists(path()));
}

TEST_F(BusServerSocket, OfALiveDaemonIsNotTakenOver) {
    start();
    const auto second = BusServer::open(options());
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error(), "a bus is already running at " + address());
    expect_working_bus();
}

TEST_F(BusServerSocket, OfADeadDaemonIsReplaced) {
    ASSERT_TRUE(listen_at(path()));  // closed at once; the file stays
    ASSERT_TRUE(std::filesystem::exists(path()));
    start();
    expect_working_bus();
}

TEST_F(BusServerSocket, DoesNotReplaceAnotherKindOfFile) {
    std::ofstream{path()} << "precious";
    const auto server = BusServer::open(options());
    ASSERT_FALSE(server);
    EXPECT_EQ(server.error(), path() + " exists and is not a socket");
    EXPECT_TRUE(std::filesystem::exists(path()));
}

TEST_F(BusServerSocket, IsPrivateToItsUser) {
    const mode_t before = ::umask(0);
    start();
    ::umask(before);
    struct stat status{};
    ASSERT_EQ(::stat(path().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777U, 0600U);
}

TEST_F(BusServerSocket, NeedsItsDirectory) {
    BusServerOptions nowhere = options();
    nowhere.path = directory_.path() + "/missing/bus";
    const auto server = BusServer::open(nowhere);
    ASSERT_FALSE(server);
    EXPECT_THAT(server.error(), HasSubstr("its directory does not exist"));
}

TEST_F(BusServerSocket, ThatIsAnothersByNowStays) {
    start();
    std::filesystem::remove(path());
    const auto other = listen_at(path());
    server_.reset();
    EXPECT_TRUE(std::filesystem::exists(path()));
}

TEST_F(BusServerTest, MayBeStoppedBeforeItRuns) {
    auto server = BusServer::open(options());
    ASSERT_TRUE(server);
    (*server)->stop();
    EXPECT_EQ((*server)->run(), "");
}

TEST_F(BusServerTest, RefusesAnotherVersionAndSaysWhy) {
    start();
    RawClient client{path()};
    sim::Hello hello;
    hello.version = 2;
    client.say(hello);
    const auto answer = client.hear();
    ASSERT_TRUE(answer && std::holds_alternative<sim::Refusal>(*answer));
    EXPECT_EQ(std::get<sim::Refusal>(*answer).version, sim::protocol_version);
    EXPECT_EQ(std::get<sim::Refusal>(*answer).reason,
              "this bus speaks version 1 of its protocol, the client version 2");
    client.expect_disconnection();
    EXPECT_THAT(server_->log(), HasSubstr("refused a client"));
    expect_working_bus();
}

TEST_F(BusServerTest, RefusesMoreClientsThanItMayHave) {
    BusServerOptions few = options();
    few.max_clients = 2;
    start(few);
    const auto first = attach();
    auto second = attach();
    const auto link = open_link(address());
    ASSERT_FALSE(link);
    EXPECT_THAT(link.error(), HasSubstr("refused: the bus has its 2 clients already"));
}

TEST_F(BusServerTest, DisconnectsWhoSendsGarbage) {
    start();
    for (const std::string_view garbage :
         {"00", "FFFFFFFF", "83 0102030405060708 00000461 01 42", "474554202F20485454502F312E31"}) {
        RawClient stranger{path()};
        stranger.say(octets(garbage));
        stranger.expect_disconnection();
        RawClient client{path()};
        client.enter();
        client.say(octets(garbage));
        client.expect_disconnection();
    }
    RawClient huge{path()};
    huge.enter();
    huge.say(std::vector<std::uint8_t>(sim::max_packet_size + 1, 0x02));
    huge.expect_disconnection();
    EXPECT_THAT(server_->log(), HasSubstr("sent a packet that is none of the protocol's"));
    expect_working_bus();
}

TEST_F(BusServerTest, DisconnectsWhoDoesNotSayHelloFirst) {
    start();
    RawClient client{path()};
    client.say(send_request(1));
    client.expect_disconnection();
    expect_working_bus();
}

TEST_F(BusServerTest, DisconnectsWhoSaysHelloTwice) {
    start();
    RawClient client{path()};
    client.enter();
    client.say(sim::Hello{});
    client.expect_disconnection();
    expect_working_bus();
}

TEST_F(BusServerTest, DisconnectsWhoSendsMoreThanItsMailboxesHold) {
    start();
    RawClient client{path()};
    client.enter();  // alone: nothing is acknowledged
    for (std::uint64_t i = 0; i < 9; ++i) client.say(send_request(i));
    client.expect_disconnection();
    EXPECT_THAT(server_->log(), HasSubstr("more frames than it has mailboxes"));
    expect_working_bus();
}

TEST_F(BusServerTest, DisconnectsWhoSetsTooManyFilters) {
    start();
    RawClient client{path()};
    client.enter();
    client.say(sim::FilterRequest{monotonic_now(), std::vector<Filter>(33)});
    client.expect_disconnection();
    expect_working_bus();
}

TEST_F(BusServerTest, AFloodHarmsNobodyElse) {
    for (const bool paced : {true, false}) {
        start(options(paced));
        const auto bystander = attach();
        RawClient flooder{path()};
        flooder.enter();
        SendOutcome outcome = SendOutcome::sent;
        for (std::uint64_t i = 0; i < 100'000 && outcome != SendOutcome::gone; ++i) {
            outcome = flooder.say(send_request(i));
        }
        EXPECT_EQ(outcome, SendOutcome::gone);
        expect_working_bus();
        server_.reset();
    }
}

TEST_F(BusServerTest, WhoDoesNotReadLosesFramesAndIsTold) {
    for (const bool paced : {true, false}) {
        start(options(paced));
        RawClient deaf{path()};
        deaf.enter();
        deaf.say(sim::FilterRequest{monotonic_now(), {Filter{}}});
        const auto sender = attach();
        const auto receiver = attach();
        constexpr std::size_t total = 3000;
        std::size_t sent = 0;
        for (std::size_t received = 0; received < total; ++received) {
            while (sent < total && std::holds_alternative<TransmitHandle>(
                                       sender->send(Frame::standard(0x100, {})))) {
                ++sent;
            }
            ASSERT_TRUE(next<Received>(*receiver));
            while (sender->poll()) {
            }
        }
        std::uint64_t lost = 0;
        std::size_t heard = 0;
        while (heard + lost < total) {
            const auto packet = deaf.hear();
            ASSERT_TRUE(packet);
            if (std::holds_alternative<Received>(*packet)) ++heard;
            if (const auto* loss = std::get_if<FramesLost>(&*packet)) lost += loss->count;
        }
        EXPECT_GT(lost, 0U);
        EXPECT_EQ(heard + lost, total);
        server_.reset();
    }
}

TEST_F(BusServerTest, AnUnpacedBusWaitsForReadersThatAreALittleSlow) {
    start(options(false));
    const auto sender = attach();
    const auto receiver = attach();
    constexpr std::size_t total = 20'000;
    std::thread sending{[&] {
        for (std::size_t sent = 0; sent < total;) {
            if (std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x100, {})))) {
                ++sent;
            } else {
                readable(sender->event_fd());
                while (sender->poll()) {
                }
            }
        }
    }};
    std::size_t received = 0;
    std::uint64_t lost = 0;
    while (received + lost < total && readable(receiver->event_fd())) {
        while (const auto event = receiver->poll()) {
            if (std::holds_alternative<Received>(*event)) ++received;
            if (const auto* loss = std::get_if<FramesLost>(&*event)) lost += loss->count;
        }
    }
    sending.join();
    EXPECT_EQ(received + lost, total);
    EXPECT_LT(lost, total / 2);  // 0, unless this thread got no processor for 100 ms
}

TEST_F(BusServerTest, SilentConnectionsKeepNobodyOut) {
    BusServerOptions few = options();
    few.max_clients = 4;
    start(few);
    std::vector<std::unique_ptr<RawClient>> silent;
    for (int i = 0; i < 20; ++i) silent.push_back(std::make_unique<RawClient>(path()));
    expect_working_bus();
}

TEST_F(BusServerTest, ADisconnectedClientLeavesNothingBehind) {
    start();
    const auto listener = attach();
    EXPECT_TRUE(listener->set_listen_only(true));
    {
        RawClient client{path()};
        client.enter();
        client.say(send_request(1));
    }
    ASSERT_TRUE(open_link(address()));  // answered after the daemon has seen the end
    // Had it become error passive by then, the listener may have heard its frame; the last one was
    // on the bus when it went.
    const TimePoint gone = monotonic_now() + 1ms;
    EXPECT_TRUE(listener->set_listen_only(false));
    const auto sender = attach();
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x7EF, {}))));
    std::optional<Received> received;
    do {
        received = next<Received>(*listener);
        ASSERT_TRUE(received);
        if (received->frame.id != 0x7EF) {
            EXPECT_LE(received->time, gone);
        }
    } while (received->frame.id != 0x7EF);
}

TEST_F(BusServerTest, TimesInTheFutureOrThePastGainNothing) {
    start();
    const auto receiver = attach();
    RawClient client{path()};
    client.enter();
    const TimePoint before = monotonic_now();
    for (const TimePoint lie : {TimePoint::max(), TimePoint::min(), TimePoint{}}) {
        sim::SendRequest request = send_request(1);
        request.time = lie;
        client.say(request);
        const auto received = next<Received>(*receiver);
        ASSERT_TRUE(received);
        EXPECT_GT(received->time, before);
        EXPECT_LE(received->time, monotonic_now());
        while (const auto packet = client.hear()) {
            if (std::holds_alternative<TransmitResult>(*packet)) break;
        }
    }
}

TEST_F(BusServerTest, TellsAClientTheStatus) {
    start();
    const auto first = attach("pump-3");
    const auto second = attach("valve");
    RawClient client{path()};
    client.say(sim::Hello{.wish = sim::Hello::Wish::status, .client_name = "asks"});
    const auto welcome = client.hear();
    ASSERT_TRUE(welcome && std::holds_alternative<sim::Welcome>(*welcome));
    const auto bus = client.hear();
    ASSERT_TRUE(bus && std::holds_alternative<sim::BusStatus>(*bus));
    EXPECT_EQ(std::get<sim::BusStatus>(*bus).nodes, 2);
    EXPECT_GT(std::get<sim::BusStatus>(*bus).bits, 0U);
    for (const char* const name : {"pump-3", "valve"}) {
        const auto node = client.hear();
        ASSERT_TRUE(node && std::holds_alternative<sim::NodeStatus>(*node));
        EXPECT_EQ(std::get<sim::NodeStatus>(*node).name, name);
        EXPECT_EQ(std::get<sim::NodeStatus>(*node).status, ErrorStatus{});
    }
    client.expect_disconnection();
}

TEST_F(BusServerTest, ReportsWhatItsNodesDid) {
    start();
    const auto sender = attach("sender");
    const auto receiver = attach("receiver");
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x123, {}))));
    ASSERT_TRUE(next<TransmitResult>(*sender));
    const auto report = request_bus_report(SimAddress{path()});
    ASSERT_TRUE(report) << report.error().reason;
    EXPECT_EQ(report->bitrate, 500'000U);
    EXPECT_EQ(report->bus.frames, 1U);
    EXPECT_GE(report->bus.busy_bits, 44U);
    EXPECT_EQ(report->bus.recent_bits, std::min<std::uint64_t>(report->bus.bits, 500'000));
    ASSERT_EQ(report->nodes.size(), 2U);
    EXPECT_EQ(report->nodes[0].sent, 1U);
    EXPECT_EQ(report->nodes[1].received, 1U);
}

TEST_F(BusServerTest, ReportsAsManyNodesAsThereMayBe) {
    start();
    std::vector<std::unique_ptr<RawClient>> clients;
    for (int i = 0; i < 128; ++i) {
        clients.push_back(std::make_unique<RawClient>(path()));
        clients.back()->enter();
    }
    EXPECT_FALSE(open_link(address()));
    const auto report = request_bus_report(SimAddress{path()});
    ASSERT_TRUE(report) << report.error().reason;
    EXPECT_EQ(report->nodes.size(), 128U);
}

TEST_F(BusServerTest, AReportNeedsABus) {
    const auto report = request_bus_report(SimAddress{path()});
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().reason, HasSubstr("no bus at " + address()));
    EXPECT_TRUE(report.error().nobody_listens);
}

/// Whoever watches the bits takes a hundred times as long as they do.
class SlowObserver final : public sim::BitObserver {
  public:
    void node_attached(sim::NodeIndex, std::string_view) override {}
    void node_detached(sim::NodeIndex) override {}
    void bit(const sim::BusBit&) override {
        const TimePoint end = monotonic_now() + 100us;
        while (monotonic_now() < end) continue;
    }
};

TEST_F(BusServerTest, ServesEverybodyOnABusThatCannotKeepUp) {
    SlowObserver slow;
    BusServerOptions fast = options();
    fast.bitrate = 1'000'000;
    // Who is cut off repeats its frame for ever: there is something to do in each bit.
    std::optional<sim::FaultInjector> injector;
    start(fast, [&](sim::Bus& bus) {
        injector.emplace(*sim::parse_fault_script("at 0s cut-off lonely"), fast.bitrate, bus.now());
        bus.set_disturbance(&*injector);
        bus.set_bit_observer(&slow);
    });
    const auto lonely = attach("lonely");
    const auto sender = attach();
    const auto receiver = attach();
    ASSERT_TRUE(lonely && sender && receiver);
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(lonely->send(Frame::standard(1, {}))));
    TimePoint last{};
    // A frame is 55 us long, and takes 5 ms of the machine's time.
    const TimePoint end = monotonic_now() + 2500ms;
    while (monotonic_now() < end) {
        while (std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(1, {})))) {
        }
        const auto report = request_bus_report(SimAddress{path()});
        ASSERT_TRUE(report) << report.error().reason;
        EXPECT_EQ(report->nodes.size(), 3U);
        EXPECT_LE(report->bus.time, monotonic_now());
        const auto received = next<Received>(*receiver);
        ASSERT_TRUE(received);
        EXPECT_LE(received->time, monotonic_now());
        EXPECT_GT(received->time, last);
        last = received->time;
        while (sender->poll()) {
        }
    }
    EXPECT_THAT(server_->log(), HasSubstr("the bus cannot keep up with the clock: it has slipped"));
    server_.reset();  // and it can be stopped
}

TEST_F(BusServerTest, ReportsAtItsEnd) {
    std::vector<BusReport> reports;
    BusServerOptions with = options();
    with.report = [&](const BusReport& report) { reports.push_back(report); };
    start(with);
    const auto client = attach("pump-3");
    server_.reset();
    ASSERT_FALSE(reports.empty());
    ASSERT_EQ(reports.back().nodes.size(), 1U);
    EXPECT_EQ(reports.back().nodes[0].name, "pump-3");
}

/// Which numbers nodes have had.
class HighestNode : public sim::BitObserver {
  public:
    void node_attached(sim::NodeIndex node, std::string_view) override {
        ++attached_;
        highest_ = std::max(highest_, static_cast<std::size_t>(node));
    }
    void node_detached(sim::NodeIndex) override { --attached_; }
    void bit(const sim::BusBit&) override {}

    std::size_t highest() const { return highest_; }
    int attached() const { return attached_; }

  private:
    std::size_t highest_ = 0;
    int attached_ = 0;
};

std::size_t open_descriptors() {
    const std::filesystem::directory_iterator directory{"/proc/self/fd"};
    return static_cast<std::size_t>(std::distance(begin(directory), end(directory)));
}

TEST_F(BusServerTest, AThousandClientsThatGoLeaveNothingBehind) {
    HighestNode nodes;
    start(options(), [&](sim::Bus& bus) { bus.set_bit_observer(&nodes); });
    const std::size_t before = open_descriptors();
    for (int i = 0; i < 1000; ++i) {
        RawClient client{path()};
        if (i % 4 == 1) continue;  // goes without a word
        client.enter();
        client.say(send_request(1));
        if (i % 4 == 2) client.say(octets("FF"));  // is thrown out
        // With its frame on the bus, or about to be.
    }
    expect_working_bus();
    // The daemon closes its ends as soon as it gets to it.
    const auto patience = std::chrono::steady_clock::now() + std::chrono::milliseconds{patience_ms};
    while (open_descriptors() != before && std::chrono::steady_clock::now() < patience) {
        std::this_thread::yield();
    }
    EXPECT_EQ(open_descriptors(), before);
    const auto report = request_bus_report(SimAddress{path()});
    ASSERT_TRUE(report) << report.error().reason;
    EXPECT_TRUE(report->nodes.empty());
    server_.reset();
    EXPECT_EQ(nodes.attached(), 0);
    EXPECT_LT(nodes.highest(), 20U);
}

TEST_F(BusServerTest, NodesHaveTheirClientsNames) {
    std::mutex mutex;
    std::string sender;
    start(options(), [&](sim::Bus& bus) {
        bus.set_trace([&](const sim::CompletedFrame& completed) {
            const std::lock_guard lock{mutex};
            sender = bus.name(completed.sender);
        });
    });
    expect_working_bus();
    const std::lock_guard lock{mutex};
    EXPECT_EQ(sender, "good sender");
}

TEST_F(BusServerTest, LogsWhoComesAndGoes) {
    start();
    attach("pump-3");
    expect_working_bus();
    EXPECT_THAT(server_->log(), HasSubstr("client \"pump-3\" (process "));
    EXPECT_THAT(server_->log(), HasSubstr(") connected"));
    EXPECT_THAT(server_->log(), HasSubstr(") disconnected"));
}

TEST_F(BusServerTest, TracesFrames) {
    std::mutex mutex;
    std::vector<Frame> frames;
    start(options(false), [&](sim::Bus& bus) {
        bus.set_trace([&](const sim::CompletedFrame& completed) {
            const std::lock_guard lock{mutex};
            frames.push_back(completed.frame);
        });
    });
    expect_working_bus();
    const std::lock_guard lock{mutex};
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].id, 0x7A5U);
}

}  // namespace
}  // namespace canorb::can::test
