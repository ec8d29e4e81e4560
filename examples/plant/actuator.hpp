#pragma once

#include <canorb/orb.hpp>
#include <chrono>
#include <string>

#include "commands.hpp"
#include "membership.hpp"
#include "panel.hpp"
#include "plant.hpp"

namespace plant {

/// A switch. It begins off, is as it was told last, and switches itself off when, as a member of a
/// group, it is told nothing for a while: a dead controller must not leave it on.
///
/// Everything happens in the ORB's event loop; its functions are to be called from there too.
class Actuator {
  public:
    static constexpr std::chrono::seconds longest_silence{3};

    /// `orb` must outlive this object.
    Actuator(canorb::Orb& orb, canorb::GroupId group, Log log);
    ~Actuator();
    Actuator(const Actuator&) = delete;
    Actuator& operator=(const Actuator&) = delete;

    /// Throws std::invalid_argument where it is none for an actuator.
    void carry_out(const Command& command);
    Panel panel() const;

    bool is_on() const { return on_; }

  private:
    class Servant final : public Plant::ActuatorServant {
      public:
        explicit Servant(Actuator& actuator) : actuator_(actuator) {}
        void initialize(const std::string& controller_reference) override {
            actuator_.set_controller(controller_reference);
        }
        void set_state(Plant::SwitchState wanted) override {
            actuator_.obey(wanted == Plant::SwitchState::on);
        }

      private:
        Actuator& actuator_;
    };

    void set_controller(const std::string& reference);
    void obey(bool on);
    void wait_for_controller();
    void on_silence();

    canorb::Orb& orb_;
    Log log_;
    Servant servant_{*this};
    canorb::ObjectRef object_;
    Membership membership_;
    Plant::Controller controller_;
    canorb::TimerId silence_{};
    bool on_ = false;
    bool controller_heard_ = true;
};

}  // namespace plant
