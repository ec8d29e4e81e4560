#include "plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace tank {
namespace {

using namespace std::chrono_literals;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// Level 2000 is at 60, 0 at 400; the time axis goes from 70 to 890.
constexpr std::array<PlotSample, 3> samples{{
    {0s, 2000, 50, 20, Mode::normal, {false, false}},
    {5s, 1000, 50, 300, Mode::alarm, {false, true}},
    {10s, 0, 100, 300, Mode::normal, {true, true}},
}};

TEST(Plot, is_a_picture_even_of_nothing) {
    const std::string picture = svg_plot({});
    EXPECT_THAT(picture, StartsWith("<svg "));
    EXPECT_THAT(picture, EndsWith("</svg>\n"));
}

TEST(Plot, draws_the_level_between_the_axes) {
    EXPECT_THAT(svg_plot(samples), HasSubstr(R"(points="70.0,60.0 480.0,230.0 890.0,400.0")"));
}

TEST(Plot, draws_the_setpoint_as_stairs) {
    // 50 cm: 400 - 340 / 4; 100 cm: 230.
    EXPECT_THAT(svg_plot(samples), HasSubstr(R"(points="70.0,315.0 890.0,315.0 890.0,230.0")"));
}

TEST(Plot, shades_alarms_and_marks_orders) {
    const PlotMark marks[] = {{5s, "'c'"}, {11s, "beyond"}};
    const std::string picture = svg_plot(samples, marks);
    EXPECT_THAT(picture, HasSubstr(R"(<rect x="480.0" y="60.0" width="410.0" height="340.0")"));
    EXPECT_THAT(picture, HasSubstr(">'c'</text>"));
    EXPECT_THAT(picture, Not(HasSubstr("beyond")));
}

TEST(Plot, escapes_what_would_be_markup) {
    const PlotMark marks[] = {{5s, "'<'"}, {6s, "'&'"}};
    const std::string picture = svg_plot(samples, marks);
    EXPECT_THAT(picture, HasSubstr(">'&lt;'</text>"));
    EXPECT_THAT(picture, HasSubstr(">'&amp;'</text>"));
}

}  // namespace
}  // namespace tank
