// Eight threads call between four nodes, over the daemon's bus with random faults: every call
// returns a right answer or a documented exception in time, no answer reaches a wrong caller, and
// no call is executed twice, or at all when its caller was told that it was not.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "orb/can/link/bus_server.hpp"
#include "orb/can/sim/fault_injector.hpp"
#include "tests/can/temporary_directory.hpp"
#include "tests/stress/peers.hpp"
#include "tests/support/soak.hpp"

namespace canorb::test::stress {
namespace {

constexpr int caller_threads = 8;
constexpr int max_nesting = 8;
constexpr Duration longest_timeout = 150ms;
constexpr Duration wall_time_slack = 1s;

class ThreadedRun final : public Run {
  public:
    using Run::Run;
    Duration longest(Duration timeout, bool nested) const override {
        // A servant's call ends after those that are nested in it.
        return (nested ? longest_timeout * max_nesting : timeout) + wall_time_slack;
    }
};

/// The bus of a daemon, as fast as its clients are, with faults.
class FaultyDaemon {
  public:
    FaultyDaemon(const std::string& path, const std::string& script) {
        can::BusServerOptions options;
        options.path = path;
        options.paced = false;
        auto parsed = can::sim::parse_fault_script(script);
        if (!parsed) throw std::runtime_error{"the script is wrong"};
        auto opened = can::BusServer::open(options);
        if (!opened) throw std::runtime_error{opened.error()};
        server_ = std::move(*opened);
        can::sim::Bus& bus = server_->bus();
        injector_.emplace(std::move(*parsed), bus.bitrate(), bus.now());
        bus.set_disturbance(&*injector_);
        thread_ = std::thread{[this] { failure_ = server_->run(); }};
    }
    ~FaultyDaemon() { stop(); }
    FaultyDaemon(const FaultyDaemon&) = delete;
    FaultyDaemon& operator=(const FaultyDaemon&) = delete;

    /// Why it stopped before, or nothing.
    std::string stop() {
        server_->stop();
        if (thread_.joinable()) thread_.join();
        return failure_;
    }

    /// How often any fault began to act. After stop().
    std::uint64_t faults() const {
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < injector_->script().faults.size(); ++i) {
            sum += injector_->acted(i);
        }
        return sum;
    }

  private:
    std::unique_ptr<can::BusServer> server_;
    std::optional<can::sim::FaultInjector> injector_;
    std::thread thread_;
    std::string failure_;
};

/// Whose threads serve.
enum class Served : std::uint8_t {
    by_loops,    ///< each node's event loop has a thread
    by_callers,  ///< nobody but those who call
    by_workers,  ///< three threads of each Orb's own
};

OrbOptions options(int node, Served served) {
    OrbOptions options;
    options.node = node;
    options.default_timeout = longest_timeout;
    options.log = [](std::string_view) {};
    if (served == Served::by_workers) options.worker_threads = 3;
    return options;
}

std::uint64_t total(const std::vector<std::unique_ptr<Node>>& nodes, Counter counter) {
    std::uint64_t sum = 0;
    for (const auto& node : nodes) sum += node->orb().counters()[counter];
    return sum;
}

bool is_off(Node& node) {
    return node.orb().error_status().state == can::ControllerState::bus_off;
}

class Threads : public testing::TestWithParam<Served> {};

TEST_P(Threads, GetRightAnswersOrDocumentedExceptions) {
    const Served served = GetParam();
    const auto calls = static_cast<std::uint32_t>(2'000 * soak_factor());
    can::test::TemporaryDirectory directory;
    const std::string path = directory.path() + "/bus";
    FaultyDaemon daemon{path, fault_script(calls, 1 + static_cast<std::uint32_t>(served))};
    const auto bus = open_bus("sim:" + path);
    ThreadedRun run{calls * 4 + 1000};
    std::vector<std::unique_ptr<Node>> nodes;
    for (int i = 1; i <= Node::nodes; ++i) {
        nodes.push_back(std::make_unique<Node>(run, *bus, options(i, served)));
    }
    std::vector<std::thread> serving;
    if (served == Served::by_loops) {
        for (const auto& node : nodes) serving.emplace_back([&] { node->orb().run(); });
    }
    std::vector<std::thread> callers;
    std::atomic<int> calling = caller_threads;
    for (int t = 0; t < caller_threads; ++t) {
        callers.emplace_back([&, t] {
            Random random{static_cast<Random::result_type>(t + 1)};
            Node& node = *nodes[static_cast<std::size_t>(t) % nodes.size()];
            for (std::uint32_t i = 0; i < calls / caller_threads; ++i) {
                node.call_anyone(random, longest_timeout / (1 + below(random, 10)));
                // At bus-off every call would fail at once, until none are left.
                if (is_off(node)) node.orb().run_for(1ms);
                if (t == 0) show_progress("calls of each thread", i, calls / caller_threads);
            }
            --calling;
            // Others may still call this node.
            while (served == Served::by_callers && calling > 0) node.orb().run_for(1ms);
        });
    }
    for (std::thread& caller : callers) caller.join();
    // What is still on its way must not be executed too late or twice, either.
    for (const auto& node : nodes) node->orb().run_for(10ms);
    for (const auto& node : nodes) node->orb().shutdown();
    for (std::thread& thread : serving) thread.join();
    EXPECT_EQ(daemon.stop(), "");

    EXPECT_THAT(run.complaints(), testing::IsEmpty());
    EXPECT_THAT(run.ledger.contradictions(), testing::IsEmpty());
    for (const auto& node : nodes) EXPECT_THAT(node->doors().contradictions(), testing::IsEmpty());
    EXPECT_GE(run.ledger.size(), calls);
    // Else it shows nothing. A busy machine has more deadlines pass.
    EXPECT_GT(run.right, run.ledger.size() / 4);
    EXPECT_GT(daemon.faults(), calls / 100);
    std::uint64_t bus_offs = 0;
    for (const auto& node : nodes) bus_offs += node->bus_offs;
    // What is rare need not come in a short run, whose threads are never timed alike.
    if (soak_factor() >= 10) {
        EXPECT_GT(total(nodes, Counter::duplicate_requests), 0U);
        EXPECT_GT(bus_offs, 0U);
    }
    std::printf("%zu calls, %llu right, %llu faults, %llu times bus-off\n", run.ledger.size(),
                static_cast<unsigned long long>(run.right),
                static_cast<unsigned long long>(daemon.faults()),
                static_cast<unsigned long long>(bus_offs));
    for (const auto& [what, times] : run.counted()) {
        std::printf("  %s: %llu\n", what.c_str(), static_cast<unsigned long long>(times));
    }
    for (std::size_t i = 0; i < counter_count; ++i) {
        const auto counter = static_cast<Counter>(i);
        if (const auto sum = total(nodes, counter)) {
            std::printf("  %s: %llu\n", std::string{name(counter)}.c_str(),
                        static_cast<unsigned long long>(sum));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(ServedByLoops, Threads, testing::Values(Served::by_loops));
INSTANTIATE_TEST_SUITE_P(ServedByCallers, Threads, testing::Values(Served::by_callers));
INSTANTIATE_TEST_SUITE_P(ServedByWorkers, Threads, testing::Values(Served::by_workers));

}  // namespace
}  // namespace canorb::test::stress
