#include "supervisor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace plant {
namespace {

// Limits: 70 C, 5 bar, 90 %.
class SupervisorTest : public testing::Test {
  protected:
    void report(int sensor, float temperature = 20, float pressure = 2, float level = 50) {
        supervisor.take(sensor, Variable::temperature, temperature);
        supervisor.take(sensor, Variable::pressure, pressure);
        supervisor.take(sensor, Variable::level, level);
    }
    bool on() const { return supervisor.verdict().on; }
    std::string reason() const { return supervisor.verdict().reason; }

    Supervisor supervisor;
};

TEST_F(SupervisorTest, without_a_sensor_nothing_may_be_on) {
    EXPECT_FALSE(on());
    EXPECT_EQ(reason(), "no sensor has answered");
    EXPECT_TRUE(supervisor.misses_somebody());
}

TEST_F(SupervisorTest, a_sensor_within_all_limits_allows_it) {
    report(11);
    EXPECT_TRUE(on());
    EXPECT_EQ(reason(), "all within their limits");
}

TEST_F(SupervisorTest, a_sensor_must_have_told_every_variable) {
    supervisor.take(11, Variable::temperature, 20);
    supervisor.take(11, Variable::pressure, 2);
    EXPECT_FALSE(on());
    EXPECT_EQ(reason(), "sensor 11 has not told all");
    supervisor.take(11, Variable::level, 50);
    EXPECT_TRUE(on());
}

TEST_F(SupervisorTest, the_limit_itself_is_allowed) {
    report(11, 70, 5, 90);
    EXPECT_TRUE(on());
}

TEST_F(SupervisorTest, any_variable_of_any_sensor_over_its_limit_forbids_it) {
    report(11);
    report(12, 70.5F);
    EXPECT_EQ(reason(), "temperature of sensor 12 over its limit");
    report(12, 20, 5.5F);
    EXPECT_EQ(reason(), "pressure of sensor 12 over its limit");
    report(12, 20, 2, 91);
    EXPECT_EQ(reason(), "level of sensor 12 over its limit");
    // One sensor's good value does not hide the other's bad one.
    report(11);
    EXPECT_FALSE(on());
    report(12);
    EXPECT_TRUE(on());
}

TEST_F(SupervisorTest, what_is_no_number_is_over_every_limit) {
    report(11, std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(reason(), "temperature of sensor 11 over its limit");
}

TEST_F(SupervisorTest, limits_can_be_changed) {
    report(11, 60);
    supervisor.set_limit(Variable::temperature, 59);
    EXPECT_FALSE(on());
    supervisor.set_limit(Variable::temperature, 60);
    EXPECT_TRUE(on());
}

TEST_F(SupervisorTest, three_silent_rounds_make_a_sensor_stale) {
    report(11);
    supervisor.end_round();
    supervisor.end_round();
    supervisor.end_round();
    EXPECT_TRUE(on());  // it reported in the first of them
    supervisor.end_round();
    EXPECT_TRUE(supervisor.sensors().at(11).stale());
    EXPECT_TRUE(supervisor.misses_somebody());
    EXPECT_EQ(reason(), "sensor 11 is silent");
    report(11);
    EXPECT_FALSE(supervisor.misses_somebody());
    EXPECT_FALSE(supervisor.sensors().at(11).stale());
    EXPECT_TRUE(on());
}

TEST_F(SupervisorTest, half_an_answer_is_none) {
    report(11);
    supervisor.end_round();
    for (int round = 0; round < 3; ++round) {
        supervisor.take(11, Variable::temperature, 20);
        supervisor.end_round();
    }
    EXPECT_TRUE(supervisor.sensors().at(11).stale());
}

TEST_F(SupervisorTest, a_stale_value_over_its_limit_is_still_over_it) {
    report(11, 80);
    for (int round = 0; round < 4; ++round) supervisor.end_round();
    EXPECT_EQ(reason(), "temperature of sensor 11 over its limit");
}

TEST_F(SupervisorTest, a_forgotten_sensor_does_not_count) {
    report(11);
    report(12, 80);
    EXPECT_FALSE(supervisor.forget(13));
    EXPECT_TRUE(supervisor.forget(12));
    EXPECT_TRUE(on());
}

}  // namespace
}  // namespace plant
