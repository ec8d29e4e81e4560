// What the plant does, on virtual time. A round is 500 ms; the tests look 100 ms into one.

#include "tests/plant/world.hpp"

namespace plant::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(WholePlant, switches_on_when_all_is_well) {
    EXPECT_EQ(on(), all_on);
    EXPECT_THAT(c->log, HasSubstr("sensor 11 is new\n"));
    EXPECT_THAT(c->log, HasSubstr("sensor 12 is new\n"));
    EXPECT_THAT(c->log, HasSubstr("actuators on: all within their limits\n"));
    EXPECT_EQ(c->panel(),
              "| round 2              limit  sensor 11  sensor 12"
              "|+temperature       70.0 C        20.0       20.0 "
              "|+pressure           5.0 bar       2.0        2.0 "
              "|+level             90.0 %        50.0       50.0 "
              "|                               answers    answers"
              "|+actuators ON: all within their limits|");
}

TEST_F(WholePlant, one_value_over_its_limit_switches_off_exactly_the_group) {
    // One that is on, and no member any more.
    auto other = actuator(24);
    rounds(1);
    ASSERT_TRUE(other->device.is_on());
    other->type("leave 1");

    s[1]->type("value temperature 80");
    rounds(1);
    EXPECT_EQ(on(), all_off);
    EXPECT_TRUE(other->device.is_on());
    EXPECT_THAT(c->log, HasSubstr("actuators off: temperature of sensor 12 over its limit\n"));
    EXPECT_THAT(c->panel(), HasSubstr("|!temperature       70.0 C        20.0       80.0!|"));
    EXPECT_THAT(c->panel(), HasSubstr("|!actuators OFF: temperature of sensor 12"));

    s[1]->type("value temperature 70");
    rounds(2);
    EXPECT_EQ(on(), all_on);
}

TEST_F(WholePlant, a_reason_to_switch_off_does_not_wait_for_the_end_of_the_round) {
    s[0]->type("value level 95");
    simulation.run_for(395ms);  // the round before ends in 5 ms
    EXPECT_EQ(on(), all_on);
    simulation.run_for(15ms);  // polled, answered, switched
    EXPECT_EQ(on(), all_off);
}

TEST_F(WholePlant, switching_on_waits_for_the_end_of_a_round) {
    s[0]->type("value level 95");
    rounds(1);
    ASSERT_EQ(on(), all_off);
    s[0]->type("value level 50");
    rounds(1);  // told in this round
    EXPECT_EQ(on(), all_off);
    rounds(1);
    EXPECT_EQ(on(), all_on);
}

TEST_F(WholePlant, a_limit_is_changed_while_it_runs) {
    c->type("limit temperature 15");
    simulation.run_for(5ms);  // at once: the values are known
    EXPECT_EQ(on(), all_off);
    EXPECT_THAT(c->panel(), HasSubstr("|!temperature       15.0 C        20.0!      20.0!|"));
    c->type("raise temperature 5");
    rounds(1);
    EXPECT_EQ(on(), all_on);
    c->type("lower pressure 3.5");
    simulation.run_for(5ms);
    EXPECT_EQ(on(), all_off);
    EXPECT_EQ(c->device.supervisor().limit(Variable::pressure), 1.5F);
}

TEST_F(WholePlant, a_sensor_that_dies_is_stale_and_switches_off) {
    s[1].reset();
    rounds(3);
    EXPECT_EQ(on(), all_on);
    EXPECT_THAT(c->panel(), Not(HasSubstr("STALE")));
    rounds(1);
    EXPECT_EQ(on(), all_off);
    EXPECT_THAT(c->panel(), HasSubstr("|!                              answers      STALE|"));
    EXPECT_THAT(c->panel(), HasSubstr("|!actuators OFF: sensor 12 is silent|"));
    EXPECT_THAT(c->log, HasSubstr("actuators off: sensor 12 is silent\n"));

    // A new one in its place: it is told whom to answer in the next round, and the round after it
    // begins with good news.
    s[1] = sensor(12);
    rounds(1);
    EXPECT_EQ(on(), all_off);
    rounds(1);
    EXPECT_EQ(on(), all_on);
}

TEST_F(WholePlant, a_sensor_that_is_new_is_told_whom_to_answer_within_ten_rounds) {
    auto late = sensor(13);
    rounds(8);  // round 10
    EXPECT_THAT(late->panel(), HasSubstr("|!no controller yet|"));
    EXPECT_THAT(c->panel(), Not(HasSubstr("sensor 13")));
    rounds(1);
    EXPECT_THAT(late->panel(), HasSubstr("| controller node 1|"));
    EXPECT_THAT(c->panel(), HasSubstr("sensor 13"));
}

TEST_F(WholePlant, a_sensor_that_is_gone_for_good_is_forgotten) {
    s[1].reset();
    rounds(4);
    ASSERT_EQ(on(), all_off);
    c->type("forget 12");
    rounds(1);
    EXPECT_EQ(on(), all_on);
    EXPECT_THAT(c->panel(), Not(HasSubstr("sensor 12")));
    EXPECT_THROW(c->type("forget 12"), std::invalid_argument);
}

TEST_F(WholePlant, a_sensor_leaves_its_group_and_joins_it_again) {
    s[0]->type("leave 2");
    EXPECT_THAT(s[0]->panel(), HasSubstr("|!in no group|"));
    rounds(4);
    EXPECT_THAT(c->panel(), HasSubstr("sensor 11 is silent"));
    s[0]->type("join 2");
    rounds(2);
    EXPECT_EQ(on(), all_on);
    EXPECT_THAT(s[0]->panel(), HasSubstr("| in group 2|"));
}

TEST_F(WholePlant, a_controller_that_is_started_again_does_not_switch_on_blindly) {
    s[1]->type("value temperature 80");
    rounds(1);
    ASSERT_EQ(on(), all_off);
    c.reset();
    c = controller();
    for (int step = 0; step < 300; ++step) {
        simulation.run_for(10ms);
        ASSERT_EQ(on(), all_off);
    }
    EXPECT_THAT(c->panel(), HasSubstr("temperature of sensor 12 over its limit"));
}

TEST_F(WholePlant, a_controller_takes_no_other_devices_commands) {
    for (const char* command : {"value temperature 3", "join 1", "leave 1"})
        EXPECT_THROW(c->type(command), std::invalid_argument) << command;
}

TEST_F(PlantTest, a_controller_says_which_reference_is_wrong) {
    auto one_sensor = sensor(11);
    auto one_actuator = actuator(21);
    const std::string good_sensors = sensor_group;
    const std::string good_actuators = actuator_group;
    const auto refusal = [&]() -> std::string {
        try {
            controller();
        } catch (const std::exception& error) {
            return error.what();
        }
        return "nothing";
    };
    actuator_group = good_sensors;
    EXPECT_THAT(refusal(), HasSubstr("no group of actuators: CAN_IOR:"));
    actuator_group = good_actuators;
    sensor_group = "corbaloc:caniop:11/1";
    EXPECT_THAT(refusal(), HasSubstr("no group of sensors: corbaloc:caniop:11/1"));
    sensor_group = "CAN_IOR:zz";
    EXPECT_THAT(refusal(), HasSubstr("INV_OBJREF"));
    sensor_group = "group 2";
    EXPECT_THAT(refusal(), HasSubstr("BAD_PARAM"));
    sensor_group = "corbaloc:caniop:group/2";
    EXPECT_EQ(refusal(), "nothing");
}

}  // namespace
}  // namespace plant::test
