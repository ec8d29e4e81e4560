#pragma once

#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "canorb/simulation.hpp"
#include "orb/can/sim/bus.hpp"
#include "orb/runtime/timers.hpp"

namespace canorb::runtime {

/// What a Simulation asks of an ORB on one of its buses.
class SimulatedOrb {
  public:
    virtual ~SimulatedOrb() = default;

    /// Exchanges events and frames with the controller, then runs at most one servant call or
    /// notice. True: something happened, at which a caller must look before time goes on.
    virtual bool work() = 0;
    /// Runs one timer that is due. True: one was.
    virtual bool run_due_timer() = 0;
    /// When time alone gives it something to do.
    virtual TimePoint next_wakeup() const = 0;
};

}  // namespace canorb::runtime

namespace canorb {

/// The order of things is the contract of canorb/simulation.hpp.
class Simulation::Impl {
  public:
    SimulatedBus& add_bus(Simulation& simulation, const SimulatedBusOptions& options);
    /// The frames of the bus that was made as number `bus`, from 0: to watch and to disturb them.
    can::sim::Bus& frames(std::size_t bus);

    void add(runtime::SimulatedOrb& orb) { orbs_.push_back(&orb); }
    void remove(runtime::SimulatedOrb& orb) { std::erase(orbs_, &orb); }

    TimePoint now() const { return now_; }
    runtime::Timers& timers() { return timers_; }

    /// Where a new ORB begins to count: as good as random, and the same in every run.
    RequestId first_request_id() { return static_cast<RequestId>(request_ids_()); }

    /// Does the next thing that is due by `limit`. False: nothing is, and now() is `limit`.
    bool step(TimePoint limit);

  private:
    class BusImpl;

    TimePoint next_event() const;
    void move_to(TimePoint time);

    TimePoint now_{};
    std::mt19937 request_ids_;
    runtime::Timers timers_;
    std::vector<std::unique_ptr<BusImpl>> buses_;
    std::vector<runtime::SimulatedOrb*> orbs_;

  public:
    Impl();
    ~Impl();
};

}  // namespace canorb
