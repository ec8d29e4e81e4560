#include "display.hpp"

#include <gtest/gtest.h>

namespace tank {
namespace {

using namespace std::chrono_literals;

void expect_two_lines_of_sixteen(const Panel& panel) {
    EXPECT_EQ(panel.lines[0].size(), 16U) << panel.lines[0];
    EXPECT_EQ(panel.lines[1].size(), 16U) << panel.lines[1];
}

TEST(PanelOfA, shows_mode_slot_setpoint_and_wanted_valves) {
    const Panel panel = panel_of(ControllerStatus{.wanted = {false, true}});
    EXPECT_EQ(panel.lines[0], "N  50ms SP  50cm");
    EXPECT_EQ(panel.lines[1], "VS A VE C       ");
    EXPECT_EQ(panel.leds, (std::array<bool, 2>{false, false}));
}

TEST(PanelOfA, has_room_for_the_widest_values) {
    const Panel panel = panel_of(ControllerStatus{.mode = Mode::alarm,
                                                  .slot_length = 100ms,
                                                  .setpoint_cm = 125,
                                                  .level_stale = true,
                                                  .wanted = {true, false}});
    EXPECT_EQ(panel.lines[0], "A 100ms SP 125cm");
    EXPECT_EQ(panel.lines[1], "VS C VE A  STALE");
}

TEST(PanelOfB, shows_slot_temperature_level_and_valves) {
    const Panel panel = panel_of(PlantStatus{
        .slot_length = 5ms, .temperature_c = 20, .level_mm = 1999, .valves = {true, false}});
    EXPECT_EQ(panel.lines[0], "  5ms   20C     ");
    EXPECT_EQ(panel.lines[1], "199cm VE A VS C ");
    EXPECT_EQ(panel.leds, (std::array<bool, 2>{true, false}));
}

TEST(PanelOfB, has_room_for_the_widest_values) {
    const Panel panel = panel_of(PlantStatus{.slot_length = 100ms,
                                             .temperature_c = -500,
                                             .level_mm = 2000,
                                             .valves = {true, true},
                                             .overflowing = true});
    EXPECT_EQ(panel.lines[0], "100ms -500C OVER");
    EXPECT_EQ(panel.lines[1], "200cm VE A VS A ");
    EXPECT_EQ(panel.leds, (std::array<bool, 2>{true, true}));
    expect_two_lines_of_sixteen(panel_of(PlantStatus{.level_mm = 0}));
}

TEST(PanelOfB, tells_that_the_controller_is_silent) {
    const Panel panel = panel_of(PlantStatus{.controller_silent = true});
    EXPECT_EQ(panel.lines[0], " 50ms  ---C LOST");
}

TEST(StatusText, names_everything_the_operator_needs) {
    EXPECT_EQ(
        status_text(ControllerStatus{.temperature_c = -30,
                                     .level_mm = 1234,
                                     .reported = {true, false},
                                     .wanted = {false, true}}),
        "mode normal, slot 50 ms, setpoint 50 cm, temperature -30 C, level 123.4 cm, VE open, "
        "VS closed");
    EXPECT_EQ(
        status_text(ControllerStatus{.mode = Mode::alarm, .slot_length = 5ms, .setpoint_cm = 125}),
        "mode alarm, slot 5 ms, setpoint 125 cm, temperature 20 C, level unknown, VE closed, "
        "VS closed");
}

TEST(StatusText, marks_a_level_that_is_not_this_rounds) {
    const std::string text = status_text(ControllerStatus{.level_mm = 7, .level_stale = true});
    EXPECT_NE(text.find("level 0.7 cm STALE,"), std::string::npos) << text;
}

TEST(StatusText, fits_into_slots_6_to_9_at_115200_baud) {
    // 20 ms of 11520 characters a second.
    const std::string text = status_text(ControllerStatus{.mode = Mode::normal,
                                                          .slot_length = 100ms,
                                                          .setpoint_cm = 125,
                                                          .temperature_c = -500,
                                                          .level_mm = 2000,
                                                          .level_stale = true});
    EXPECT_LE(text.size() + 2, 230U);
}

}  // namespace
}  // namespace tank
