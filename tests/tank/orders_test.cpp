#include "orders.hpp"

#include <gtest/gtest.h>

#include "operator_line.hpp"

namespace tank {
namespace {

using namespace std::chrono_literals;

TEST(Orders, set_the_level) {
    EXPECT_EQ(parse_order('a'), Order{SetpointOrder{50}});
    EXPECT_EQ(parse_order('b'), Order{SetpointOrder{75}});
    EXPECT_EQ(parse_order('c'), Order{SetpointOrder{100}});
    EXPECT_EQ(parse_order('d'), Order{SetpointOrder{125}});
}

TEST(Orders, set_the_slots) {
    EXPECT_EQ(parse_order('h'), Order{SlotOrder{5ms}});
    EXPECT_EQ(parse_order('j'), Order{SlotOrder{10ms}});
    EXPECT_EQ(parse_order('k'), Order{SlotOrder{50ms}});
    EXPECT_EQ(parse_order('l'), Order{SlotOrder{100ms}});
}

TEST(Orders, are_these_eight_and_no_more) {
    int known = 0;
    for (int c = -128; c < 128; ++c) known += parse_order(static_cast<char>(c)).has_value() ? 1 : 0;
    EXPECT_EQ(known, 8);
    EXPECT_FALSE(parse_order('i'));
    EXPECT_FALSE(parse_order('A'));
    EXPECT_FALSE(parse_order(' '));
}

TEST(Orders, are_not_ended_by_lines) {
    EXPECT_TRUE(is_line_end('\r'));
    EXPECT_TRUE(is_line_end('\n'));
    EXPECT_FALSE(is_line_end(' '));
    EXPECT_FALSE(is_line_end('a'));
}

TEST(Orders, are_shown_to_people) {
    EXPECT_EQ(printable('x'), "'x'");
    EXPECT_EQ(printable('\x1b'), "0x1B");
    EXPECT_EQ(printable('\xe9'), "0xE9");
}

TEST(LocalOperatorLine, is_first_in_first_out) {
    std::string shown;
    LocalOperatorLine line{[&](std::string_view text) { shown += text; }};
    EXPECT_EQ(line.read(), std::nullopt);
    line.type('a');
    line.type('b');
    EXPECT_EQ(line.read(), 'a');
    EXPECT_EQ(line.read(), 'b');
    EXPECT_EQ(line.read(), std::nullopt);
    line.write("status");
    EXPECT_EQ(shown, "status");
}

TEST(LocalOperatorLine, has_a_bounded_buffer) {
    LocalOperatorLine line;
    for (int i = 0; i < 1000; ++i) line.type('a');
    int kept = 0;
    while (line.read()) ++kept;
    EXPECT_EQ(kept, 64);
}

}  // namespace
}  // namespace tank
