#pragma once

#include <chrono>
#include <cstdint>

namespace tank {

/// The two valves, or what somebody wants of them.
struct Valves {
    bool inlet_open = false;   ///< VE, 400 l/s
    bool outlet_open = false;  ///< VS, 200 l/s

    friend bool operator==(const Valves&, const Valves&) = default;
};

/// The tank: base 1 m2, height 2 m, so that a litre is a millimetre. It starts full, both valves
/// closed. Time passes in steps.
class Plant {
  public:
    static constexpr std::uint16_t height_mm = 2000;
    static constexpr std::chrono::milliseconds step_length{5};

    std::uint16_t level_mm() const { return level_mm_; }
    Valves valves() const { return valves_; }
    void set_valves(Valves valves) { valves_ = valves; }

    /// Lets step_length pass.
    void step();

    /// Whether liquid ran over the top in the last step.
    bool overflowing() const { return overflowing_; }

  private:
    std::uint16_t level_mm_ = height_mm;
    Valves valves_;
    bool overflowing_ = false;
};

/// How many steps are due, where time passes by itself and nobody is woken exactly on time.
class StepsDue {
  public:
    /// The steps between the last call and now, `elapsed` after the start. None is lost or made
    /// twice.
    unsigned take(std::chrono::nanoseconds elapsed) {
        const auto due = elapsed / Plant::step_length;
        const auto steps = due - taken_;
        taken_ = due;
        return static_cast<unsigned>(steps);
    }

  private:
    std::int64_t taken_ = 0;
};

}  // namespace tank
