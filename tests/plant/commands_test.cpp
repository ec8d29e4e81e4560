#include "commands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace plant {
namespace {

using testing::HasSubstr;

template <typename Kind>
Kind parsed(std::string_view line) {
    return std::get<Kind>(parse_command(line));
}

TEST(Commands, are_words) {
    EXPECT_EQ(parsed<SetValue>("value temperature 80").variable, Variable::temperature);
    EXPECT_EQ(parsed<SetValue>("value temperature 80").value, 80.0F);
    EXPECT_EQ(parsed<SetLimit>("limit pressure 4.5").variable, Variable::pressure);
    EXPECT_EQ(parsed<SetLimit>("limit pressure 4.5").limit, 4.5F);
    EXPECT_EQ(parsed<Change>("raise level 5").variable, Variable::level);
    EXPECT_EQ(parsed<Change>("raise level 5").by, 5.0F);
    EXPECT_EQ(parsed<Change>("lower level 5").by, -5.0F);
    EXPECT_EQ(parsed<Join>("join 31").group, canorb::GroupId{31});
    EXPECT_EQ(parsed<Leave>("leave 1").group, canorb::GroupId{1});
    EXPECT_EQ(parsed<Forget>("forget 0").sensor, 0);
    EXPECT_NO_THROW(parsed<Quit>("quit"));
}

TEST(Commands, take_shortened_variables_and_any_blanks) {
    EXPECT_EQ(parsed<SetValue>("  value \t t   -1000\r").variable, Variable::temperature);
    EXPECT_EQ(parsed<SetValue>("value t -1000").value, -1000.0F);
    EXPECT_EQ(parsed<SetLimit>("limit press 1000").limit, 1000.0F);
}

TEST(Commands, say_what_is_wrong) {
    const auto wrong = [](std::string_view line) -> std::string {
        try {
            parse_command(line);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "nothing";
    };
    for (const char* line : {"", "stop", "value", "value temperature", "value temperature 1 2",
                             "quit now", "join", "Join 5"})
        EXPECT_THAT(wrong(line), HasSubstr("is no command")) << line;
    EXPECT_THAT(wrong("value speed 3"), HasSubstr("'speed' is none of temperature, pressure"));
    EXPECT_THAT(wrong("value temperatures 3"), HasSubstr("'temperatures' is none of"));
    for (const char* number : {"hot", "1001", "-1001", "nan", "inf", "3x", "0x10"})
        EXPECT_THAT(wrong(std::string{"value t "} + number),
                    HasSubstr("is no number from -1000 to 1000"))
            << number;
    for (const char* group : {"0", "32", "256", "-1", "five", "5x"})
        EXPECT_THAT(wrong(std::string{"join "} + group), HasSubstr("is no group from 1 to 31"))
            << group;
    EXPECT_THAT(wrong("forget 31"), HasSubstr("'31' is no node from 0 to 30"));
}

}  // namespace
}  // namespace plant
