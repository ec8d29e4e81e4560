#include "tests/plant/world.hpp"

namespace plant::test {
namespace {

using testing::HasSubstr;

TEST_F(WholePlant, an_actuator_shows_its_state_its_controller_and_its_groups) {
    EXPECT_EQ(a[0]->panel(), "|+ON| controller node 1| in group 1|");
    s[0]->type("value level 95");
    rounds(1);
    EXPECT_EQ(a[0]->panel(), "|!OFF| controller node 1| in group 1|");
    EXPECT_THAT(a[0]->log, HasSubstr("on\noff\n"));
}

TEST_F(WholePlant, an_actuator_that_left_its_group_is_not_switched_and_one_that_joined_is) {
    a[1]->type("leave 1");
    s[0]->type("value level 95");
    rounds(1);
    EXPECT_EQ(on(), (std::vector<bool>{false, true, false}));
    rounds(10);  // nobody's, it stays as it is, however long
    EXPECT_EQ(on(), (std::vector<bool>{false, true, false}));
    a[1]->type("join 1");
    rounds(1);
    EXPECT_EQ(on(), all_off);
    s[0]->type("value level 50");
    rounds(2);
    EXPECT_EQ(on(), all_on);
}

TEST_F(WholePlant, an_actuator_switches_itself_off_when_the_controller_is_gone) {
    // Heard last 100 ms ago.
    c.reset();
    simulation.run_for(2890ms);
    EXPECT_EQ(on(), all_on);
    simulation.run_for(20ms);
    EXPECT_EQ(on(), all_off);
    EXPECT_THAT(a[2]->log, HasSubstr("told nothing for 3 s: off\n"));
    EXPECT_EQ(a[2]->panel(), "|!OFF|!controller node 1 is silent| in group 1|");
    c = controller();
    rounds(1);
    simulation.run_for(5ms);
    EXPECT_THAT(a[2]->log, HasSubstr("the controller is back\n"));
    EXPECT_THAT(a[2]->panel(), HasSubstr("| controller node 1|"));
}

TEST_F(WholePlant, an_actuator_in_a_group_that_nobody_calls_switches_itself_off) {
    a[0]->type("leave 1");
    rounds(10);
    ASSERT_TRUE(a[0]->device.is_on());
    a[0]->type("join 5");
    EXPECT_THAT(a[0]->panel(), HasSubstr("in group 5|"));
    simulation.run_for(2990ms);
    EXPECT_TRUE(a[0]->device.is_on());
    simulation.run_for(20ms);
    EXPECT_FALSE(a[0]->device.is_on());
}

TEST_F(PlantTest, an_actuator_is_off_at_first) {
    auto node = actuator(21, canorb::GroupId{7});
    EXPECT_EQ(node->panel(), "|!OFF|!no controller yet| in group 7|");
    EXPECT_THAT(node->log, HasSubstr("joined group 7: CAN_IOR:"));
}

TEST_F(PlantTest, an_actuator_says_which_command_is_wrong) {
    auto node = actuator(21);
    for (const char* command :
         {"value level 3", "limit level 3", "raise level 5", "forget 3", "join 1", "leave 2"})
        EXPECT_THROW(node->type(command), std::invalid_argument) << command;
    EXPECT_THAT(node->panel(), HasSubstr("| in group 1|"));
    node->type("join 31");
    EXPECT_THAT(node->panel(), HasSubstr("| in group 1 31|"));
}

}  // namespace
}  // namespace plant::test
