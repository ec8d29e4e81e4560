#include "sensor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "controller_reference.hpp"

namespace plant {

Sensor::Sensor(canorb::Orb& orb, canorb::GroupId group, Log log)
    : orb_(orb),
      log_(std::move(log)),
      number_(orb.node().value().value()),
      object_(orb.root_poa().activate_object_with_id(object_index, servant_)),
      membership_(orb, object_, log_) {
    membership_.join(group);
}

Sensor::~Sensor() {
    orb_.root_poa().deactivate_object(*object_.index());
}

void Sensor::carry_out(const Command& command) {
    if (const auto* set = std::get_if<SetValue>(&command)) {
        set_value(set->variable, set->value);
    } else if (const auto* change = std::get_if<Change>(&command)) {
        set_value(change->variable, value(change->variable) + change->by);
    } else if (const auto* join = std::get_if<Join>(&command)) {
        membership_.join(join->group);
    } else if (const auto* leave = std::get_if<Leave>(&command)) {
        membership_.leave(leave->group);
    } else {
        throw std::invalid_argument("a sensor knows value, raise, lower, join, leave and quit");
    }
}

void Sensor::set_value(Variable variable, float value) {
    values_[index_of(variable)] = std::clamp(value, -greatest_value, greatest_value);
}

void Sensor::set_controller(const std::string& reference) {
    take_controller_reference(orb_, reference, controller_, log_);
}

// Values are those of one moment, however long the answer takes.
void Sensor::answer() {
    ++polls_;
    // Several controllers may poll at once; one answer is on its way.
    if (controller_.is_nil() || answering_) return;
    answering_ = true;
    const Values values = values_;
    const Plant::Controller controller = controller_;
    try {
        for (const Variable variable : all_variables)
            controller.with_timeout(patience).push_value(number_, variable,
                                                         values[index_of(variable)]);
        if (!controller_answers_) log_("the controller is back");
        controller_answers_ = true;
    } catch (const canorb::SystemException& exception) {
        if (controller_answers_)
            log_(fmt::format("the controller does not answer: {}", exception.what()));
        controller_answers_ = false;
    }
    answering_ = false;
}

Panel Sensor::panel() const {
    Panel panel;
    for (const Variable variable : all_variables) {
        const VariableInfo& info = info_of(variable);
        panel.push_back(
            {Mark::none, fmt::format("{:<12}{:>7.1f} {}", info.name, value(variable), info.unit)});
    }
    panel.push_back(controller_line(controller_, controller_answers_));
    panel.push_back(membership_.line());
    panel.push_back({Mark::none, fmt::format("polled {} times", polls_)});
    return panel;
}

}  // namespace plant
