#pragma once

#include <canorb/orb.hpp>
#include <chrono>
#include <cstdint>
#include <string>

#include "commands.hpp"
#include "membership.hpp"
#include "panel.hpp"
#include "plant.hpp"
#include "supervisor.hpp"

namespace plant {

/// Polls its group of sensors in rounds, and switches its group of actuators: off as soon as there
/// is a reason, on at the end of a round that gave none. It repeats what it wants in every round,
/// because a multicast is not answered, and for those who join later.
///
/// Everything happens in the ORB's event loop; its functions are to be called from there too.
class Controller {
  public:
    static constexpr std::chrono::milliseconds round_length{500};
    /// In the first of so many rounds it tells the groups who it is; in every round while it misses
    /// a sensor.
    static constexpr std::uint64_t rounds_between_introductions = 10;

    /// Its groups, as the strings that their members print.
    struct Groups {
        std::string sensors;
        std::string actuators;
    };

    /// The first round begins after one round's length. `orb` must outlive this object. Throws
    /// what string_to_object() throws, and std::invalid_argument for a string that refers to
    /// something else.
    Controller(canorb::Orb& orb, const Groups& groups, Log log);
    ~Controller();
    Controller(const Controller&) = delete;
    Controller& operator=(const Controller&) = delete;

    /// Throws std::invalid_argument where it is none for a controller.
    void carry_out(const Command& command);
    Panel panel() const;

    const Supervisor& supervisor() const { return supervisor_; }
    bool wants_on() const { return on_; }

  private:
    class Servant final : public Plant::ControllerServant {
      public:
        explicit Servant(Controller& controller) : controller_(controller) {}
        void push_value(std::uint8_t sensor, Variable which, float value) override {
            controller_.take(sensor, which, value);
        }

      private:
        Controller& controller_;
    };

    void begin_round();
    void introduce();
    void take(int sensor, Variable which, float value);
    void switch_off_if_needed();
    void conclude(bool may_switch_on);
    void send_state();
    template <typename Call>
    void transmit(Call call);

    canorb::Orb& orb_;
    Log log_;
    Servant servant_{*this};
    canorb::ObjectRef object_;
    Plant::Sensor sensors_;
    Plant::Actuator actuators_;
    canorb::TimerId timer_{};
    Supervisor supervisor_;
    std::uint64_t round_ = 0;
    bool on_ = false;
    std::string reason_;
    bool transmission_failed_ = false;
};

}  // namespace plant
