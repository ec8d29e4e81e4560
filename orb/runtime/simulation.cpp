#include "canorb/simulation.hpp"

#include <algorithm>

#include "canorb/exceptions.hpp"
#include "orb/can/sim/controller.hpp"
#include "orb/runtime/simulation_impl.hpp"

namespace canorb {

class Simulation::Impl::BusImpl final : public SimulatedBus {
  public:
    BusImpl(Simulation& simulation, const SimulatedBusOptions& options)
        : simulation_(simulation), options_(options), bus_(options.bitrate, simulation.now()) {
        bus_.set_trace([this](const can::sim::CompletedFrame& completed) {
            for (const FrameObserver& observer : observers_) {
                observer(completed.frame, completed.time);
            }
        });
    }

    std::unique_ptr<can::Controller> attach(std::string_view name) override {
        can::sim::NodeOptions node;
        node.name = name;
        if (options_.basic_can) node.filter_list = 0;
        return std::make_unique<can::sim::Controller>(bus_, node);
    }

    TimePoint now() const override { return simulation_.now(); }
    Simulation* simulation() override { return &simulation_; }
    void on_frame(FrameObserver observer) override { observers_.push_back(std::move(observer)); }

    can::sim::Bus& frames() { return bus_; }
    const can::sim::Bus& frames() const { return bus_; }

  private:
    Simulation& simulation_;
    SimulatedBusOptions options_;
    can::sim::Bus bus_;
    std::vector<FrameObserver> observers_;
};

Simulation::Impl::Impl() = default;
Simulation::Impl::~Impl() = default;

SimulatedBus& Simulation::Impl::add_bus(Simulation& simulation,
                                        const SimulatedBusOptions& options) {
    buses_.push_back(std::make_unique<BusImpl>(simulation, options));
    return *buses_.back();
}

can::sim::Bus& Simulation::Impl::frames(std::size_t bus) {
    return buses_.at(bus)->frames();
}

bool Simulation::Impl::step(TimePoint limit) {
    if (const auto callback = timers_.take_due(now_)) {
        (*callback)();
        return true;
    }
    // By index: user code may add and remove ORBs.
    for (std::size_t i = 0; i < orbs_.size(); ++i) {
        if (orbs_[i]->work()) return true;
    }
    for (std::size_t i = 0; i < orbs_.size(); ++i) {
        if (orbs_[i]->run_due_timer()) return true;
    }
    const TimePoint next = next_event();
    if (next > limit || next == never) {
        if (limit != never) move_to(limit);
        return false;
    }
    move_to(next);
    return true;
}

TimePoint Simulation::Impl::next_event() const {
    TimePoint next = timers_.next();
    for (const auto& bus : buses_) next = std::min(next, bus->frames().next_event());
    for (const runtime::SimulatedOrb* orb : orbs_) next = std::min(next, orb->next_wakeup());
    return next;
}

void Simulation::Impl::move_to(TimePoint time) {
    now_ = std::max(now_, time);
    // Before anybody acts at this moment, so that what they send begins at it.
    for (const auto& bus : buses_) bus->frames().advance(now_);
}

Simulation::Simulation() : impl_(std::make_unique<Impl>()) {}
Simulation::~Simulation() = default;

SimulatedBus& Simulation::add_bus(const SimulatedBusOptions& options) {
    constexpr auto lowest = can::sim::Bus::lowest_bitrate;
    constexpr auto highest = can::sim::Bus::highest_bitrate;
    if (options.bitrate < lowest || options.bitrate > highest) {
        throw_system_exception(cause::bad_option, "a bit rate of " +
                                                      std::to_string(options.bitrate) +
                                                      " bit/s is not " + std::to_string(lowest) +
                                                      " to " + std::to_string(highest));
    }
    return impl_->add_bus(*this, options);
}

TimePoint Simulation::now() const {
    return impl_->now();
}

void Simulation::at(TimePoint time, std::function<void()> callback) {
    impl_->timers().add(time, Duration::zero(), std::move(callback));
}

void Simulation::every(Duration period, TimePoint first, std::function<void()> callback) {
    if (period <= Duration::zero())
        throw_system_exception(cause::bad_argument, "a period must be greater than 0");
    impl_->timers().add(first, period, std::move(callback));
}

void Simulation::run_until(TimePoint time) {
    while (impl_->step(time)) {
    }
}

bool Simulation::run_until(const std::function<bool()>& done, TimePoint limit) {
    while (!done()) {
        if (!impl_->step(limit)) return done();
    }
    return true;
}

}  // namespace canorb
