// kill -9 of one of five processes that call each other, again and again: the others go on, calls
// to it fail with TIMEOUT or OBJECT_NOT_EXIST, and work again when it is back. On the machine's
// clock, since processes are what is tested.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "canorb/orb.hpp"
#include "siege.hpp"
#include "tests/can/bus_server_fixture.hpp"
#include "tests/stress/ledger.hpp"
#include "tests/support/child.hpp"
#include "tests/support/soak.hpp"

namespace canorb::test::stress {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int node_count = 5;
/// This program: answers to it win the arbitration.
constexpr int here = 0;
constexpr Duration patience = 20s;
/// Longer than a call of a node lasts that nobody answers.
constexpr auto aftermath = 4s;

class Siege : public testing::Test {
  protected:
    /// Holds up whoever enters until it is opened.
    class Gate final : public ::Siege::GateServant {
      public:
        void pass() override {
            entered.set_value();
            open.get_future().wait();
        }
        std::promise<void> entered;
        std::promise<void> open;
    };

    ~Siege() override {
        orb_->shutdown();
        if (loop_.joinable()) loop_.join();
    }

    /// A daemon, this program as node 0, and that many others, which call each other where
    /// `busy`.
    void start(int nodes, bool busy, can::BusServerOptions options,
               const can::test::RunningServer::SetUpBus& set_up = {}) {
        options.path = directory_.path() + "/bus";
        server_.emplace(std::move(options), set_up);
        bus_ = open_bus("sim:" + directory_.path() + "/bus");
        orb_.emplace(*bus_, OrbOptions{.node = here,
                                       .default_timeout = patience,
                                       .inter_frame_timeout = patience,
                                       .log = [](std::string_view) {}});
        loop_ = std::thread{[this] { orb_->run(); }};
        busy_ = busy ? nodes : 0;
        for (int node = 1; node <= nodes; ++node) bring(node);
        for (int node = 1; node <= nodes; ++node) await(node);
    }

    void bring(int node) {
        brought_[at(node)] = Clock::now();
        children_[at(node)] = std::make_unique<Child>(
            std::vector<std::string>{SIEGE_NODE, "sim:" + directory_.path() + "/bus",
                                     std::to_string(node), std::to_string(busy_)});
    }
    void kill(int node) {
        children_[at(node)]->send_signal(SIGKILL);
        bury(node);
    }
    void bury(int node) {
        EXPECT_EQ(children_[at(node)]->wait(), -SIGKILL) << children_[at(node)]->text();
    }

    /// TRANSIENT says that another try may work: a slow node has its calls nested too deep.
    template <typename Call>
    static auto until_not_transient(Call call) {
        const auto deadline = Clock::now() + patience;
        for (;;) {
            try {
                return call();
            } catch (const TRANSIENT&) {
                if (Clock::now() > deadline) throw;
            }
        }
    }

    void expect_answer(int node, Duration timeout = patience) {
        const Token token = ++token_;
        EXPECT_EQ(until_not_transient([&] { return peer(node, timeout).answer(token); }),
                  answer_to(token));
    }
    /// Calls until it answers.
    void await(int node) {
        const auto deadline = Clock::now() + patience;
        while (Clock::now() < deadline) {
            try {
                expect_answer(node, 50ms);
                return;
            } catch (const TIMEOUT&) {
                ++timeouts_;
            } catch (const OBJECT_NOT_EXIST&) {
                ++not_there_;
            }
        }
        FAIL() << "node " << node << " does not come back";
    }

    ::Siege::Peer peer(int node, Duration timeout = patience) {
        return orb_->string_to_object("corbaloc:caniop:" + std::to_string(node) + "/1")
            .with_timeout(timeout)
            .unchecked_narrow<::Siege::Peer>();
    }
    static std::size_t at(int node) { return static_cast<std::size_t>(node); }

    can::test::TemporaryDirectory directory_;
    Gate gate_;
    // What the bus looks at as long as it runs.
    std::array<std::unique_ptr<Child>, node_count + 1> children_;
    std::atomic<bool> armed_ = false;
    int frames_ = 0;
    std::optional<can::test::RunningServer> server_;
    std::unique_ptr<Bus> bus_;
    std::optional<Orb> orb_;
    std::thread loop_;
    int busy_ = 0;
    std::array<Clock::time_point, node_count + 1> brought_{};
    Token token_ = 0;
    int timeouts_ = 0;
    int not_there_ = 0;
};

TEST_F(Siege, TheOthersGoOn) {
    // 50 in ctest's run, 200 with CANORB_SOAK_FACTOR=4.
    const int kills = static_cast<int>(50 * soak_factor());
    can::BusServerOptions unpaced;
    unpaced.paced = false;
    start(node_count, true, unpaced);
    std::mt19937 random{1};
    std::array<std::array<std::uint32_t, node_count + 1>, node_count + 1> failed{};
    std::array<std::uint32_t, node_count + 1> answered{};
    std::uint32_t failed_to_the_living = 0;
    std::uint32_t all_answered = 0;

    /// Waits until the node has made more calls, and looks at how they ended. `anew`: it has just
    /// begun to count.
    const auto look = [&](int node, bool anew) {
        const auto deadline = Clock::now() + patience;
        std::uint32_t sum = 0;
        do {
            const ::Siege::Report report = until_not_transient([&] { return peer(node).look(); });
            EXPECT_EQ(report.complaint.view(), "") << "node " << node;
            sum = 0;
            for (int other = 1; other <= node_count; ++other) {
                sum += report.answered[at(other)];
                std::uint32_t& before = failed[at(node)][at(other)];
                const bool lived = Clock::now() - brought_[at(other)] > aftermath;
                // Not none: a call has two seconds of wall time, and a busy machine may take them.
                if (lived && !anew) failed_to_the_living += report.failed[at(other)] - before;
                before = report.failed[at(other)];
            }
        } while (!anew && sum <= answered[at(node)] && Clock::now() < deadline);
        if (!anew) {
            EXPECT_GT(sum, answered[at(node)]) << "node " << node << " stands still";
        }
        all_answered += anew ? sum : sum - answered[at(node)];
        answered[at(node)] = sum;
    };

    for (int i = 0; i < kills; ++i) {
        // Each node for a while, so that it can be seen that the others' calls do not fail.
        const int victim = 1 + i * node_count / kills;
        orb_->run_for(1us * (random() % 20'000));
        kill(victim);
        for (int other = 1; other <= node_count; ++other) {
            if (other != victim) expect_answer(other);
        }
        EXPECT_THROW(peer(victim, 10ms).answer(0), TIMEOUT);
        bring(victim);
        await(victim);
        for (int other = 1; other <= node_count; ++other) look(other, other == victim);
        if (HasFailure()) break;
        show_progress("kills", static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(kills));
    }
    EXPECT_LE(failed_to_the_living * 50, all_answered);
    std::printf(
        "%d kills; of our calls to those killed %d TIMEOUT, %d OBJECT_NOT_EXIST; of %u calls "
        "between those that lived %u failed\n",
        kills, timeouts_, not_there_, all_answered, failed_to_the_living);
}

class KilledInTheMiddle : public Siege {
  protected:
    static can::BusServerOptions slow() {
        can::BusServerOptions options;
        options.bitrate = 125'000;
        return options;
    }

    /// Kills node 1 with the 20th frame that has this identifier.
    void start_with_trap(std::uint32_t identifier) {
        // Node 2 acknowledges what goes to node 1 when that is gone.
        start(2, false, slow(), [this, identifier](can::sim::Bus& bus) {
            bus.set_trace([this, identifier](const can::sim::CompletedFrame& completed) {
                if (armed_ && completed.frame.id == identifier && ++frames_ == 20) {
                    children_[1]->send_signal(SIGKILL);
                }
            });
        });
        armed_ = true;
    }

    void expect_that_it_works_again() {
        armed_ = false;
        bury(1);
        bring(1);
        await(1);
        const ::Siege::Text text(400, 7);
        EXPECT_EQ(peer(1).reflect(text), text);
    }

    static bool ended_with_timeout_maybe(const std::function<void()>& call) {
        try {
            call();
        } catch (const TIMEOUT& timeout) {
            return timeout.completed() == Completion::maybe;
        }
        return false;
    }
};

TEST_F(KilledInTheMiddle, OfItsAnswer) {
    start_with_trap(0x401);  // from node 1 to node 0
    EXPECT_TRUE(ended_with_timeout_maybe([&] { peer(1, 500ms).reflect(::Siege::Text(400, 9)); }));
    expect_that_it_works_again();
    // The half of the answer that came.
    const Counters counters = orb_->counters();
    EXPECT_EQ(counters[Counter::interrupted_messages] + counters[Counter::reassembly_timeouts], 1U);
}

TEST_F(KilledInTheMiddle, OfARequestToIt) {
    start_with_trap(0x420);  // from node 0 to node 1
    EXPECT_TRUE(ended_with_timeout_maybe([&] { peer(1, 500ms).reflect(::Siege::Text(400, 9)); }));
    expect_that_it_works_again();
    EXPECT_EQ(orb_->counters()[Counter::messages_stopped], 0U);
}

TEST_F(KilledInTheMiddle, OfACallThatItServes) {
    start(1, false, slow());
    const auto way = orb_->root_poa().activate_object(gate_).narrow<::Siege::Gate>();
    auto call = std::async(std::launch::async, [&] {
        return ended_with_timeout_maybe([&] { peer(1, 500ms).enter(way); });
    });
    gate_.entered.get_future().wait();
    children_[1]->send_signal(SIGKILL);
    EXPECT_TRUE(call.get());
    gate_.open.set_value();
    expect_that_it_works_again();
}

TEST_F(KilledInTheMiddle, OfANestedCallThatItMakes) {
    start(2, false, slow());
    const auto way = orb_->root_poa().activate_object(gate_).narrow<::Siege::Gate>();
    auto call = std::async(std::launch::async, [&] {
        return ended_with_timeout_maybe([&] { peer(1, 500ms).send(2, way); });
    });
    gate_.entered.get_future().wait();
    children_[1]->send_signal(SIGKILL);
    EXPECT_TRUE(call.get());
    gate_.open.set_value();
    // Node 2 answers a node that is gone, and goes on.
    expect_answer(2);
    expect_that_it_works_again();
}

TEST_F(KilledInTheMiddle, OfANestedCallToIt) {
    start(2, false, slow());
    const auto way = orb_->root_poa().activate_object(gate_).narrow<::Siege::Gate>();
    auto call = std::async(std::launch::async, [&]() -> std::string {
        try {
            peer(2).send(1, way);
        } catch (const ::Siege::Broken& broken) {
            return std::string{broken.why.view()};
        }
        return "no exception";
    });
    gate_.entered.get_future().wait();
    children_[1]->send_signal(SIGKILL);
    EXPECT_EQ(call.get(), "IDL:omg.org/CORBA/TIMEOUT:1.0");
    gate_.open.set_value();
    expect_answer(2);
    expect_that_it_works_again();
}

}  // namespace
}  // namespace canorb::test::stress
