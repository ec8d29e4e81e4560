#include "record.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace tank {
namespace {

using namespace std::chrono_literals;
using canorb::test::octets;

TEST(CsvLine, has_the_fields_of_the_header) {
    EXPECT_EQ(csv_header, "time_s,round,slot_ms,mode,setpoint_cm,temperature_c,level_mm,ve,vs");
    EXPECT_EQ(csv_line({.time = 350'230us,
                        .round = 1,
                        .slot_length = 50ms,
                        .mode = Mode::normal,
                        .setpoint_cm = 50,
                        .temperature_c = 20,
                        .level_mm = 1990,
                        .valves = {false, true}}),
              "0.350,1,50,N,50,20,1990,0,1");
    EXPECT_EQ(csv_line({.time = 3600s,
                        .round = 60000,
                        .slot_length = 5ms,
                        .mode = Mode::alarm,
                        .setpoint_cm = 125,
                        .temperature_c = -500,
                        .level_mm = 0,
                        .valves = {true, false}}),
              "3600.000,60000,5,A,125,-500,0,1,0");
}

TEST(CandumpLine, is_as_candump_writes_it) {
    EXPECT_EQ(
        candump_line(230us, canorb::can::Frame::standard(0x21, octets("10 0005 1234 ABCD 00"))),
        "(0.000230) can0 021#1000051234ABCD00");
    EXPECT_EQ(candump_line(61'000'001'999ns, canorb::can::Frame::standard(0x7EF, {})),
              "(61.000001) can0 7EF#");
}

}  // namespace
}  // namespace tank
