#pragma once

#include <canorb/types.hpp>
#include <cstdint>
#include <span>
#include <string>

#include "control.hpp"
#include "plant.hpp"

namespace tank {

/// Everything that the plot shows, at one moment.
struct PlotSample {
    canorb::Duration time{};  ///< since the start
    std::uint16_t level_mm = 0;
    int setpoint_cm = 0;
    int temperature_c = 0;
    Mode mode = Mode::normal;
    Valves valves{};
};

/// A vertical line with a short label.
struct PlotMark {
    canorb::Duration time{};
    std::string label;
};

/// An SVG picture of level, setpoint, temperature and valves over time, the alarms shaded.
std::string svg_plot(std::span<const PlotSample> samples, std::span<const PlotMark> marks = {});

}  // namespace tank
