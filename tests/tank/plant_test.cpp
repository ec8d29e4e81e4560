#include "plant.hpp"

#include <gtest/gtest.h>

namespace tank {
namespace {

using namespace std::chrono_literals;

void step(Plant& plant, int times) {
    for (int i = 0; i < times; ++i) plant.step();
}

TEST(Plant, starts_full_and_closed) {
    Plant plant;
    EXPECT_EQ(plant.level_mm(), 2000);
    EXPECT_EQ(plant.valves(), (Valves{false, false}));
    step(plant, 100);
    EXPECT_EQ(plant.level_mm(), 2000);
    EXPECT_FALSE(plant.overflowing());
}

TEST(Plant, falls_one_millimetre_a_step_through_the_outlet) {
    Plant plant;
    plant.set_valves({.inlet_open = false, .outlet_open = true});
    step(plant, 1);
    EXPECT_EQ(plant.level_mm(), 1999);
    step(plant, 999);
    EXPECT_EQ(plant.level_mm(), 1000);
}

TEST(Plant, rises_by_one_with_both_open_and_by_two_with_the_inlet_alone) {
    Plant plant;
    plant.set_valves({.inlet_open = false, .outlet_open = true});
    step(plant, 1000);
    plant.set_valves({.inlet_open = true, .outlet_open = true});
    step(plant, 10);
    EXPECT_EQ(plant.level_mm(), 1010);
    plant.set_valves({.inlet_open = true, .outlet_open = false});
    step(plant, 10);
    EXPECT_EQ(plant.level_mm(), 1030);
    plant.set_valves({});
    step(plant, 10);
    EXPECT_EQ(plant.level_mm(), 1030);
}

TEST(Plant, is_empty_at_the_bottom_and_no_less) {
    Plant plant;
    plant.set_valves({.inlet_open = false, .outlet_open = true});
    step(plant, 2000);
    EXPECT_EQ(plant.level_mm(), 0);
    step(plant, 1);
    EXPECT_EQ(plant.level_mm(), 0);
    EXPECT_FALSE(plant.overflowing());
}

TEST(Plant, runs_over_at_the_top_and_tells) {
    Plant plant;
    plant.set_valves({.inlet_open = false, .outlet_open = true});
    step(plant, 1);
    plant.set_valves({.inlet_open = true, .outlet_open = false});
    EXPECT_FALSE(plant.overflowing());
    step(plant, 1);  // 1999 + 2
    EXPECT_EQ(plant.level_mm(), 2000);
    EXPECT_TRUE(plant.overflowing());
    plant.set_valves({});
    step(plant, 1);
    EXPECT_FALSE(plant.overflowing());
}

TEST(Plant, just_full_is_not_over) {
    Plant plant;
    plant.set_valves({.inlet_open = false, .outlet_open = true});
    step(plant, 2);
    plant.set_valves({.inlet_open = true, .outlet_open = false});
    step(plant, 1);  // 1998 + 2
    EXPECT_EQ(plant.level_mm(), 2000);
    EXPECT_FALSE(plant.overflowing());
}

TEST(StepsDue, makes_every_step_once_however_late) {
    StepsDue steps;
    EXPECT_EQ(steps.take(0ms), 0U);
    EXPECT_EQ(steps.take(4999us), 0U);
    EXPECT_EQ(steps.take(5ms), 1U);
    EXPECT_EQ(steps.take(5ms), 0U);
    EXPECT_EQ(steps.take(27ms), 4U);
    EXPECT_EQ(steps.take(30ms), 1U);
}

}  // namespace
}  // namespace tank
