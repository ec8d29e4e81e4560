// Node A against a tank that reports whatever the test wants.

#include "node_a.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <canorb/simulation.hpp>

#include <string>
#include <thread>
#include <vector>

#include "groups.hpp"

namespace tank {
namespace {

using namespace std::chrono_literals;
using canorb::Duration;
using canorb::TimePoint;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

using Heard = std::vector<std::string>;

std::string text_of(Tank::Valve position) {
    return position == Tank::Valve::open ? "open" : "closed";
}

class RoundListener final : public Tank::RoundServant {
  public:
    explicit RoundListener(Heard& heard) : heard_(heard) {}
    void sync() override { heard_.emplace_back("sync"); }
    void slot_duration(std::uint16_t milliseconds) override {
        heard_.push_back("slots " + std::to_string(milliseconds));
    }

  private:
    Heard& heard_;
};

class ActuationListener final : public Tank::ActuationServant {
  public:
    explicit ActuationListener(Heard& heard) : heard_(heard) {}
    void inlet(Tank::Valve position) override { heard_.push_back("VE " + text_of(position)); }
    void outlet(Tank::Valve position) override { heard_.push_back("VS " + text_of(position)); }
    void temperature(std::int16_t celsius) override {
        heard_.push_back(std::to_string(celsius) + " C");
    }

  private:
    Heard& heard_;
};

// An ORB that hears all that node A sends.
struct Listener {
    explicit Listener(canorb::Bus& bus) : orb(bus, {.node = 2}) {
        orb.object_join(orb.root_poa().activate_object(round), round_group);
        orb.object_join(orb.root_poa().activate_object(actuation), actuation_group);
    }

    Heard heard;
    canorb::Orb orb;
    RoundListener round{heard};
    ActuationListener actuation{heard};
    Tank::Measurement measurement =
        orb.group_reference(measurement_group).narrow<Tank::Measurement>();
};

class NodeATest : public testing::Test {
  protected:
    void at(Duration time, std::function<void()> what) {
        simulation_.at(TimePoint{time}, std::move(what));
    }
    void level_at(Duration time, std::uint16_t mm) {
        at(time, [this, mm] { plant_.measurement.level(mm); });
    }
    // What was heard in that time.
    Heard run_until(Duration time) {
        plant_.heard.clear();
        simulation_.run_until(TimePoint{time});
        return plant_.heard;
    }

    canorb::Simulation simulation_;
    canorb::SimulatedBus& bus_ = simulation_.add_bus();
    canorb::Orb orb_{bus_, {.node = 1}};
    Listener plant_{bus_};
    std::string terminal_;
    LocalOperatorLine line_{[this](std::string_view text) { terminal_ += text; }};
    NodeA node_{orb_, line_, {}};
};

TEST_F(NodeATest, sends_what_belongs_into_each_slot) {
    level_at(60ms, 1000);
    EXPECT_THAT(run_until(1ms), ElementsAre("sync"));
    EXPECT_THAT(run_until(249ms), IsEmpty());
    EXPECT_THAT(run_until(252ms), ElementsAre("VE closed", "VS open", "20 C"));
    EXPECT_THAT(run_until(499ms), IsEmpty());
    EXPECT_THAT(run_until(501ms), ElementsAre("slots 50"));
    EXPECT_THAT(run_until(599ms), IsEmpty());
    EXPECT_THAT(run_until(601ms), ElementsAre("sync"));
    EXPECT_EQ(node_.status().round, 2U);
}

TEST_F(NodeATest, keeps_the_inlet_as_reported_within_the_band) {
    level_at(60ms, 500);
    at(110ms, [this] { plant_.measurement.inlet_state(Tank::Valve::open); });
    level_at(660ms, 500);
    at(710ms, [this] { plant_.measurement.inlet_state(Tank::Valve::closed); });
    EXPECT_THAT(run_until(600ms), Contains("VE open"));
    EXPECT_THAT(run_until(1200ms), Contains("VE closed"));
}

TEST_F(NodeATest, keeps_its_actuation_for_two_rounds_without_a_level_and_closes_then) {
    level_at(60ms, 300);
    EXPECT_THAT(run_until(599ms), ElementsAre("sync", "VE open", "VS open", "20 C", "slots 50"));
    EXPECT_FALSE(node_.status().level_stale);
    EXPECT_THAT(run_until(1199ms), ElementsAre("sync", "VE open", "VS open", "20 C", "slots 50"));
    EXPECT_TRUE(node_.status().level_stale);
    EXPECT_EQ(node_.status().level_mm, 300);
    EXPECT_THAT(run_until(1799ms), ElementsAre("sync", "VE open", "VS open", "20 C", "slots 50"));
    EXPECT_THAT(run_until(2399ms),
                ElementsAre("sync", "VE closed", "VS closed", "20 C", "slots 50"));
    EXPECT_THAT(terminal_, HasSubstr("level 30.0 cm STALE"));
    level_at(2450ms, 300);
    EXPECT_THAT(run_until(2999ms), ElementsAre("sync", "VE open", "VS open", "20 C", "slots 50"));
    EXPECT_FALSE(node_.status().level_stale);
}

TEST_F(NodeATest, sends_the_temperature_as_measured) {
    node_.set_temperature(-300);
    level_at(60ms, 300);
    EXPECT_THAT(run_until(599ms),
                ElementsAre("sync", "VE closed", "VS closed", "-300 C", "slots 50"));
    EXPECT_EQ(node_.status().mode, Mode::alarm);
}

TEST_F(NodeATest, changes_its_slots_with_the_next_round) {
    line_.type('l');
    EXPECT_THAT(run_until(599ms), Contains("slots 100"));
    EXPECT_EQ(node_.status().slot_length, 50ms);
    EXPECT_THAT(run_until(601ms), ElementsAre("sync"));
    EXPECT_EQ(node_.status().slot_length, 100ms);
    EXPECT_THAT(run_until(1599ms), Not(Contains("slots 100")));
    EXPECT_THAT(run_until(1601ms), ElementsAre("slots 100"));
}

TEST_F(NodeATest, obeys_no_character_that_is_no_order) {
    line_.type('\x1b');
    line_.type('z');
    run_until(1200ms);
    EXPECT_THAT(terminal_, HasSubstr("0x1B is no order\r\n"));
    EXPECT_THAT(terminal_, HasSubstr("'z' is no order\r\n"));
    EXPECT_EQ(node_.status().setpoint_cm, 50);
    EXPECT_EQ(node_.status().slot_length, 50ms);
}

TEST(NodeA, can_be_replaced_on_the_same_orb) {
    canorb::Simulation simulation;
    canorb::SimulatedBus& bus = simulation.add_bus();
    canorb::Orb orb{bus, {.node = 1}};
    Listener listener{bus};
    LocalOperatorLine line;
    for (int i = 0; i < 3; ++i) {
        // Gone in the middle of slot 5, its callbacks pending.
        NodeA node{orb, line, {}};
        simulation.run_for(250'200us);
    }
    simulation.run_for(5s);
    // What was begun is sent, and nothing after it.
    EXPECT_THAT(listener.heard, UnorderedElementsAre("sync", "VE closed", "sync", "VE closed",
                                                     "sync", "VE closed"));
}

// In real time: a node that does not get to run must not send what belonged into slots gone by.
TEST(NodeA, that_slept_leaves_out_the_slots_it_missed) {
    const auto bus = canorb::open_bus("local:node_a_test");
    canorb::Orb orb{*bus, {.node = 1}};
    Listener listener{*bus};
    LocalOperatorLine line;
    NodeA node{orb, line, {}};
    orb.run_for(10ms);
    // To the middle of slot 6 or later: slots 4 and 5 are gone, whatever this machine does.
    std::this_thread::sleep_for(330ms);
    orb.run_for(20ms);
    listener.orb.run_for(10ms);
    EXPECT_THAT(listener.heard, Contains("sync"));
    EXPECT_THAT(listener.heard, Not(Contains("VE closed")));
    EXPECT_THAT(listener.heard, Not(Contains("20 C")));
}

}  // namespace
}  // namespace tank
