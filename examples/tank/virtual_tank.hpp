#pragma once

#include <canorb/orb.hpp>
#include <canorb/simulation.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "node_a.hpp"
#include "node_b.hpp"
#include "operator_line.hpp"
#include "plot.hpp"
#include "record.hpp"
#include "schedule.hpp"

namespace tank {

/// Bus, both nodes and the operator on a virtual clock: the same run every time. Times count from
/// its start, when node A has its first tick.
class VirtualTank {
  public:
    struct Options {
        std::uint32_t bitrate = 500'000;
        std::vector<ScheduledOrder> orders{};
        std::vector<ScheduledTemperature> temperatures{};
    };

    /// Each may be empty.
    struct Outputs {
        /// At the end of node B's slot 6.
        std::function<void(const RoundRecord&)> round{};
        /// Every frame, at its end.
        std::function<void(canorb::Duration, const canorb::can::Frame&)> frame{};
        /// Every 50 ms.
        std::function<void(const PlotSample&)> sample{};
        /// What the nodes, named "A" and "B", say.
        std::function<void(canorb::Duration, std::string_view node, std::string_view text)> log{};
        /// What the operator sees.
        std::function<void(std::string_view)> terminal{};
    };

    VirtualTank(Options options, Outputs outputs);
    ~VirtualTank();

    void run_until(canorb::Duration time);
    canorb::Duration now() const { return simulation_.now() - start_; }

    /// Takes a node off the bus in the middle of what it was doing, its state lost.
    void stop_a();
    void stop_b();
    /// A new one in its place, as after switching it on.
    void start_a();
    void start_b();

    /// As they were last, when the node is gone.
    const ControllerStatus& controller() const { return controller_; }
    const PlantStatus& plant() const { return plant_; }

  private:
    struct A;
    struct B;

    void step();
    void record_round() const;
    std::function<void(std::string_view)> log_of(std::string_view node);

    Options options_;
    Outputs outputs_;
    canorb::Simulation simulation_;
    canorb::TimePoint start_;
    canorb::SimulatedBus& bus_;
    LocalOperatorLine line_;
    ControllerStatus controller_;
    PlantStatus plant_;
    int temperature_c_ = 20;
    std::uint64_t steps_ = 0;
    std::unique_ptr<A> a_;
    std::unique_ptr<B> b_;
};

}  // namespace tank
