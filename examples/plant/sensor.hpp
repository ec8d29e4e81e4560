#pragma once

#include <canorb/orb.hpp>
#include <chrono>
#include <cstdint>
#include <string>

#include "commands.hpp"
#include "membership.hpp"
#include "panel.hpp"
#include "plant.hpp"

namespace plant {

/// Measures all variables, whose values people set, and tells them to its controller when polled.
///
/// Everything happens in the ORB's event loop; its functions are to be called from there too.
class Sensor {
  public:
    /// How long it waits for the controller to take a value.
    static constexpr std::chrono::milliseconds patience{200};

    /// `orb` must have a number, and outlive this object.
    Sensor(canorb::Orb& orb, canorb::GroupId group, Log log);
    ~Sensor();
    Sensor(const Sensor&) = delete;
    Sensor& operator=(const Sensor&) = delete;

    /// Throws std::invalid_argument where it is none for a sensor.
    void carry_out(const Command& command);
    Panel panel() const;

    float value(Variable variable) const { return values_[index_of(variable)]; }

  private:
    class Servant final : public Plant::SensorServant {
      public:
        explicit Servant(Sensor& sensor) : sensor_(sensor) {}
        void initialize(const std::string& controller_reference) override {
            sensor_.set_controller(controller_reference);
        }
        void poll() override { sensor_.answer(); }

      private:
        Sensor& sensor_;
    };

    void set_value(Variable variable, float value);
    void set_controller(const std::string& reference);
    void answer();

    canorb::Orb& orb_;
    Log log_;
    std::uint8_t number_;
    Servant servant_{*this};
    canorb::ObjectRef object_;
    Membership membership_;
    Values values_ = values_of(&VariableInfo::start);
    Plant::Controller controller_;
    unsigned polls_ = 0;
    bool answering_ = false;
    bool controller_answers_ = true;
};

}  // namespace plant
