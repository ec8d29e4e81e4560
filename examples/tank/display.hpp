#pragma once

/// What people see: the two nodes' panels and the operator's status text.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "control.hpp"
#include "orders.hpp"
#include "round.hpp"

namespace tank {

/// What node A knows.
struct ControllerStatus {
    std::uint64_t round = 0;
    Mode mode = Mode::normal;
    std::chrono::milliseconds slot_length = default_slot_length;
    int setpoint_cm = default_setpoint_cm;
    int temperature_c = 20;
    std::optional<std::uint16_t> level_mm{};  ///< last heard; nothing before the first
    bool level_stale = false;                 ///< not heard in this round
    Valves reported{};                        ///< as node B last reported them
    Valves wanted{};                          ///< as node A orders them
};

/// What node B knows.
struct PlantStatus {
    std::chrono::milliseconds slot_length = default_slot_length;
    std::optional<int> temperature_c{};  ///< last heard; nothing before the first
    std::uint16_t level_mm = Plant::height_mm;
    Valves valves{};
    bool overflowing = false;
    bool controller_silent = false;  ///< no actuations for 3 rounds: both valves were closed
};

/// A node's front: two lines of 16 characters, and two lights.
struct Panel {
    static constexpr std::size_t width = 16;

    std::array<std::string, 2> lines;
    std::array<bool, 2> leds{};

    friend bool operator==(const Panel&, const Panel&) = default;
};

/// Mode N or A, slot, setpoint; wanted VS and VE as A (open) or C (closed); STALE while the level
/// is not this round's. It has no lights.
Panel panel_of(const ControllerStatus& status);

/// Slot, temperature, then LOST while the controller is silent or OVER while the tank runs over;
/// level, VE, VS. Light 0 is VE, light 1 is VS.
Panel panel_of(const PlantStatus& status);

/// One line without its end.
std::string status_text(const ControllerStatus& status);

}  // namespace tank
