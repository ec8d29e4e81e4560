#include "panel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plant {
namespace {

TEST(Panel, is_one_line_of_text_and_back) {
    const Panel panel{{Mark::none, "level 50.0 %"}, {Mark::good, "ON"}, {Mark::bad, ""}};
    EXPECT_EQ(to_text(panel), "| level 50.0 %|+ON|!|");
    EXPECT_EQ(parse_panel("| level 50.0 %|+ON|!|"), panel);
}

TEST(Panel, is_not_every_text) {
    for (const char* text : {"", "|", "||", "| a", " a|", "|a|", "| a|b|", "joined group 2"})
        EXPECT_EQ(parse_panel(text), std::nullopt) << text;
}

TEST(Panel, stands_behind_time_and_name) {
    EXPECT_EQ(output_line(0.25, "sensor-11", "| a|"), "0.250 sensor-11: | a|");
    EXPECT_EQ(text_of_output_line("0.250 sensor-11: controller: | a|"), "controller: | a|");
    EXPECT_EQ(text_of_output_line("Segmentation fault"), "Segmentation fault");
}

}  // namespace
}  // namespace plant
