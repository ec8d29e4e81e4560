#include "orb/can/controller.hpp"

namespace canorb::can {

std::string_view name(ControllerState state) {
    switch (state) {
        case ControllerState::error_active:
            return "error active";
        case ControllerState::error_passive:
            return "error passive";
        case ControllerState::bus_off:
            return "bus off";
        case ControllerState::stopped:
            return "stopped";
    }
    return "?";
}

}  // namespace canorb::can
