#include "display.hpp"

#include <fmt/format.h>

namespace tank {

namespace {

char letter(bool open) {
    return open ? 'A' : 'C';
}
const char* word(bool open) {
    return open ? "open" : "closed";
}

std::string level_text(const ControllerStatus& status) {
    if (!status.level_mm) return "unknown";
    const int mm = *status.level_mm;
    return fmt::format("{}.{} cm{}", mm / 10, mm % 10, status.level_stale ? " STALE" : "");
}

}  // namespace

Panel panel_of(const ControllerStatus& status) {
    Panel panel;
    panel.lines[0] = fmt::format("{} {:>3}ms SP{:>4}cm", status.mode == Mode::normal ? 'N' : 'A',
                                 status.slot_length.count(), status.setpoint_cm);
    panel.lines[1] =
        fmt::format("VS {} VE {}  {:<5}", letter(status.wanted.outlet_open),
                    letter(status.wanted.inlet_open), status.level_stale ? "STALE" : "");
    return panel;
}

Panel panel_of(const PlantStatus& status) {
    const char* trouble = status.controller_silent ? "LOST" : status.overflowing ? "OVER" : "";
    const std::string temperature =
        status.temperature_c ? fmt::format("{}", *status.temperature_c) : "---";
    Panel panel;
    panel.lines[0] =
        fmt::format("{:>3}ms{:>5}C {:<4}", status.slot_length.count(), temperature, trouble);
    panel.lines[1] =
        fmt::format("{:>3}cm VE {} VS {} ", status.level_mm / 10, letter(status.valves.inlet_open),
                    letter(status.valves.outlet_open));
    panel.leds = {status.valves.inlet_open, status.valves.outlet_open};
    return panel;
}

std::string status_text(const ControllerStatus& status) {
    return fmt::format(
        "mode {}, slot {} ms, setpoint {} cm, temperature {} C, level {}, VE {}, VS {}",
        status.mode == Mode::normal ? "normal" : "alarm", status.slot_length.count(),
        status.setpoint_cm, status.temperature_c, level_text(status),
        word(status.reported.inlet_open), word(status.reported.outlet_open));
}

}  // namespace tank
