#include "actuator.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "controller_reference.hpp"

namespace plant {

Actuator::Actuator(canorb::Orb& orb, canorb::GroupId group, Log log)
    : orb_(orb),
      log_(std::move(log)),
      object_(orb.root_poa().activate_object_with_id(object_index, servant_)),
      membership_(orb, object_, log_) {
    membership_.join(group);
    wait_for_controller();
}

Actuator::~Actuator() {
    orb_.cancel(silence_);
    orb_.root_poa().deactivate_object(*object_.index());
}

void Actuator::carry_out(const Command& command) {
    if (const auto* join = std::get_if<Join>(&command)) {
        membership_.join(join->group);
        wait_for_controller();
    } else if (const auto* leave = std::get_if<Leave>(&command)) {
        membership_.leave(leave->group);
    } else {
        throw std::invalid_argument("an actuator knows join, leave and quit");
    }
}

void Actuator::set_controller(const std::string& reference) {
    take_controller_reference(orb_, reference, controller_, log_);
}

void Actuator::obey(bool on) {
    if (!controller_heard_) log_("the controller is back");
    controller_heard_ = true;
    if (on != on_) log_(on ? "on" : "off");
    on_ = on;
    wait_for_controller();
}

// The time begins anew.
void Actuator::wait_for_controller() {
    orb_.cancel(silence_);
    silence_ = orb_.at(orb_.now() + longest_silence, [this] { on_silence(); });
}

void Actuator::on_silence() {
    // Out of all groups it is nobody's, and stays as it is.
    if (!membership_.in_any()) return;
    log_(fmt::format("told nothing for {} s{}", longest_silence.count(), on_ ? ": off" : ""));
    on_ = false;
    controller_heard_ = false;
}

Panel Actuator::panel() const {
    return {on_ ? PanelLine{Mark::good, "ON"} : PanelLine{Mark::bad, "OFF"},
            controller_line(controller_, controller_heard_), membership_.line()};
}

}  // namespace plant
