// Node B against a controller that does whatever the test wants.

#include "node_b.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <canorb/simulation.hpp>

#include <string>
#include <vector>

#include "groups.hpp"

namespace tank {
namespace {

using namespace std::chrono_literals;
using canorb::Duration;
using canorb::TimePoint;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

// What node B's messages say, and when they came.
class Listener final : public Tank::MeasurementServant {
  public:
    Listener(canorb::Orb& orb, std::vector<std::string>& heard) : orb_(orb), heard_(heard) {}
    void level(std::uint16_t millimetres) override { note("level " + std::to_string(millimetres)); }
    void inlet_state(Tank::Valve position) override { note("inlet", position); }
    void outlet_state(Tank::Valve position) override { note("outlet", position); }

  private:
    void note(const std::string& what, Tank::Valve position) {
        note(what + (position == Tank::Valve::open ? " open" : " closed"));
    }
    void note(const std::string& text) {
        const auto ms =
            std::chrono::duration_cast<std::chrono::milliseconds>(orb_.now().time_since_epoch());
        heard_.push_back(std::to_string(ms.count()) + " " + text);
    }
    canorb::Orb& orb_;
    std::vector<std::string>& heard_;
};

class NodeBTest : public testing::Test {
  protected:
    NodeBTest() {
        controller_.object_join(controller_.root_poa().activate_object(listener_),
                                measurement_group);
        simulation_.every(5ms, simulation_.now() + 5ms, [this] { node_.pass_time(1); });
    }

    void at(Duration time, std::function<void()> what) {
        simulation_.at(TimePoint{time}, std::move(what));
    }
    void sync_at(Duration time) {
        at(time, [this] { round_.sync(); });
    }
    void actuation_at(Duration time, bool inlet_open, bool outlet_open) {
        const auto position = [](bool open) {
            return open ? Tank::Valve::open : Tank::Valve::closed;
        };
        at(time, [this, inlet = position(inlet_open), outlet = position(outlet_open)] {
            actuation_.inlet(inlet);
            actuation_.outlet(outlet);
        });
    }
    void slot_duration_at(Duration time, std::uint16_t ms) {
        at(time, [this, ms] { round_.slot_duration(ms); });
    }
    void run_until(Duration time) { simulation_.run_until(TimePoint{time}); }

    canorb::Simulation simulation_;
    canorb::SimulatedBus& bus_ = simulation_.add_bus();
    canorb::Orb controller_{bus_, {.node = 1}};
    canorb::Orb orb_{bus_, {.node = 2}};
    std::vector<std::string> heard_;
    std::vector<std::string> said_;
    Listener listener_{controller_, heard_};
    Tank::Round round_ = controller_.group_reference(round_group).narrow<Tank::Round>();
    Tank::Actuation actuation_ =
        controller_.group_reference(actuation_group).narrow<Tank::Actuation>();
    NodeB node_{orb_,
                {.display = {},
                 .log = [this](std::string_view text) { said_.emplace_back(text); },
                 .round_applied = {}}};
};

TEST_F(NodeBTest, says_nothing_on_the_bus_before_the_first_sync) {
    actuation_at(100ms, true, true);
    run_until(1700ms);
    EXPECT_THAT(heard_, IsEmpty());
    EXPECT_EQ(node_.status().valves, Valves{});
    EXPECT_FALSE(node_.status().controller_silent);
    run_until(1801ms);
    EXPECT_TRUE(node_.status().controller_silent);
    EXPECT_THAT(said_, ElementsAre("no actuation for 3 rounds of 50 ms slots: both valves closed"));
}

TEST_F(NodeBTest, sends_its_three_messages_once_for_each_sync) {
    sync_at(10ms);
    run_until(5s);
    // Sync is on the bus for less than 0.3 ms, a value for less than 0.5 ms.
    EXPECT_THAT(heard_, ElementsAre("60 level 2000", "110 inlet closed", "160 outlet closed"));
}

TEST_F(NodeBTest, applies_both_valves_in_slot_6) {
    sync_at(0ms);
    actuation_at(250ms, true, true);
    run_until(299ms);
    EXPECT_EQ(node_.status().valves, Valves{});
    run_until(301ms);
    EXPECT_EQ(node_.status().valves, (Valves{true, true}));
    EXPECT_EQ(panel_of(node_.status()).leds, (std::array<bool, 2>{true, true}));
}

TEST_F(NodeBTest, applies_no_half_of_a_pair) {
    sync_at(0ms);
    at(250ms, [this] { actuation_.inlet(Tank::Valve::open); });
    sync_at(600ms);
    // Nor two halves from two rounds.
    at(850ms, [this] { actuation_.outlet(Tank::Valve::open); });
    run_until(1200ms);
    EXPECT_EQ(node_.status().valves, Valves{});
}

TEST_F(NodeBTest, starts_its_timer_again_at_every_sync) {
    sync_at(0ms);
    sync_at(120ms);
    run_until(1s);
    EXPECT_THAT(heard_, ElementsAre("50 level 2000", "100 inlet closed", "170 level 2000",
                                    "220 inlet closed", "270 outlet closed"));
}

TEST_F(NodeBTest, takes_a_new_slot_duration_at_the_next_sync) {
    sync_at(0ms);
    slot_duration_at(20ms, 10);
    sync_at(600ms);
    run_until(1s);
    EXPECT_THAT(heard_, ElementsAre("50 level 2000", "100 inlet closed", "150 outlet closed",
                                    "610 level 2000", "620 inlet closed", "630 outlet closed"));
    EXPECT_EQ(node_.status().slot_length, 10ms);
}

TEST_F(NodeBTest, ignores_slots_of_no_length) {
    slot_duration_at(0ms, 0);
    sync_at(10ms);
    run_until(100ms);
    EXPECT_EQ(node_.status().slot_length, 50ms);
    EXPECT_THAT(heard_, ElementsAre("60 level 2000"));
}

TEST_F(NodeBTest, shows_the_temperature_that_it_is_sent) {
    at(0ms, [this] { actuation_.temperature(-300); });
    run_until(10ms);
    EXPECT_EQ(node_.status().temperature_c, -300);
}

TEST_F(NodeBTest, closes_both_valves_when_only_actuations_stop) {
    for (int round = 0; round < 10; ++round) sync_at(round * 600ms);
    actuation_at(250ms, false, true);
    // Applied at the begin of its slot 6, 0.23 ms after 300 ms; three rounds are 1800 ms.
    run_until(2099ms);
    EXPECT_EQ(node_.status().valves, (Valves{false, true}));
    EXPECT_THAT(said_, IsEmpty());
    run_until(2101ms);
    EXPECT_EQ(node_.status().valves, Valves{});
    EXPECT_TRUE(node_.status().controller_silent);
    EXPECT_THAT(said_, ElementsAre("no actuation for 3 rounds of 50 ms slots: both valves closed"));
}

TEST_F(NodeBTest, hears_a_controller_that_comes_back) {
    sync_at(2s);
    actuation_at(2250ms, false, true);
    run_until(2299ms);
    EXPECT_TRUE(node_.status().controller_silent);
    run_until(2301ms);
    EXPECT_FALSE(node_.status().controller_silent);
    EXPECT_EQ(node_.status().valves, (Valves{false, true}));
    EXPECT_THAT(said_, ElementsAre(StartsWith("no actuation"), "the controller is back"));
}

TEST_F(NodeBTest, counts_the_silence_in_slots_as_long_as_they_were) {
    sync_at(0ms);
    actuation_at(250ms, false, true);
    slot_duration_at(500ms, 5);
    // From 300.23 ms to the sync at 600.23 ms: 6 slots of 50 ms; then 30 of 5 ms.
    sync_at(600ms);
    sync_at(660ms);
    sync_at(720ms);
    run_until(750ms);
    EXPECT_THAT(said_, IsEmpty());
    run_until(751ms);
    EXPECT_THAT(said_, ElementsAre("no actuation for 3 rounds of 5 ms slots: both valves closed"));
}

TEST_F(NodeBTest, tells_that_the_tank_runs_over_once) {
    sync_at(0ms);
    actuation_at(250ms, true, true);
    run_until(1s);
    EXPECT_TRUE(node_.status().overflowing);
    EXPECT_EQ(panel_of(node_.status()).lines[0].substr(12), "OVER");
    EXPECT_EQ(node_.status().level_mm, 2000);
    EXPECT_THAT(said_, ElementsAre("the tank runs over"));
}

TEST(NodeB, can_be_replaced_on_the_same_orb) {
    canorb::Simulation simulation;
    canorb::SimulatedBus& bus = simulation.add_bus();
    canorb::Orb controller{bus, {.node = 1}};
    canorb::Orb orb{bus, {.node = 2}};
    const auto round = controller.group_reference(round_group).narrow<Tank::Round>();
    for (int i = 0; i < 3; ++i) {
        NodeB node{orb, {}};
        round.sync();
        simulation.run_for(70ms);
    }
    simulation.run_for(5s);
}

}  // namespace
}  // namespace tank
