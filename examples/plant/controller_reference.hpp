#pragma once

#include <canorb/orb.hpp>
#include <string>

#include "membership.hpp"
#include "panel.hpp"
#include "plant.hpp"

namespace plant {

/// What `initialize` does at a sensor and at an actuator: makes `controller` the one that `text`
/// refers to. Text that refers to none changes nothing, and is told to the log.
void take_controller_reference(canorb::Orb& orb, const std::string& text,
                               Plant::Controller& controller, const Log& log);

/// "controller node 1", or that there is none, or that it does not answer.
PanelLine controller_line(const Plant::Controller& controller, bool answers);

}  // namespace plant
