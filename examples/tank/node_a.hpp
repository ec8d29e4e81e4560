#pragma once

#include <canorb/orb.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "control.hpp"
#include "display.hpp"
#include "operator_line.hpp"
#include "orders.hpp"
#include "round.hpp"
#include "tank.hpp"

namespace tank {

/// The controller, and the master of the round: it begins one every twelve slots of its own timer,
/// decides from what node B measured, and serves the operator.
///
/// Everything happens in the ORB's event loop; its functions are to be called from there too.
class NodeA {
  public:
    struct Outputs {
        /// After every change.
        std::function<void(const ControllerStatus&)> display{};
        /// What is worth a line in a log.
        std::function<void(std::string_view)> log{};
    };

    /// The first round begins at once. `orb` and `line` must outlive this object.
    NodeA(canorb::Orb& orb, OperatorLine& line, Outputs outputs);
    ~NodeA();
    NodeA(const NodeA&) = delete;
    NodeA& operator=(const NodeA&) = delete;

    /// The sensor's new reading, degrees Celsius; to be called every 5 ms.
    void set_temperature(int celsius) { status_.temperature_c = celsius; }

    const ControllerStatus& status() const { return status_; }

  private:
    class MeasurementImpl final : public Tank::MeasurementServant {
      public:
        explicit MeasurementImpl(NodeA& node) : node_(node) {}
        void level(std::uint16_t millimetres) override { node_.level_ = millimetres; }
        void inlet_state(Tank::Valve position) override {
            node_.status_.reported.inlet_open = position == Tank::Valve::open;
        }
        void outlet_state(Tank::Valve position) override {
            node_.status_.reported.outlet_open = position == Tank::Valve::open;
        }

      private:
        NodeA& node_;
    };

    void on_timer();
    void begin_round();
    void enter_slot();

    void control();
    void take_order();
    void carry_out(const SetpointOrder& order);
    void carry_out(const SlotOrder& order);

    void send_sync();
    void send_inlet();
    void send_outlet();
    void send_temperature();
    void send_slot_duration();

    bool in_time() const;
    canorb::SentCallback when_sent(void (NodeA::*next)());
    template <typename Call>
    void transmit(Call call);
    void say(std::string_view text);
    void show();

    canorb::Orb& orb_;
    OperatorLine& line_;
    Outputs outputs_;
    MeasurementImpl measurement_{*this};
    canorb::ObjectRef measurement_object_;
    Tank::Round round_;
    Tank::Actuation actuation_;

    SlotClock clock_;
    canorb::TimerId timer_{};
    Controller controller_;
    ControllerStatus status_;
    std::optional<std::uint16_t> level_;  ///< heard in this round
    bool decided_ = false;                ///< in this round
    bool transmission_failed_ = false;

    /// Callbacks of calls may come when this object is gone; they hold this weakly.
    std::shared_ptr<NodeA*> self_ = std::make_shared<NodeA*>(this);
};

}  // namespace tank
