#include "node_b.hpp"

#include <fmt/format.h>

#include <utility>

#include "groups.hpp"
#include "messages.hpp"

namespace tank {

namespace {

canorb::Duration silence_limit(canorb::Duration slot_length) {
    return slot_length * slots_in_round * rounds_without_actuation_limit;
}

}  // namespace

void NodeB::RoundImpl::slot_duration(std::uint16_t milliseconds) {
    // Nobody sends 0; but a timer that fires without end would be the end of this node.
    if (milliseconds > 0) node_.clock_.set_next_length(std::chrono::milliseconds{milliseconds});
}

NodeB::NodeB(canorb::Orb& orb, Outputs outputs)
    : orb_(orb),
      outputs_(std::move(outputs)),
      round_object_(orb.root_poa().activate_object(round_)),
      actuation_object_(orb.root_poa().activate_object(actuation_)),
      measurement_(orb.group_reference(measurement_group).narrow<Tank::Measurement>()),
      clock_(orb.now(), default_slot_length) {
    orb_.object_join(round_object_, round_group);
    orb_.object_join(actuation_object_, actuation_group);
    watch_until(orb_.now() + silence_limit(clock_.length()));
}

NodeB::~NodeB() {
    orb_.cancel(timer_);
    orb_.cancel(silence_timer_);
    orb_.root_poa().deactivate_object(*round_object_.index());
    orb_.root_poa().deactivate_object(*actuation_object_.index());
}

void NodeB::pass_time(unsigned steps) {
    const bool overflowed_before = plant_.overflowing();
    for (; steps > 0; --steps) plant_.step();
    status_.level_mm = plant_.level_mm();
    status_.overflowing = plant_.overflowing();
    if (status_.overflowing && !overflowed_before) say("the tank runs over");
    show();
}

void NodeB::begin_round() {
    const canorb::Duration length_before = clock_.length();
    clock_.begin_round(orb_.now());
    inlet_open_.reset();
    outlet_open_.reset();
    orb_.cancel(timer_);
    timer_ = orb_.at(clock_.end(), [this] { on_timer(); });
    if (clock_.length() != length_before) {
        // Three rounds are counted in slots: those that passed were as long as they were.
        const canorb::Duration left = silence_deadline_ - clock_.start();
        if (!status_.controller_silent)
            watch_until(clock_.start() +
                        left * in_ms(clock_.length()).count() / in_ms(length_before).count());
    }
    status_.slot_length = in_ms(clock_.length());
    show();
}

void NodeB::on_timer() {
    // Slots that went by unseen are left out: they belong to others by now.
    do {
        clock_.advance();
    } while (clock_.end() <= orb_.now() && clock_.slot() != slot::guard);
    // In the guard slot the timer stands still until the next sync.
    if (clock_.slot() != slot::guard) timer_ = orb_.at(clock_.end(), [this] { on_timer(); });
    enter_slot();
}

void NodeB::enter_slot() {
    const Valves valves = plant_.valves();
    switch (clock_.slot()) {
        case slot::level:
            transmit([this](const auto& group) { group.level(plant_.level_mm()); });
            break;
        case slot::inlet_state:
            transmit([&](const auto& group) { group.inlet_state(position(valves.inlet_open)); });
            break;
        case slot::outlet_state:
            transmit([&](const auto& group) { group.outlet_state(position(valves.outlet_open)); });
            break;
        case slot::apply:
            apply();
            break;
        case slot::applied:
            if (outputs_.round_applied) outputs_.round_applied();
            break;
        default:
            break;
    }
}

void NodeB::apply() {
    if (!inlet_open_ || !outlet_open_) return;
    plant_.set_valves({*inlet_open_, *outlet_open_});
    status_.valves = plant_.valves();
    if (status_.controller_silent) {
        status_.controller_silent = false;
        say("the controller is back");
    }
    watch_until(clock_.start() + silence_limit(clock_.length()));
    show();
}

void NodeB::watch_until(canorb::TimePoint deadline) {
    orb_.cancel(silence_timer_);
    silence_deadline_ = deadline;
    silence_timer_ = orb_.at(deadline, [this] { on_silence(); });
}

void NodeB::on_silence() {
    plant_.set_valves({});
    status_.valves = {};
    status_.controller_silent = true;
    say(fmt::format("no actuation for {} rounds of {} ms slots: both valves closed",
                    rounds_without_actuation_limit, status_.slot_length.count()));
    show();
}

bool NodeB::in_time() const {
    return orb_.now() - clock_.start() <=
           latest_start(clock_.length(), orb_.link_capabilities().bitrate);
}

// Makes a call that may wait for the bus until the slot ends, and is withdrawn then. The bus may be
// out of order: this node goes on, and its calls work again when the bus does.
template <typename Call>
void NodeB::transmit(Call call) {
    if (!in_time()) return;
    try {
        call(measurement_.with_timeout(clock_.end() - orb_.now()));
        transmission_failed_ = false;
    } catch (const canorb::SystemException& exception) {
        if (!transmission_failed_) say(exception.what());
        transmission_failed_ = true;
    }
}

void NodeB::say(std::string_view text) {
    if (outputs_.log) outputs_.log(text);
}

void NodeB::show() {
    if (outputs_.display) outputs_.display(status_);
}

}  // namespace tank
