#pragma once

#include <canorb/orb.hpp>
#include <functional>
#include <optional>
#include <string_view>

#include "display.hpp"
#include "plant.hpp"
#include "round.hpp"
#include "tank.hpp"

namespace tank {

/// The node at the tank: it measures, and it opens and closes the valves. Its slots are counted
/// from the last sync that it heard; before the first it does nothing.
///
/// When no actuations came for three rounds it closes both valves: a controller that is dead or
/// unheard must not leave one open.
///
/// Everything happens in the ORB's event loop; its functions are to be called from there too.
class NodeB {
  public:
    struct Outputs {
        /// After every change.
        std::function<void(const PlantStatus&)> display{};
        /// What is worth a line in a log.
        std::function<void(std::string_view)> log{};
        /// At the end of slot 6, in which actuations are applied.
        std::function<void()> round_applied{};
    };

    /// `orb` must outlive this object.
    NodeB(canorb::Orb& orb, Outputs outputs);
    ~NodeB();
    NodeB(const NodeB&) = delete;
    NodeB& operator=(const NodeB&) = delete;

    /// Lets so much time pass for the tank; to be called every 5 ms.
    void pass_time(unsigned steps);

    const PlantStatus& status() const { return status_; }

  private:
    class RoundImpl final : public Tank::RoundServant {
      public:
        explicit RoundImpl(NodeB& node) : node_(node) {}
        void sync() override { node_.begin_round(); }
        void slot_duration(std::uint16_t milliseconds) override;

      private:
        NodeB& node_;
    };

    class ActuationImpl final : public Tank::ActuationServant {
      public:
        explicit ActuationImpl(NodeB& node) : node_(node) {}
        void inlet(Tank::Valve position) override {
            node_.inlet_open_ = position == Tank::Valve::open;
        }
        void outlet(Tank::Valve position) override {
            node_.outlet_open_ = position == Tank::Valve::open;
        }
        void temperature(std::int16_t celsius) override {
            node_.status_.temperature_c = celsius;
            node_.show();
        }

      private:
        NodeB& node_;
    };

    void begin_round();
    void on_timer();
    void enter_slot();
    void apply();
    void on_silence();

    bool in_time() const;
    void watch_until(canorb::TimePoint deadline);
    template <typename Call>
    void transmit(Call call);
    void say(std::string_view text);
    void show();

    canorb::Orb& orb_;
    Outputs outputs_;
    RoundImpl round_{*this};
    ActuationImpl actuation_{*this};
    canorb::ObjectRef round_object_;
    canorb::ObjectRef actuation_object_;
    Tank::Measurement measurement_;

    Plant plant_;
    SlotClock clock_;
    canorb::TimerId timer_{};
    std::optional<bool> inlet_open_;   ///< wanted, heard in this round
    std::optional<bool> outlet_open_;  ///< wanted, heard in this round
    canorb::TimePoint silence_deadline_{};
    canorb::TimerId silence_timer_{};
    PlantStatus status_;
    bool transmission_failed_ = false;
};

}  // namespace tank
