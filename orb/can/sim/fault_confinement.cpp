#include "orb/can/sim/fault_confinement.hpp"

#include <algorithm>

namespace canorb::can::sim {
namespace {

constexpr int highest_active_count = 127;
constexpr int highest_passive_count = 255;

}  // namespace

void FaultConfinement::transmitted() {
    if (status_.tec > 0) add_to_tec(-1);
}

void FaultConfinement::received() {
    if (status_.rec == 0) return;
    // From above the passive limit it may return to any value between 119 and 127.
    add_to_rec(status_.rec > highest_active_count ? highest_active_count - status_.rec : -1);
}

void FaultConfinement::add_eight(bool transmitter) {
    if (transmitter) {
        add_to_tec(8);
    } else {
        add_to_rec(8);
    }
}

void FaultConfinement::add_to_tec(int change) {
    status_.tec = static_cast<std::uint16_t>(status_.tec + change);
    decide();
}

void FaultConfinement::add_to_rec(int change) {
    // The rules give REC no end; an eight bit counter, as controllers have, stops at its highest.
    status_.rec = static_cast<std::uint16_t>(std::min(status_.rec + change, highest_passive_count));
    decide();
}

void FaultConfinement::decide() {
    if (is_bus_off()) return;
    if (status_.tec > highest_passive_count) {
        status_.state = ControllerState::bus_off;
    } else if (status_.tec > highest_active_count || status_.rec > highest_active_count) {
        status_.state = ControllerState::error_passive;
    } else {
        status_.state = ControllerState::error_active;
    }
}

}  // namespace canorb::can::sim
