// The calls of threads_test.cpp in one thread on virtual time, where a deadline is a moment: no
// call ends after it. Every run is the same.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "canorb/simulation.hpp"
#include "orb/can/sim/fault_injector.hpp"
#include "orb/runtime/simulation_impl.hpp"
#include "tests/stress/peers.hpp"
#include "tests/support/soak.hpp"

namespace canorb::test::stress {
namespace {

/// Calls are nested in each other, where timers and servants make them while another one waits. As
/// the outer one returns after the inner one, an inner one gets no more time than the outer one
/// has.
class VirtualRun final : public Run {
  public:
    VirtualRun(std::size_t calls, const Simulation& simulation)
        : Run(calls), simulation_(simulation) {}

    Duration longest(Duration timeout, bool) const override { return timeout; }
    Duration shortened(Duration timeout) const override {
        if (deadlines_.empty()) return timeout;
        return std::min(timeout, deadlines_.back() - simulation_.now());
    }
    void begin_call(TimePoint deadline) override {
        deadlines_.push_back(deadline);
        deepest_ = std::max(deepest_, deadlines_.size());
    }
    void end_call() override { deadlines_.pop_back(); }

    std::size_t deepest() const { return deepest_; }

  private:
    const Simulation& simulation_;
    std::vector<TimePoint> deadlines_;  ///< of the calls on the stack
    std::size_t deepest_ = 0;
};

/// A whole run; its result tells two runs apart.
class VirtualTime : public testing::Test {
  protected:
    struct Summary {
        std::uint64_t right = 0;
        std::map<std::string, std::uint64_t> counted;
        TimePoint end;
        friend bool operator==(const Summary&, const Summary&) = default;
    };

    static Summary run(std::uint32_t calls) {
        Simulation simulation;
        SimulatedBus& bus = simulation.add_bus({.bitrate = 1'000'000});
        can::sim::Bus& frames = simulation.impl().frames(0);
        can::sim::FaultInjector injector{*can::sim::parse_fault_script(fault_script(calls, 3)),
                                         frames.bitrate(), frames.now()};
        frames.set_disturbance(&injector);
        VirtualRun run{calls * 4 + 1000, simulation};
        std::vector<std::unique_ptr<Node>> nodes;
        Random random{1};
        for (int i = 1; i <= Node::nodes; ++i) {
            OrbOptions options;
            options.node = i;
            options.log = [](std::string_view) {};
            nodes.push_back(std::make_unique<Node>(run, bus, std::move(options)));
            Node& node = *nodes.back();
            node.orb().every(3ms * i, [&] { node.call_anyone(random, 20ms); });
        }
        while (run.ledger.size() < calls) {
            Node& node = *nodes[below(random, Node::nodes)];
            node.call_anyone(random, 60ms / (1 + below(random, 30)));
            if (node.orb().error_status().state == can::ControllerState::bus_off) {
                simulation.run_for(1ms);
            }
            show_progress("calls on virtual time", run.ledger.size(), calls);
        }
        simulation.run_for(100ms);

        EXPECT_THAT(run.complaints(), testing::IsEmpty());
        EXPECT_THAT(run.ledger.contradictions(), testing::IsEmpty());
        std::uint64_t bus_offs = 0;
        std::uint64_t duplicates = 0;
        for (const auto& node : nodes) {
            EXPECT_THAT(node->doors().contradictions(), testing::IsEmpty());
            bus_offs += node->bus_offs;
            duplicates += node->orb().counters()[Counter::duplicate_requests];
        }
        // Else it shows nothing.
        EXPECT_GT(run.right, run.ledger.size() / 2);
        EXPECT_GT(bus_offs, 0U);
        EXPECT_GT(duplicates, 0U);
        EXPECT_GT(run.deepest(), 4U);
        frames.set_disturbance(nullptr);
        return {run.right, run.counted(), simulation.now()};
    }
};

TEST_F(VirtualTime, NoCallOutlivesItsDeadlineByANanosecond) {
    const auto calls = static_cast<std::uint32_t>(5'000 * soak_factor());
    Summary summary = run(calls);
    for (const char* end :
         {"TIMEOUT MAYBE", "TIMEOUT NO", "COMM_FAILURE MAYBE", "COMM_FAILURE NO"}) {
        EXPECT_GT(summary.counted[end], 0U) << end;
    }
    std::printf("%llu right, until %lld ms\n", static_cast<unsigned long long>(summary.right),
                static_cast<long long>(summary.end.time_since_epoch() / 1ms));
    for (const auto& [what, times] : summary.counted) {
        std::printf("  %s: %llu\n", what.c_str(), static_cast<unsigned long long>(times));
    }
}

TEST_F(VirtualTime, IsTheSameEachTime) {
    EXPECT_EQ(run(1'000), run(1'000));
}

}  // namespace
}  // namespace canorb::test::stress
