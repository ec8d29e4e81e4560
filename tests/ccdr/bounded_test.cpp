// Bounds, kept by types and by bounded(): doc/wire/ccdr.md, "Bounds".
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "tests/ccdr/codec.hpp"

namespace canorb::test {
namespace {

using ccdr::bounded;

TEST(BoundedString, TakesTextsUpToItsBound) {
    BoundedString<4> text = "four";
    EXPECT_FALSE(text.is_overlong());
    EXPECT_EQ(text, "four");
    EXPECT_EQ(text.size(), 4U);
    EXPECT_STREQ(text.c_str(), "four");
    EXPECT_TRUE(text.assign("two"));
    EXPECT_EQ(text.view(), "two");
    EXPECT_STREQ(text.c_str(), "two");
    text = std::string{"std"};
    EXPECT_EQ(text, std::string{"std"});
    text.clear();
    EXPECT_TRUE(text.empty());
    EXPECT_EQ(text, BoundedString<4>{});
}

TEST(BoundedString, ALongerTextIsCutAndRemembered) {
    BoundedString<4> text = "fives";
    EXPECT_TRUE(text.is_overlong());
    EXPECT_EQ(text, "five");
    EXPECT_STREQ(text.c_str(), "five");
    EXPECT_EQ(encoded(text), "bad_value");
    EXPECT_EQ(encoded(BoundedString<9>{text}), "bad_value") << "copied to a wider bound";
    EXPECT_FALSE(text.assign("longer still"));
    EXPECT_TRUE(text.assign("ok"));
    EXPECT_EQ(encoded(text), "036F6B00");
}

TEST(BoundedString, ComparesAndPrintsAsText) {
    const BoundedString<8> a = "a";
    const BoundedString<4> b = "b";
    EXPECT_LT(a, b);
    EXPECT_NE(a, b);
    EXPECT_LT("A", a);
    EXPECT_EQ("a", a);
    std::ostringstream out;
    out << a << b;
    EXPECT_EQ(out.str(), "ab");
}

TEST(BoundedString, TheBoundExcludesTheNul) {
    EXPECT_EQ(encoded(BoundedString<4>{"four"}), "05666F757200");
    EXPECT_EQ(decoded<BoundedString<4>>("05666F757200"), "four");
    EXPECT_FALSE(decoded<BoundedString<4>>("06666976657300")) << "five octets and the NUL";
    EXPECT_EQ(decoded<BoundedString<5>>("06666976657300"), "fives");
}

TEST(BoundedString, MalformedFormsAreRefused) {
    for (const char* octets :
         {"", "00", "0141", "03410000", "80024100", "02410000", "F0FFFFFFFF4100"}) {
        EXPECT_FALSE(decoded<BoundedString<4>>(octets)) << octets;
    }
    EXPECT_EQ(encoded(BoundedString<4>{std::string_view{"a\0b", 3}}), "bad_value");
}

TEST(BoundedVector, IsUsedAsAVector) {
    BoundedVector<std::uint16_t, 4> samples = {1, 2};
    samples.push_back(128);
    EXPECT_EQ(samples.size(), 3U);
    EXPECT_EQ(samples.back(), 128);
    EXPECT_EQ(samples, (BoundedVector<std::uint16_t, 4>{1, 2, 128}));
    EXPECT_NE(samples, (BoundedVector<std::uint16_t, 4>{1, 2}));
    unsigned sum = 0;
    for (const std::uint16_t sample : samples) sum += sample;
    EXPECT_EQ(sum, 131U);
    EXPECT_TRUE(samples.assign(std::vector<std::uint16_t>{7}));
    EXPECT_EQ(samples.front(), 7);
    EXPECT_TRUE(samples.resize(2));
    EXPECT_EQ(samples[1], 0) << "not what was there before";
}

TEST(BoundedVector, WhatDoesNotFitIsLeftOutAndRemembered) {
    BoundedVector<std::uint8_t, 2> octets = {1, 2};
    EXPECT_FALSE(octets.is_overlong());
    EXPECT_FALSE(octets.push_back(3));
    EXPECT_TRUE(octets.is_overlong());
    EXPECT_EQ(octets.size(), 2U);
    EXPECT_EQ(encoded(octets), "bad_value");
    octets.clear();
    EXPECT_EQ(encoded(octets), "00");
    EXPECT_EQ(encoded(BoundedVector<std::uint8_t, 2>{1, 2, 3}), "bad_value");
    EXPECT_FALSE(octets.resize(3));
    EXPECT_EQ(encoded(octets), "bad_value");
}

TEST(BoundedVector, IsASequence) {
    using Octets = BoundedVector<std::uint8_t, 3>;
    EXPECT_EQ(encoded(Octets{1, 2, 3}), "03010203");
    EXPECT_EQ(decoded<Octets>("03010203"), (Octets{1, 2, 3}));
    EXPECT_FALSE(decoded<Octets>("0401020304")) << "above the bound";
    EXPECT_FALSE(decoded<Octets>("0301020304")) << "left over";
    EXPECT_EQ(prefixes_accepted<Octets>("03010203"), 0U);

    using Names = BoundedVector<BoundedString<4>, 2>;
    EXPECT_EQ(encoded(Names{"A", ""}), "020241000100");
    EXPECT_EQ(decoded<Names>("020241000100"), (Names{"A", ""}));
    EXPECT_EQ(encoded(Names{"A", "fives"}), "bad_value");
    EXPECT_FALSE(decoded<Names>("01 06666976657300"));

    using Grid = BoundedVector<BoundedVector<bool, 2>, 2>;
    EXPECT_EQ(encoded(Grid{{true}, {false, true}}), "020101020001");
    EXPECT_EQ(decoded<Grid>("020101020001"), (Grid{{true}, {false, true}}));

    using NamesOnTheHeap = std::vector<BoundedString<4>>;
    EXPECT_EQ(encoded(NamesOnTheHeap{"A"}), "01024100");
    EXPECT_EQ(decoded<NamesOnTheHeap>("01024100"), NamesOnTheHeap{"A"});
}

TEST(BoundedVector, CountsThatLieAreRefused) {
    for (const char* octets : {"", "01", "0200", "8001 00", "F0FFFFFFFF 0000"}) {
        EXPECT_FALSE((decoded<BoundedVector<std::uint16_t, 8>>(octets))) << octets;
    }
}

// What bounded<Bounds...>() reads into a T, or nothing.
template <std::size_t... Bounds, typename T>
bool decodes_bounded(std::string_view hex, T& value) {
    const auto golden = octets(hex);
    ccdr::Decoder in{golden};
    decode(in, bounded<Bounds...>(value));
    return in.finished();
}

TEST(Bounded, LimitsAString) {
    const std::string four = "four";
    EXPECT_EQ(encoded(bounded<4>(four)), "05666F757200");
    EXPECT_EQ(encoded(bounded<3>(four)), "bad_value");
    EXPECT_EQ(encoded(bounded<0>(four)), "05666F757200");
    std::string text;
    EXPECT_TRUE(decodes_bounded<4>("05666F757200", text));
    EXPECT_EQ(text, "four");
    EXPECT_FALSE(decodes_bounded<3>("05666F757200", text));
    EXPECT_EQ(text, "");
    EXPECT_TRUE(decodes_bounded<0>("05666F757200", text));
}

TEST(Bounded, LimitsASequence) {
    std::vector<std::uint16_t> samples = {1, 128};
    EXPECT_EQ(encoded(bounded<2>(samples)), "02018080");
    EXPECT_EQ(encoded(bounded<1>(samples)), "bad_value");
    EXPECT_TRUE(decodes_bounded<2>("02018080", samples));
    EXPECT_EQ(samples, (std::vector<std::uint16_t>{1, 128}));
    EXPECT_FALSE(decodes_bounded<1>("02018080", samples));
    EXPECT_TRUE(samples.empty());
}

TEST(Bounded, ACountAboveTheBoundAllocatesNothing) {
    std::vector<std::uint8_t> octets(3 + 20'000);
    octets[0] = 0xC0;
    octets[1] = 20'000 >> 8;
    octets[2] = 20'000 & 0xFF;
    ccdr::Decoder in{octets};
    std::vector<std::uint8_t> value;
    decode(in, bounded<1000>(value));
    EXPECT_FALSE(in.ok());
    EXPECT_EQ(value.capacity(), 0U);
}

TEST(Bounded, LimitsTheElementsToo) {
    std::vector<std::string> texts = {"A", "BC"};
    constexpr std::string_view golden = "0202410003424300";
    EXPECT_EQ(encoded(bounded<2, 2>(texts)), golden);
    EXPECT_EQ(encoded(bounded<2, 1>(texts)), "bad_value");
    EXPECT_EQ(encoded(bounded<1, 2>(texts)), "bad_value");
    EXPECT_TRUE((decodes_bounded<2, 2>(golden, texts)));
    EXPECT_EQ(texts, (std::vector<std::string>{"A", "BC"}));
    EXPECT_FALSE((decodes_bounded<2, 1>(golden, texts)));
    EXPECT_FALSE((decodes_bounded<1, 2>(golden, texts)));
    EXPECT_TRUE((decodes_bounded<0, 2>(golden, texts)));

    std::array<std::string, 2> pair = {"A", "BC"};
    EXPECT_EQ(encoded(bounded<2>(pair)), golden.substr(2));
    EXPECT_EQ(encoded(bounded<1>(pair)), "bad_value");
    EXPECT_TRUE((decodes_bounded<2>(golden.substr(2), pair)));
    EXPECT_FALSE((decodes_bounded<1>(golden.substr(2), pair)));
}

}  // namespace
}  // namespace canorb::test
