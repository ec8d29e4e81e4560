#pragma once

#include <cstdint>
#include <optional>

#include "plant.hpp"

namespace tank {

enum class Mode : std::uint8_t { normal, alarm };

/// The temperature is safe from -250 to 250 degrees Celsius, both included.
Mode mode_at(int temperature_c);

/// The control law: hysteresis around the setpoint while the temperature is safe, everything
/// closed while it is not. Decides once in each round.
class Controller {
  public:
    static constexpr int hysteresis_mm = 100;
    /// So many rounds without a level in a row, and both valves are ordered closed.
    static constexpr unsigned rounds_without_level_limit = 3;

    struct Inputs {
        std::optional<std::uint16_t> level_mm{};  ///< nothing when none was heard in this round
        bool inlet_open = false;                  ///< as node B last reported it
        int setpoint_cm = 50;
        int temperature_c = 20;
    };

    Valves decide(const Inputs& inputs);

    unsigned rounds_without_level() const { return rounds_without_level_; }

  private:
    Valves wanted_{};
    unsigned rounds_without_level_ = 0;
};

}  // namespace tank
