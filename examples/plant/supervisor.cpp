#include "supervisor.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace plant {

void Supervisor::take(int sensor, Variable variable, float value) {
    Sensor& known = sensors_[sensor];
    known.values[index_of(variable)] = value;
    known.reported[index_of(variable)] = true;
    if (std::ranges::all_of(known.reported, [](bool reported) { return reported; }))
        known.rounds_missed = 0;
}

void Supervisor::end_round() {
    for (auto& [number, sensor] : sensors_) {
        const bool whole =
            std::ranges::all_of(sensor.reported, [](bool reported) { return reported; });
        if (!whole) ++sensor.rounds_missed;
        sensor.reported.fill(false);
    }
}

bool Supervisor::misses_somebody() const {
    return sensors_.empty() ||
           std::ranges::any_of(sensors_, [](const auto& known) { return known.second.stale(); });
}

Supervisor::Verdict Supervisor::verdict() const {
    if (sensors_.empty()) return {false, "no sensor has answered"};
    for (const auto& [number, sensor] : sensors_) {
        for (const Variable variable : all_variables) {
            const auto& value = sensor.values[index_of(variable)];
            if (value && is_over(variable, *value))
                return {false, fmt::format("{} of sensor {} over its limit", info_of(variable).name,
                                           number)};
        }
    }
    for (const auto& [number, sensor] : sensors_) {
        if (sensor.stale()) return {false, fmt::format("sensor {} is silent", number)};
        const bool complete =
            std::ranges::all_of(sensor.values, [](const auto& value) { return value.has_value(); });
        if (!complete) return {false, fmt::format("sensor {} has not told all", number)};
    }
    return {true, "all within their limits"};
}

}  // namespace plant
