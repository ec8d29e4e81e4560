#include "tests/plant/world.hpp"

namespace plant::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(WholePlant, a_sensor_shows_its_values_its_controller_and_its_groups) {
    s[0]->type("value temperature 33.5");
    s[0]->type("raise pressure 0.5");
    s[0]->type("lower level 60");
    EXPECT_EQ(s[0]->panel(),
              "| temperature    33.5 C| pressure        2.5 bar| level         -10.0 %"
              "| controller node 1| in group 2| polled 2 times|");
    rounds(1);
    EXPECT_THAT(c->panel(), HasSubstr("|+temperature       70.0 C        33.5       20.0 |"));
}

TEST_F(WholePlant, a_sensor_in_two_groups_is_polled_in_both) {
    s[0]->type("join 5");
    const std::string first_group = sensor_group;
    sensor_group = reference_in(s[0]->log);
    EXPECT_NE(sensor_group, first_group);
    // It answers the controller that introduced itself last.
    auto second = controller(2);
    rounds(3);
    EXPECT_THAT(s[0]->panel(), HasSubstr("| controller node 2| in group 2 5|"));
    EXPECT_THAT(second->panel(), HasSubstr("sensor 11"));
    EXPECT_THAT(second->panel(), Not(HasSubstr("sensor 12")));
    EXPECT_THAT(s[1]->panel(), HasSubstr("| controller node 1| in group 2|"));
}

TEST_F(WholePlant, a_sensor_says_once_that_its_controller_does_not_answer) {
    // Another one polls, and the controller that it knows is gone.
    canorb::Orb other{bus, {.node = 3}};
    const auto group = other.string_to_object(sensor_group).narrow<Plant::Sensor>();
    c.reset();
    for (int poll = 0; poll < 2; ++poll) {
        group.poll();
        simulation.run_for(500ms);
    }
    EXPECT_THAT(s[0]->log, HasSubstr("the controller does not answer: "));
    EXPECT_EQ(s[0]->log.find("does not answer"), s[0]->log.rfind("does not answer"));
    EXPECT_THAT(s[0]->panel(), HasSubstr("|!controller node 1 is silent|"));
    c = controller();
    rounds(2);
    EXPECT_THAT(s[0]->log, HasSubstr("the controller is back\n"));
    EXPECT_THAT(s[0]->panel(), HasSubstr("| controller node 1|"));
}

TEST_F(WholePlant, a_sensor_keeps_its_controller_when_it_is_given_a_wrong_one) {
    canorb::Orb other{bus, {.node = 3}};
    const auto group = other.string_to_object(sensor_group).narrow<Plant::Sensor>();
    for (const std::string& wrong : {std::string{}, std::string{"CAN_IOR:01"},
                                     std::string{"corbaloc:caniop:1/1"}, sensor_group}) {
        group.initialize(wrong);
        simulation.run_for(50ms);
        EXPECT_THAT(s[0]->panel(), HasSubstr("| controller node 1|")) << wrong;
    }
    EXPECT_THAT(s[0]->log, HasSubstr("initialize: INV_OBJREF"));
    EXPECT_THAT(s[0]->log,
                HasSubstr("initialize: not a controller's reference: corbaloc:caniop:1/1\n"));
    rounds(1);
    EXPECT_EQ(on(), all_on);
}

TEST_F(PlantTest, a_sensor_that_knows_no_controller_does_not_answer) {
    auto node = sensor(11);
    canorb::Orb other{bus, {.node = 3}};
    other.string_to_object(sensor_group).narrow<Plant::Sensor>().poll();
    simulation.run_for(500ms);
    EXPECT_EQ(frames.size(), 1U);
    EXPECT_THAT(node->panel(), HasSubstr("|!no controller yet| in group 2| polled 1 times|"));
}

TEST_F(PlantTest, a_sensors_values_stay_within_reason) {
    auto node = sensor(11);
    node->type("value temperature 999");
    node->type("raise temperature 5");
    EXPECT_EQ(node->device.value(Variable::temperature), 1000.0F);
    node->type("lower temperature 1000");
    node->type("lower temperature 1000");
    node->type("lower temperature 1000");
    EXPECT_EQ(node->device.value(Variable::temperature), -1000.0F);
    for (const char* command : {"limit level 3", "forget 3", "join 2", "leave 3"})
        EXPECT_THROW(node->type(command), std::invalid_argument) << command;
}

}  // namespace
}  // namespace plant::test
