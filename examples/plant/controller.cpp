#include "controller.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace plant {

namespace {

template <typename Stub>
Stub group_of(canorb::Orb& orb, const std::string& text, std::string_view what) {
    const canorb::ObjectRef reference = orb.string_to_object(text);
    const Stub stub = reference.is_group() ? reference.narrow<Stub>() : Stub{};
    if (stub.is_nil()) throw std::invalid_argument(fmt::format("no group of {}: {}", what, text));
    return stub.with_timeout(Controller::round_length);
}

}  // namespace

Controller::Controller(canorb::Orb& orb, const Groups& groups, Log log)
    : orb_(orb),
      log_(std::move(log)),
      sensors_(group_of<Plant::Sensor>(orb, groups.sensors, "sensors")),
      actuators_(group_of<Plant::Actuator>(orb, groups.actuators, "actuators")),
      reason_(supervisor_.verdict().reason) {
    object_ = orb.root_poa().activate_object_with_id(object_index, servant_);
    log_("my reference: " + orb_.object_to_string(object_));
    timer_ = orb_.every(round_length, [this] { begin_round(); });
}

Controller::~Controller() {
    orb_.cancel(timer_);
    orb_.root_poa().deactivate_object(*object_.index());
}

void Controller::begin_round() {
    if (round_ > 0) supervisor_.end_round();
    conclude(true);
    ++round_;
    send_state();
    // Who does not answer may not know whom to.
    if (supervisor_.misses_somebody() || round_ % rounds_between_introductions == 1) introduce();
    transmit([this] { sensors_.poll(); });
}

void Controller::introduce() {
    const std::string reference = orb_.object_to_string(object_);
    transmit([&] { actuators_.initialize(reference); });
    transmit([&] { sensors_.initialize(reference); });
}

void Controller::take(int sensor, Variable which, float value) {
    if (!supervisor_.sensors().contains(sensor)) log_(fmt::format("sensor {} is new", sensor));
    supervisor_.take(sensor, which, value);
    switch_off_if_needed();
}

void Controller::switch_off_if_needed() {
    const bool was_on = on_;
    conclude(false);
    if (was_on && !on_) send_state();
}

// Within a round not everybody has spoken yet: good news waits for its end.
void Controller::conclude(bool may_switch_on) {
    const Supervisor::Verdict verdict = supervisor_.verdict();
    if (verdict.on && !on_ && !may_switch_on) return;
    if (verdict.on != on_)
        log_(fmt::format("actuators {}: {}", verdict.on ? "on" : "off", verdict.reason));
    on_ = verdict.on;
    reason_ = verdict.reason;
}

void Controller::send_state() {
    transmit(
        [this] { actuators_.set_state(on_ ? Plant::SwitchState::on : Plant::SwitchState::off); });
}

// The bus may be out of order: this node goes on, and its calls work again when the bus does.
template <typename Call>
void Controller::transmit(Call call) {
    try {
        call();
        transmission_failed_ = false;
    } catch (const canorb::SystemException& exception) {
        if (!transmission_failed_) log_(exception.what());
        transmission_failed_ = true;
    }
}

void Controller::carry_out(const Command& command) {
    if (const auto* set = std::get_if<SetLimit>(&command)) {
        supervisor_.set_limit(set->variable, set->limit);
    } else if (const auto* change = std::get_if<Change>(&command)) {
        supervisor_.set_limit(change->variable, supervisor_.limit(change->variable) + change->by);
    } else if (const auto* forget = std::get_if<Forget>(&command)) {
        if (!supervisor_.forget(forget->sensor))
            throw std::invalid_argument(fmt::format("there is no sensor {}", forget->sensor));
        log_(fmt::format("sensor {} forgotten", forget->sensor));
    } else {
        throw std::invalid_argument("a controller knows limit, raise, lower, forget and quit");
    }
    switch_off_if_needed();
}

Panel Controller::panel() const {
    std::string title = fmt::format("{:<14}{:>12}", fmt::format("round {}", round_), "limit");
    std::string answers = fmt::format("{:<26}", "");
    bool all_answer = true;
    for (const auto& [number, sensor] : supervisor_.sensors()) {
        title += fmt::format("{:>11}", fmt::format("sensor {}", number));
        answers += fmt::format("{:>11}", sensor.stale() ? "STALE" : "answers");
        all_answer = all_answer && !sensor.stale();
    }
    Panel panel{{Mark::none, title}};
    for (const Variable variable : all_variables) {
        const VariableInfo& info = info_of(variable);
        std::string text =
            fmt::format("{:<14}{:>8.1f} {:<3}", info.name, supervisor_.limit(variable), info.unit);
        bool over = false;
        for (const auto& [number, sensor] : supervisor_.sensors()) {
            const auto value = sensor.values[index_of(variable)];
            const bool this_over = value && supervisor_.is_over(variable, *value);
            text += value ? fmt::format("{:>10.1f}{}", *value, this_over ? '!' : ' ')
                          : fmt::format("{:>10} ", "-");
            over = over || this_over;
        }
        panel.push_back({over ? Mark::bad : Mark::good, text});
    }
    if (!supervisor_.sensors().empty())
        panel.push_back({all_answer ? Mark::none : Mark::bad, answers});
    panel.push_back({on_ ? Mark::good : Mark::bad,
                     fmt::format("actuators {}: {}", on_ ? "ON" : "OFF", reason_)});
    return panel;
}

}  // namespace plant
