#include "keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace plant {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using Typed = Keys::Typed;

std::vector<Typed> type(Keys& keys, std::string_view text) {
    std::vector<Typed> commands;
    for (const char key : text) {
        if (auto typed = keys.take(key)) commands.push_back(*typed);
    }
    return commands;
}

TEST(Keys, change_variables_by_a_step) {
    Keys keys{1};
    EXPECT_THAT(type(keys, "TtPlL"),
                ElementsAre(Typed{0, "raise temperature 5"}, Typed{0, "lower temperature 5"},
                            Typed{0, "raise pressure 0.5"}, Typed{0, "lower level 5"},
                            Typed{0, "raise level 5"}));
}

TEST(Keys, choose_a_panel_that_exists) {
    Keys keys{3};
    EXPECT_THAT(type(keys, "3t4t0t"),
                ElementsAre(Typed{2, "lower temperature 5"}, Typed{2, "lower temperature 5"},
                            Typed{2, "lower temperature 5"}));
    EXPECT_THAT(type(keys, "\tt\tt"),
                ElementsAre(Typed{0, "lower temperature 5"}, Typed{1, "lower temperature 5"}));
}

TEST(Keys, type_a_line) {
    Keys keys{2};
    EXPECT_THAT(type(keys, "j5\nv2\nf12\n2:value t 80\n"),
                ElementsAre(Typed{0, "join 5"}, Typed{0, "leave 2"}, Typed{0, "forget 12"},
                            Typed{1, "value t 80"}));
}

TEST(Keys, in_a_line_are_letters) {
    Keys keys{2};
    EXPECT_THAT(type(keys, ":qTtj2"), IsEmpty());
    EXPECT_FALSE(keys.quit());
    EXPECT_EQ(keys.selected(), 0U);
    EXPECT_EQ(keys.line(), "qTtj2");
    EXPECT_THAT(type(keys, "\b\b!\n"), ElementsAre(Typed{0, "qTt!"}));
}

TEST(Keys, drop_a_line) {
    Keys keys{1};
    EXPECT_THAT(type(keys, "j5\x1b\n\n"), IsEmpty());
    EXPECT_EQ(keys.line(), std::nullopt);
    EXPECT_THAT(type(keys, "j\b\b\b\b\b\b\b\b\n"), IsEmpty());
}

TEST(Keys, end_with_q_only) {
    Keys keys{1};
    type(keys, "xyzQ");
    keys.take(0x171);
    EXPECT_FALSE(keys.quit());
    type(keys, "q");
    EXPECT_TRUE(keys.quit());
}

}  // namespace
}  // namespace plant
