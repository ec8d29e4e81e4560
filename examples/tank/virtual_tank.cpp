#include "virtual_tank.hpp"

#include <utility>

#include "groups.hpp"

namespace tank {

struct VirtualTank::A {
    explicit A(VirtualTank& tank)
        : orb(tank.bus_, {.node = default_node_a, .name = "tank-a", .log = tank.log_of("A")}),
          node(orb, tank.line_,
               {.display = [&tank](const ControllerStatus& status) { tank.controller_ = status; },
                .log = tank.log_of("A")}) {}

    canorb::Orb orb;
    NodeA node;
};

struct VirtualTank::B {
    explicit B(VirtualTank& tank)
        : orb(tank.bus_, {.node = default_node_b, .name = "tank-b", .log = tank.log_of("B")}),
          node(orb, {.display = [&tank](const PlantStatus& status) { tank.plant_ = status; },
                     .log = tank.log_of("B"),
                     .round_applied = [&tank] { tank.record_round(); }}) {}

    canorb::Orb orb;
    NodeB node;
};

VirtualTank::VirtualTank(Options options, Outputs outputs)
    : options_(std::move(options)),
      outputs_(std::move(outputs)),
      start_(simulation_.now()),
      bus_(simulation_.add_bus({.bitrate = options_.bitrate})),
      line_(outputs_.terminal) {
    if (outputs_.frame) {
        bus_.on_frame([this](const canorb::can::Frame& frame, canorb::TimePoint end_of_frame) {
            outputs_.frame(end_of_frame - start_, frame);
        });
    }
    for (const ScheduledOrder& order : options_.orders)
        simulation_.at(start_ + order.time, [this, order] { line_.type(order.order); });
    simulation_.every(Plant::step_length, start_, [this] { step(); });
    // At equal times the ORB that was made first comes first: node A.
    start_a();
    start_b();
}

VirtualTank::~VirtualTank() = default;

void VirtualTank::run_until(canorb::Duration time) {
    simulation_.run_until(start_ + time);
}

void VirtualTank::start_a() {
    a_ = std::make_unique<A>(*this);
}
void VirtualTank::stop_a() {
    a_.reset();
}
void VirtualTank::start_b() {
    b_ = std::make_unique<B>(*this);
}
void VirtualTank::stop_b() {
    b_.reset();
}

// Runs every 5 ms, first at the start.
void VirtualTank::step() {
    const canorb::Duration time = now();
    for (const ScheduledTemperature& turn : options_.temperatures) {
        const bool due = turn.time <= time && turn.time > time - Plant::step_length;
        if (due) temperature_c_ = turn.celsius;
    }
    if (a_) a_->node.set_temperature(temperature_c_);
    if (b_ && steps_ > 0) b_->node.pass_time(1);
    if (outputs_.sample && steps_ % 10 == 0) {
        outputs_.sample({time, plant_.level_mm, controller_.setpoint_cm, temperature_c_,
                         controller_.mode, plant_.valves});
    }
    ++steps_;
}

void VirtualTank::record_round() const {
    if (!outputs_.round) return;
    outputs_.round({.time = now(),
                    .round = controller_.round,
                    .slot_length = plant_.slot_length,
                    .mode = controller_.mode,
                    .setpoint_cm = controller_.setpoint_cm,
                    .temperature_c = controller_.temperature_c,
                    .level_mm = plant_.level_mm,
                    .valves = plant_.valves});
}

std::function<void(std::string_view)> VirtualTank::log_of(std::string_view node) {
    return [this, node](std::string_view text) {
        if (outputs_.log) outputs_.log(now(), node, text);
    };
}

}  // namespace tank
