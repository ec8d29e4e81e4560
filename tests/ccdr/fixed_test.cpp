// canorb::Fixed and its octets: doc/wire/ccdr.md, "fixed".
#include "orb/ccdr/fixed.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/ccdr/codec.hpp"

namespace canorb::test {
namespace {

// Constants are computed by the compiler.
static_assert(Fixed<5, 2>{"123.45"} == Fixed<5, 2>{123.45});
static_assert(Fixed<3, 0>{-7} == Fixed<3, 0>{"-7"});
static_assert(Fixed<3, 1>{"2.5"} > Fixed<3, 1>{2});
static_assert(double{Fixed<4, 2>{"-12.5"}} == -12.5);

template <typename T>
std::string text_of(const T& value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

TEST(Fixed, HasItsDigitsAndASign) {
    EXPECT_EQ(encoded(Fixed<5, 2>{"123.45"}), "12345C");
    EXPECT_EQ(encoded(Fixed<2, 1>{"-1.2"}), "012D");
    EXPECT_EQ(encoded(Fixed<3, 0>{}), "000C");
    EXPECT_EQ(encoded(Fixed<1, 1>{"0.5"}), "5C");
    EXPECT_EQ(encoded(Fixed<4, 2>{"-0.01"}), "00001D");
    EXPECT_EQ(encoded(Fixed<31, 31>{"-0.9999999999999999999999999999999"}),
              "9999999999999999999999999999999D");
    EXPECT_EQ(encoded(std::vector{Fixed<2, 0>{1}, Fixed<2, 0>{-2}}), "02001C002D");
}

TEST(Fixed, IsReadFromItsOctets) {
    EXPECT_EQ((decoded<Fixed<5, 2>>("12345C")), (Fixed<5, 2>{"123.45"}));
    EXPECT_EQ((decoded<Fixed<2, 1>>("012D")), (Fixed<2, 1>{"-1.2"}));
    EXPECT_EQ((decoded<Fixed<3, 0>>("000C")), (Fixed<3, 0>{0}));
    EXPECT_EQ((prefixes_accepted<Fixed<5, 2>>("12345C")), 0U);
    EXPECT_EQ((forgeries_changed<Fixed<5, 2>>("12345C")), 0U);
    EXPECT_EQ((forgeries_changed<Fixed<4, 4>>("00001D")), 0U);
}

TEST(Fixed, BadNibblesAreRefused) {
    for (const char* octets : {"12345A", "12345B", "12345E", "12345F", "123450", "1234AC", "F2345C",
                               "00000D", "12345C00"}) {
        EXPECT_FALSE((decoded<Fixed<5, 2>>(octets))) << octets;
    }
    EXPECT_FALSE((decoded<Fixed<2, 1>>("112D"))) << "a leading nibble that is not 0";
    EXPECT_FALSE((decoded<Fixed<2, 1>>("000D"))) << "no minus for zero";
}

TEST(Fixed, TextIsReadAndRounded) {
    const auto read = [](std::string_view text) { return text_of(Fixed<5, 2>{text}); };
    EXPECT_EQ(read("-12.5"), "-12.50");
    EXPECT_EQ(read("+12."), "12.00");
    EXPECT_EQ(read(".5"), "0.50");
    EXPECT_EQ(read("0000000000000000000000000000000000000999.99"), "999.99");
    EXPECT_EQ(read("1.005"), "1.01");
    EXPECT_EQ(read("-1.005"), "-1.01");
    EXPECT_EQ(read("1.00499999999999999999999999999999999999999999"), "1.00");
    EXPECT_EQ(read("9.995"), "10.00");
    EXPECT_EQ(read("-0.001"), "0.00") << "there is no negative zero";
    for (const char* wrong :
         {"1000", "999.995", "", ".", "-", "1e3", "1 ", " 1", "1.2.3", "--1", "0x1", "1,5"}) {
        EXPECT_EQ(read(wrong), "out of range") << wrong;
    }
}

TEST(Fixed, NumbersAreRoundedHalfAwayFromZero) {
    EXPECT_EQ(text_of(Fixed<3, 2>{0.125}), "0.13");
    EXPECT_EQ(text_of(Fixed<3, 2>{-0.125}), "-0.13");
    EXPECT_EQ(text_of(Fixed<3, 2>{1.005}), "1.00") << "the double is a little less";
    EXPECT_EQ(text_of(Fixed<1, 0>{9.4999}), "9");
    EXPECT_EQ(text_of(Fixed<1, 0>{9.5}), "out of range");
    EXPECT_EQ(text_of(Fixed<31, 0>{1e30}), "1000000000000000019884624838656");
    EXPECT_EQ(text_of(Fixed<31, 31>{0.1}), "0.1000000000000000055511151231258");
    EXPECT_EQ(text_of(Fixed<31, 0>{1.1e31}), "out of range");
    EXPECT_EQ(text_of(Fixed<31, 0>{1e300}), "out of range");
    EXPECT_EQ(text_of(Fixed<31, 0>{std::numeric_limits<double>::max()}), "out of range");
    EXPECT_EQ(text_of(Fixed<31, 31>{std::numeric_limits<double>::denorm_min()}),
              "0.0000000000000000000000000000000");
    EXPECT_EQ(text_of(Fixed<5, 2>{std::numeric_limits<double>::infinity()}), "out of range");
    EXPECT_EQ(text_of(Fixed<5, 2>{std::numeric_limits<double>::quiet_NaN()}), "out of range");
    EXPECT_EQ(text_of(Fixed<5, 2>{-0.0}), "0.00");
    EXPECT_EQ(text_of(Fixed<20, 0>{std::numeric_limits<std::uint64_t>::max()}),
              "18446744073709551615");
    EXPECT_EQ(text_of(Fixed<20, 0>{std::numeric_limits<std::int64_t>::min()}),
              "-9223372036854775808");
    EXPECT_EQ(text_of(Fixed<2, 0>{100}), "out of range");
    EXPECT_EQ(text_of(Fixed<2, 2>{1}), "out of range");
}

TEST(Fixed, WhatIsOutOfRangeIsNotSent) {
    Fixed<3, 1> value{100};
    EXPECT_TRUE(value.is_out_of_range());
    EXPECT_EQ(encoded(value), "bad_value");
    value = 99;
    EXPECT_FALSE(value.is_out_of_range());
    EXPECT_EQ(encoded(value), "990C");
}

TEST(Fixed, IsTheNearestDouble) {
    for (const double value :
         {0.0, 0.1, -0.1, 123.456, 1e-31, 9.999999999999999e-5, 0.3, 1.0 / 3}) {
        EXPECT_EQ((double{Fixed<31, 31>{0.1}}), 0.1);
        const double near = double{Fixed<31, 25>{value}};
        EXPECT_NEAR(near, value, 1e-25);
    }
    EXPECT_EQ((double{Fixed<31, 0>{1e30}}), 1e30);
    EXPECT_EQ((double{Fixed<31, 0>{"9007199254740993"}}), 9007199254740992.0) << "ties to even";
    EXPECT_EQ((double{Fixed<31, 1>{"9007199254740993.1"}}), 9007199254740994.0);
    EXPECT_EQ((double{Fixed<31, 31>{"0.0000000000000000000000000000001"}}), 1e-31);
    EXPECT_EQ((double{Fixed<31, 31>{"0.3333333333333333333333333333333"}}), 1.0 / 3);
    EXPECT_EQ((double{Fixed<31, 16>{"-123456789012345.1234567890123456"}}),
              -123456789012345.1234567890123456);
    EXPECT_EQ((double{Fixed<5, 2>{"-123.45"}}), -123.45);
}

TEST(Fixed, IsOrderedByValue) {
    using Price = Fixed<4, 2>;
    const std::vector ordered{Price{"-99.99"}, Price{"-1.5"}, Price{"-1.49"}, Price{"0"},
                              Price{"0.01"},   Price{"1.5"},  Price{"99.99"}};
    for (std::size_t i = 0; i < ordered.size(); ++i) {
        for (std::size_t k = 0; k < ordered.size(); ++k) {
            EXPECT_EQ(ordered[i] < ordered[k], i < k);
            EXPECT_EQ(ordered[i] == ordered[k], i == k);
        }
        EXPECT_LT(ordered[i], Price{100}) << "out of range";
    }
    EXPECT_EQ(Price{3}, 3);
    EXPECT_LT(Price{3}, 3.01);
}

}  // namespace
}  // namespace canorb::test
