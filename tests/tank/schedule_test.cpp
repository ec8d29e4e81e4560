#include "schedule.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace tank {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

template <typename Parse>
std::string error_of(Parse parse, std::string_view text) {
    try {
        (void)parse(text);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "no error";
}

TEST(Seconds, are_exact) {
    EXPECT_EQ(parse_seconds("0"), 0ns);
    EXPECT_EQ(parse_seconds("60"), 60s);
    EXPECT_EQ(parse_seconds("20.5"), 20500ms);
    EXPECT_EQ(parse_seconds("0.1"), 100ms);
    EXPECT_EQ(parse_seconds("1.000000001"), 1'000'000'001ns);
    EXPECT_EQ(parse_seconds("999999.999999999"), 999'999'999'999'999ns);
}

TEST(Seconds, refuse_what_is_none_and_say_what) {
    for (const char* text : {"", ".", "1.", ".5", "-1", "+1", "1e3", "0x10", " 1", "1 ", "1,5",
                             "ten", "1.0000000001", "1.-5", "1000000", "99999999999999999999"}) {
        EXPECT_THAT(error_of(parse_seconds, text), HasSubstr("'" + std::string(text) + "'"));
    }
}

TEST(OrderSchedule, is_a_list_of_times_and_characters) {
    EXPECT_THAT(parse_orders("10:c"), ElementsAre(ScheduledOrder{10s, 'c'}));
    EXPECT_THAT(parse_orders("10:c,20.5:h,20.5:?,3::"),
                ElementsAre(ScheduledOrder{10s, 'c'}, ScheduledOrder{20500ms, 'h'},
                            ScheduledOrder{20500ms, '?'}, ScheduledOrder{3s, ':'}));
}

TEST(OrderSchedule, refuses_the_item_that_is_wrong) {
    EXPECT_EQ(error_of(parse_orders, "10:c,20"), "'20': not TIME:VALUE, as in 20.5:h");
    EXPECT_EQ(error_of(parse_orders, "10:cd,20:h"), "'10:cd': an order is one character");
    EXPECT_EQ(error_of(parse_orders, "10:"), "'10:': an order is one character");
    EXPECT_THAT(error_of(parse_orders, "x:c"), HasSubstr("'x:c'"));
    EXPECT_THAT(error_of(parse_orders, "1:c,"), HasSubstr("''"));
    EXPECT_THAT(error_of(parse_orders, ""), HasSubstr("''"));
}

TEST(TemperatureSchedule, is_a_list_of_times_and_degrees) {
    EXPECT_THAT(parse_temperatures("30:300,40:20,41:-500,42:0"),
                ElementsAre(ScheduledTemperature{30s, 300}, ScheduledTemperature{40s, 20},
                            ScheduledTemperature{41s, -500}, ScheduledTemperature{42s, 0}));
}

TEST(TemperatureSchedule, refuses_what_the_sensor_cannot_read) {
    for (const char* item : {"1:510", "1:-510", "1:25", "1:255"})
        EXPECT_EQ(error_of(parse_temperatures, item),
                  "'" + std::string(item) + "': the temperature is not -500 to 500 in steps of 10");
    for (const char* item : {"1:", "1:hot", "1:20.5", "1:99999999999", "1:+20"})
        EXPECT_EQ(error_of(parse_temperatures, item),
                  "'" + std::string(item) + "': the temperature is not a whole number");
}

}  // namespace
}  // namespace tank
