#pragma once

/// A world on virtual time: buses and ORBs in one thread, nothing waits, the same run every time.
///
///     canorb::Simulation simulation;
///     auto& bus = simulation.add_bus({.bitrate = 500'000});
///     canorb::Orb a{bus, {.node = 1}};
///     canorb::Orb b{bus, {.node = 2}};
///     ...
///     simulation.run_for(60s);        // returns at once, 60 s later
///
/// A blocking call through an ORB of the simulation makes virtual time pass until it is answered.
/// At equal times come, in this order: the callbacks of at() and every(), frames, then the ORBs'
/// timers in the order in which the ORBs were made. Not for use from several threads.

#include <cstdint>
#include <functional>
#include <memory>

#include "canorb/bus.hpp"

namespace canorb {

struct SimulatedBusOptions {
    std::uint32_t bitrate = 500'000;  ///< bit/s
    /// A BasicCAN controller's two mask-and-match registers instead of a list of exact filters.
    bool basic_can = false;
};

/// A bus on a Simulation's clock.
class SimulatedBus : public Bus {
  public:
    using FrameObserver = std::function<void(const can::Frame& frame, TimePoint end_of_frame)>;

    /// Called for every frame at its end.
    virtual void on_frame(FrameObserver observer) = 0;
};

class Simulation {
  public:
    Simulation();
    ~Simulation();
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;

    /// The bus lives as long as the simulation.
    SimulatedBus& add_bus(const SimulatedBusOptions& options = {});

    TimePoint now() const;

    /// Runs `callback` at that time; at a time that has passed, at once when time next passes.
    void at(TimePoint time, std::function<void()> callback);
    /// Runs `callback` every `period`, first at `first`. Throws BAD_PARAM unless `period` > 0.
    void every(Duration period, TimePoint first, std::function<void()> callback);

    /// Lets virtual time pass until `time`, everything due at it included.
    void run_until(TimePoint time);
    void run_for(Duration duration) { run_until(now() + duration); }

    /// Lets virtual time pass until `done()` is true (true), or until `limit` (false).
    bool run_until(const std::function<bool()>& done, TimePoint limit);

    class Impl;
    /// For the ORB itself.
    Impl& impl() { return *impl_; }

  private:
    std::unique_ptr<Impl> impl_;
};

}  // namespace canorb
