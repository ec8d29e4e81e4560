#include "control.hpp"

#include <gtest/gtest.h>

namespace tank {
namespace {

constexpr Valves closed{.inlet_open = false, .outlet_open = false};
constexpr Valves filling{.inlet_open = true, .outlet_open = true};
constexpr Valves draining{.inlet_open = false, .outlet_open = true};

Valves decide_once(int level_mm, bool inlet_open, int setpoint_cm = 50, int temperature_c = 20) {
    return Controller{}.decide(
        {static_cast<std::uint16_t>(level_mm), inlet_open, setpoint_cm, temperature_c});
}

TEST(Mode, is_normal_within_the_safe_range_ends_included) {
    EXPECT_EQ(mode_at(-260), Mode::alarm);
    EXPECT_EQ(mode_at(-250), Mode::normal);
    EXPECT_EQ(mode_at(20), Mode::normal);
    EXPECT_EQ(mode_at(250), Mode::normal);
    EXPECT_EQ(mode_at(260), Mode::alarm);
}

TEST(Controller, opens_the_inlet_only_below_the_band) {
    EXPECT_EQ(decide_once(399, false), filling);
    EXPECT_EQ(decide_once(400, false), draining);
    EXPECT_EQ(decide_once(0, false), filling);
    EXPECT_EQ(decide_once(1149, false, 125), filling);
    EXPECT_EQ(decide_once(1150, false, 125), draining);
}

TEST(Controller, closes_the_inlet_only_above_the_band) {
    EXPECT_EQ(decide_once(601, true), draining);
    EXPECT_EQ(decide_once(600, true), filling);
    EXPECT_EQ(decide_once(2000, true), draining);
    EXPECT_EQ(decide_once(851, true, 75), draining);
    EXPECT_EQ(decide_once(850, true, 75), filling);
}

TEST(Controller, leaves_the_inlet_as_it_is_within_the_band) {
    EXPECT_EQ(decide_once(500, true), filling);
    EXPECT_EQ(decide_once(500, false), draining);
}

TEST(Controller, goes_by_the_reported_inlet_and_not_by_what_it_wanted) {
    Controller controller;
    EXPECT_EQ(controller.decide({.level_mm = 399, .inlet_open = false}), filling);
    // The node at the tank did not get that.
    EXPECT_EQ(controller.decide({.level_mm = 450, .inlet_open = false}), draining);
}

TEST(Controller, closes_everything_in_alarm_and_comes_back_by_itself) {
    Controller controller;
    EXPECT_EQ(controller.decide({.level_mm = 300, .temperature_c = 260}), closed);
    EXPECT_EQ(controller.decide({.level_mm = 300, .temperature_c = -260}), closed);
    EXPECT_EQ(controller.decide({.level_mm = 300, .temperature_c = 250}), filling);
}

TEST(Controller, without_a_level_keeps_what_it_wanted_for_two_rounds) {
    Controller controller;
    ASSERT_EQ(controller.decide({.level_mm = 300}), filling);
    EXPECT_EQ(controller.decide({.level_mm = {}, .inlet_open = true}), filling);
    EXPECT_EQ(controller.decide({.level_mm = {}, .inlet_open = true}), filling);
    EXPECT_EQ(controller.rounds_without_level(), 2U);
    EXPECT_EQ(controller.decide({.level_mm = {}, .inlet_open = true}), closed);
    EXPECT_EQ(controller.decide({.level_mm = {}, .inlet_open = true}), closed);
}

TEST(Controller, counts_only_rounds_in_a_row) {
    Controller controller;
    for (int i = 0; i < 3; ++i) {
        ASSERT_EQ(controller.decide({.level_mm = 300}), filling);
        EXPECT_EQ(controller.decide({.level_mm = {}}), filling);
        EXPECT_EQ(controller.decide({.level_mm = {}}), filling);
    }
}

TEST(Controller, in_alarm_needs_no_level_to_close) {
    Controller controller;
    ASSERT_EQ(controller.decide({.level_mm = 300}), filling);
    EXPECT_EQ(controller.decide({.level_mm = {}, .temperature_c = 260}), closed);
}

TEST(Controller, that_never_heard_a_level_opens_nothing) {
    Controller controller;
    EXPECT_EQ(controller.decide({}), closed);
}

TEST(Controller, works_again_when_the_level_is_back) {
    Controller controller;
    for (int i = 0; i < 5; ++i) (void)controller.decide({});
    EXPECT_EQ(controller.decide({.level_mm = 700}), draining);
    EXPECT_EQ(controller.rounds_without_level(), 0U);
}

}  // namespace
}  // namespace tank
