#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "variables.hpp"

namespace plant {

/// What the controller knows of its sensors, and what it concludes. Without clock or bus: a round
/// is what lies between two calls of end_round().
///
/// Invariants: a sensor is known from its first answer until forget(); it is stale from the
/// silent_rounds-th round in a row in which it did not report every variable until it reports them
/// all again.
class Supervisor {
  public:
    static constexpr unsigned silent_rounds = 3;

    struct Sensor {
        std::array<std::optional<float>, variables.size()> values{};
        std::array<bool, variables.size()> reported{};  ///< in this round
        unsigned rounds_missed = 0;

        bool stale() const { return rounds_missed >= silent_rounds; }
    };

    /// Whether the actuators may be on, and why, or why not.
    struct Verdict {
        bool on;
        std::string reason;
    };

    void set_limit(Variable variable, float limit) { limits_[index_of(variable)] = limit; }
    float limit(Variable variable) const { return limits_[index_of(variable)]; }

    void take(int sensor, Variable variable, float value);
    void end_round();
    /// The sensor is no longer part of the plant. False: there was none of that number.
    bool forget(int sensor) { return sensors_.erase(sensor) > 0; }

    /// By number.
    const std::map<int, Sensor>& sensors() const { return sensors_; }

    /// Over its limit; what is no number is.
    bool is_over(Variable variable, float value) const { return !(value <= limit(variable)); }

    /// No sensor has answered yet, or one is stale.
    bool misses_somebody() const;

    /// On only when every known sensor answers, there is one at all, and no value is over its
    /// limit: what is not known is taken for dangerous.
    Verdict verdict() const;

  private:
    Values limits_ = values_of(&VariableInfo::limit);
    std::map<int, Sensor> sensors_;
};

}  // namespace plant
