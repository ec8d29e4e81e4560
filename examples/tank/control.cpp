#include "control.hpp"

namespace tank {

Mode mode_at(int temperature_c) {
    return temperature_c >= -250 && temperature_c <= 250 ? Mode::normal : Mode::alarm;
}

Valves Controller::decide(const Inputs& inputs) {
    rounds_without_level_ = inputs.level_mm ? 0 : rounds_without_level_ + 1;
    if (mode_at(inputs.temperature_c) == Mode::alarm ||
        rounds_without_level_ >= rounds_without_level_limit) {
        wanted_ = {};
    } else if (inputs.level_mm) {
        const int level_mm = *inputs.level_mm;
        const int setpoint_mm = inputs.setpoint_cm * 10;
        wanted_.outlet_open = true;
        if (level_mm < setpoint_mm - hysteresis_mm) {
            wanted_.inlet_open = true;
        } else if (level_mm > setpoint_mm + hysteresis_mm) {
            wanted_.inlet_open = false;
        } else {
            wanted_.inlet_open = inputs.inlet_open;
        }
    }
    return wanted_;
}

}  // namespace tank
