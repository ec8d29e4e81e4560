// Type codes, and values read by them: doc/wire/ccdr.md, "Type codes".
#include "orb/ccdr/type_code.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "tests/ccdr/codec.hpp"

namespace canorb::test {
namespace {

/// A type code's octets in hex: what reads them accepts them whole.
bool is_type_code(std::string_view hex) {
    return decoded<TypeCode>(hex).has_value();
}

TypeCode type_code_from(std::string_view hex) {
    const auto all = octets(hex);
    return TypeCode{std::string{all.begin(), all.end()}};
}

/// Whether these are the octets of one value of the type.
bool is_value(std::string_view type_code, std::string_view value) {
    const auto code = octets(type_code);
    const auto all = octets(value);
    ccdr::Decoder in{all};
    ccdr::read_value(in, code);
    return in.finished();
}

// struct Status { unsigned short speed; string name; };
constexpr std::string_view status_code =
    "0F"                       // tk_struct
    "0A 49444C3A533A312E3000"  // IDL:S:1.0
    "0100"                     // its name
    "02"                       // members
    "0100 04"                  // unsigned short
    "0100 12 00";              // string, no bound

// struct Tree { long value; sequence<Tree> children; };
constexpr std::string_view tree_code =
    "0F 0100 0100 02"
    "0100 03"
    "0100 13 F0FFFFFFFF 02"  // of what is two levels up: the sequence, then the struct
    "00";                    // no bound

// union U switch (long) { case 1: octet a; default: string b; case -1: case 2: boolean c; };
constexpr std::string_view union_code =
    "10 0100 0100"
    "03"             // switch (long)
    "01"             // the second case is the default
    "04"             // cases
    "01 0100 0A"     // 1: octet
    "00 0100 12 00"  // the default's label says nothing
    "7F 0100 08"     // -1: boolean
    "02 0100 08";    // 2: boolean

// enum { a, b, c };
constexpr std::string_view enum_code = "11 0100 0100 03 0100 0100 0100";

TEST(TypeCode, BasicTypesAreTheirKind) {
    for (const char* code : {"00", "01", "02", "03", "04", "05", "06", "07", "08", "09", "0A", "0B",
                             "0C", "17", "18", "19", "1A"}) {
        EXPECT_TRUE(is_type_code(code)) << code;
        EXPECT_EQ(encoded(*decoded<TypeCode>(code)), code);
    }
    EXPECT_EQ(decoded<TypeCode>("03")->kind(), TCKind::tk_long);
    EXPECT_EQ(encoded(TypeCode{}), "00");
    EXPECT_EQ(TypeCode{}.kind(), TCKind::tk_null);
}

TEST(TypeCode, UnknownKindsAreRefused) {
    for (const char* code : {"0D", "1D", "1E", "1F", "20", "21", "22", "7F", "8080", "F0FFFFFFFE",
                             "F0FFFFFFFF", "F0FFFFFFFF01", "8003", ""}) {
        EXPECT_FALSE(is_type_code(code)) << code;
    }
}

TEST(TypeCode, IsWhatItsKindNeeds) {
    for (const std::string_view code :
         {std::string_view{"12 00"}, std::string_view{"1B 8080"}, std::string_view{"1C 05 02"},
          std::string_view{"0E 024100 0100"}, status_code, tree_code, union_code, enum_code,
          std::string_view{"13 04 0A"}, std::string_view{"14 14 03 03 02"},
          std::string_view{"15 024100 0100 05"}, std::string_view{"16 024100 0100 01 0100 05"},
          std::string_view{"0F 0100 0100 00"}}) {
        EXPECT_TRUE(is_type_code(code)) << code;
        EXPECT_EQ(encoded(*decoded<TypeCode>(code)), hex(octets(code)));
        EXPECT_EQ(prefixes_accepted<TypeCode>(code), 0U) << code;
        EXPECT_EQ(forgeries_changed<TypeCode>(code), 0U) << code;
    }
    EXPECT_EQ(decoded<TypeCode>(status_code)->id(), "IDL:S:1.0");
    EXPECT_EQ(decoded<TypeCode>("12 00")->id(), "");
}

TEST(TypeCode, WhatDescribesNoTypeIsRefused) {
    EXPECT_FALSE(is_type_code("1C 00 00")) << "fixed<0,0>";
    EXPECT_FALSE(is_type_code("1C 20 00")) << "fixed<32,0>";
    EXPECT_FALSE(is_type_code("1C 05 06")) << "fixed<5,6>";
    EXPECT_FALSE(is_type_code("1C 05 7F")) << "fixed<5,-1>";
    EXPECT_FALSE(is_type_code("11 0100 0100 00")) << "an enum of nothing";
    EXPECT_FALSE(is_type_code("14 03 00")) << "an array of nothing";
    EXPECT_FALSE(is_type_code("13 01 00")) << "a sequence of void";
    EXPECT_FALSE(is_type_code("13 00 00")) << "a sequence of null";
    EXPECT_FALSE(is_type_code("13 16 0100 0100 00 00")) << "a sequence of exceptions";
    EXPECT_FALSE(is_type_code("0F 0100 0100 F0FFFFFFFF")) << "a count that lies";
    EXPECT_FALSE(is_type_code("11 0100 0100 F0FFFFFFFF")) << "a count that lies";
    EXPECT_FALSE(is_type_code("10 0100 0100 03 7F 00")) << "a union without cases";
    EXPECT_FALSE(is_type_code("10 0100 0100 03 01 01 01 0100 0A")) << "a default that is not there";
    EXPECT_FALSE(is_type_code("10 0100 0100 03 7E 01 01 0100 0A")) << "-2 for the default";
    EXPECT_FALSE(is_type_code("10 0100 0100 12 00 7F 01 0100 0100 0A")) << "switch (string)";
    EXPECT_FALSE(is_type_code("10 0100 0100 07 7F 01 3FF0000000000000 0100 0A"))
        << "switch (double)";
    EXPECT_FALSE(is_type_code("10 0100 0100 08 7F 01 02 0100 0A")) << "neither TRUE nor FALSE";
}

TEST(TypeCode, ADiscriminatorMayBeAnEnumOrAnAlias) {
    EXPECT_TRUE(is_type_code("10 0100 0100 11 0100 0100 01 0100 7F 01 00 0100 0A"));
    EXPECT_FALSE(is_type_code("10 0100 0100 11 0100 0100 01 0100 7F 01 01 0100 0A"))
        << "an enumerator that is not there";
    EXPECT_TRUE(is_type_code("10 0100 0100 15 0100 0100 15 0100 0100 1A 7F 01 0041 0100 0A"));
}

TEST(TypeCode, ARecursionStandsForAStructAroundASequence) {
    EXPECT_FALSE(is_type_code("0F 0100 0100 01 0100 13 F0FFFFFFFF 01 00")) << "the sequence";
    EXPECT_FALSE(is_type_code("0F 0100 0100 01 0100 13 F0FFFFFFFF 03 00")) << "nothing";
    EXPECT_FALSE(is_type_code("0F 0100 0100 01 0100 13 F0FFFFFFFF 00 00")) << "itself";
    EXPECT_FALSE(is_type_code("0F 0100 0100 01 0100 13 F0FFFFFFFF F0FFFFFFFF 00"));
    EXPECT_FALSE(is_type_code("0F 0100 0100 01 0100 F0FFFFFFFF 01")) << "without end";
    EXPECT_FALSE(is_type_code("0F 0100 0100 01 0100 14 F0FFFFFFFF 02 01")) << "an array ends not";
    EXPECT_FALSE(is_type_code("13 F0FFFFFFFF 01 00"));
    EXPECT_TRUE(is_type_code("0F 0100 0100 01 0100 13 14 F0FFFFFFFF 03 01 00"));
}

std::string sequences(std::size_t levels) {
    std::string code;
    for (std::size_t i = 1; i < levels; ++i) code += "13";
    code += "03";
    for (std::size_t i = 1; i < levels; ++i) code += "00";
    return code;
}

TEST(TypeCode, HasAtMostSixteenLevels) {
    EXPECT_TRUE(is_type_code(sequences(16)));
    EXPECT_FALSE(is_type_code(sequences(17)));
    EXPECT_EQ(encoded(type_code_from(sequences(17))), "bad_value");
    EXPECT_FALSE(decoded<TypeCode>(Bytes{std::vector<std::uint8_t>(65538, 0x13)}));
    EXPECT_FALSE(decoded<TypeCode>(Bytes{std::vector<std::uint8_t>(65538, 0x15)}));
}

TEST(TypeCode, OneThatIsMalformedIsNotSent) {
    EXPECT_EQ(encoded(type_code_from("")), "bad_value");
    EXPECT_EQ(encoded(type_code_from("0D")), "bad_value");
    EXPECT_EQ(encoded(type_code_from("0303")), "bad_value");
    EXPECT_EQ(type_code_from("").kind(), TCKind::tk_null);
    EXPECT_FALSE(type_code_from("13").equivalent(type_code_from("13")));
    EXPECT_FALSE(type_code_from("F0FFFFFFFF02").equivalent(type_code_from("F0FFFFFFFF02")));
    const std::string deep(65538, '\x15');
    EXPECT_FALSE(TypeCode{deep}.equivalent(TypeCode{deep}));
}

TEST(TypeCode, NamesAndAliasesDoNotMatterForEquivalence) {
    const auto equivalent = [](std::string_view a, std::string_view b) {
        const bool there = type_code_from(a).equivalent(type_code_from(b));
        const bool back = type_code_from(b).equivalent(type_code_from(a));
        EXPECT_EQ(there, back);
        return there;
    };
    for (const std::string_view code : {status_code, tree_code, union_code, enum_code}) {
        EXPECT_TRUE(equivalent(code, code));
        EXPECT_FALSE(equivalent(code, "03"));
    }
    EXPECT_TRUE(equivalent("15 024100 0100 03", "03"));
    EXPECT_TRUE(equivalent("13 15 024100 0100 03 00", "13 03 00"));
    EXPECT_TRUE(equivalent("0F 0100 024100 01 024200 03", "0F 0100 0100 01 0100 03")) << "names";
    EXPECT_TRUE(equivalent("0F 024100 0100 01 0100 03", "0F 0100 0100 01 0100 03")) << "no id";
    EXPECT_FALSE(equivalent("0F 024100 0100 01 0100 03", "0F 024200 0100 01 0100 03")) << "ids";
    EXPECT_FALSE(equivalent("0F 0100 0100 01 0100 03", "0F 0100 0100 01 0100 05"));
    EXPECT_FALSE(equivalent("0F 0100 0100 01 0100 03", "0F 0100 0100 02 0100 03 0100 03"));
    EXPECT_FALSE(equivalent("12 00", "12 05"));
    EXPECT_FALSE(equivalent("14 03 02", "14 03 03"));
    EXPECT_FALSE(equivalent("1C 05 02", "1C 05 01"));
    EXPECT_FALSE(equivalent(enum_code, "11 0100 0100 02 0100 0100"));
    EXPECT_FALSE(
        equivalent("10 0100 0100 03 7F 01 01 0100 0A", "10 0100 0100 03 7F 01 02 0100 0A"));
    EXPECT_TRUE(equivalent("10 0100 0100 03 00 01 01 0100 0A", "10 0100 0100 03 00 01 02 0100 0A"))
        << "a default's label";
    // The recursion counts one level more through the alias.
    EXPECT_TRUE(
        equivalent("0F 0100 0100 02 0100 03 0100 15 0100 0100 13 F0FFFFFFFF 03 00", tree_code));
}

TEST(TypeCode, OneWithoutBoundAcceptsThoseWithOne) {
    const auto accepts = [](std::string_view a, std::string_view b) {
        return type_code_from(a).accepts(type_code_from(b));
    };
    EXPECT_TRUE(accepts("12 00", "12 05"));
    EXPECT_FALSE(accepts("12 05", "12 00"));
    EXPECT_FALSE(accepts("12 05", "12 06"));
    EXPECT_TRUE(accepts("13 03 00", "13 03 05"));
    EXPECT_TRUE(accepts("0E 1D49444C3A6F6D672E6F72672F434F5242412F4F626A6563743A312E3000 0100",
                        "0E 024100 0100"))
        << "any interface is an Object";
    EXPECT_FALSE(accepts("0E 024100 0100", "0E 024200 0100"));
}

TEST(Value, IsReadByItsTypeCode) {
    struct {
        std::string_view code;
        std::string_view value;
    } const cases[] = {
        {"02", "BFBF"},
        {"03", "F080000000"},
        {"04", "C0FFFF"},
        {"05", "F0FFFFFFFF"},
        {"06", "3F800000"},
        {"07", "C004000000000000"},
        {"08", "01"},
        {"09", "41"},
        {"0A", "FF"},
        {"0B", "03 2A"},
        {"0C", "13 03 00"},
        {"0E 0100 0100", "0100 FF"},
        {"0E 0100 0100", "024100 00 00 03 1801"},
        {"0E 0100 0100", "024100 00 01 05"},
        {status_code, "8080 024100"},
        {tree_code, "01 02 02 00 03 01 04 00"},
        {union_code, "01 FF"},
        {union_code, "03 024100"},
        {union_code, "00 024100"},
        {union_code, "7F 01"},
        {union_code, "02 00"},
        {enum_code, "02"},
        {"12 01", "024100"},
        {"13 04 00", "02 01 8080"},
        {"13 0F 0100 0100 02 0100 0A 0100 08 02", "02 FF01 FE00"},
        {"14 14 03 03 02", "01 02 03 04 05 06"},
        {"15 0100 0100 08", "00"},
        {"16 0100 0100 01 0100 08", "01"},
        {"17", "0102030405060708"},
        {"18", "0102030405060708"},
        {"19", "3FFF0000000000000000000000000000"},
        {"1A", "0041"},
        {"1B 01", "0200410000"},
        {"1C 05 02", "12345C"},
    };
    for (const auto& [code, value] : cases) {
        ASSERT_TRUE(is_type_code(code)) << code;
        EXPECT_TRUE(is_value(code, value)) << code << " : " << value;
        const std::string all = hex(octets(value));
        for (std::size_t size = 0; size < all.size(); size += 2) {
            EXPECT_FALSE(is_value(code, all.substr(0, size))) << code << " : " << value;
        }
        EXPECT_FALSE(is_value(code, all + "00")) << code << " : " << value;
    }
    EXPECT_TRUE(is_value("00", ""));
    EXPECT_TRUE(is_value("01", ""));
    EXPECT_TRUE(is_value("0F 0100 0100 00", ""));
}

TEST(Value, ThatItsTypeDoesNotHaveIsRefused) {
    EXPECT_FALSE(is_value("02", "C08000")) << "32768 as a short";
    EXPECT_FALSE(is_value("08", "02"));
    EXPECT_FALSE(is_value(enum_code, "03"));
    EXPECT_FALSE(is_value("12 01", "03414200")) << "above its bound";
    EXPECT_FALSE(is_value("1B 01", "03004100410000")) << "above its bound";
    EXPECT_FALSE(is_value("13 03 01", "020101")) << "above its bound";
    EXPECT_FALSE(is_value("1C 05 02", "12345A"));
    EXPECT_FALSE(is_value("0E 0100 0100", "0100 01 00 03 1801")) << "an unknown profile";
    EXPECT_FALSE(is_value("0E 0100 0100", "0100 00 02 05")) << "neither object nor group";
    EXPECT_FALSE(is_value("0B", "0D")) << "an any of an unknown kind";
    EXPECT_FALSE(is_value("0C", "0D"));
}

TEST(Value, WithoutADefaultOrACaseIsItsDiscriminator) {
    constexpr std::string_view code = "10 0100 0100 03 7F 01 01 0100 0A";
    EXPECT_TRUE(is_value(code, "01 FF"));
    EXPECT_TRUE(is_value(code, "02"));
    EXPECT_FALSE(is_value(code, "02 FF"));
}

TEST(Value, OfARecursiveTypeHasAtMost64Levels) {
    std::string value = "0100";
    for (int level = 1; level < 65; ++level) value = "0101" + value;
    EXPECT_TRUE(is_value(tree_code, value)) << "64 recursions within the first";
    EXPECT_FALSE(is_value(tree_code, "0101" + value));
    EXPECT_FALSE(is_value(tree_code, hex(std::vector<std::uint8_t>(65538, 1))));
}

TEST(Value, ElementsWithoutOctetsAreLimited) {
    constexpr std::string_view code = "13 0F 0100 0100 00 00";
    EXPECT_TRUE(is_value(code, "C10002"));
    EXPECT_FALSE(is_value(code, "C10003"));
    EXPECT_TRUE(is_value("14 14 0F 0100 0100 00 F0FFFFFFFF F0FFFFFFFF", "")) << "takes no time";
}

TEST(Value, WorkThatNoRealTypeNeedsIsRefused) {
    // A sequence of structs of one octet and 6000 members that take none.
    std::string code = "13 0F 0100 0100 9771 0100 0A";  // 6001 members
    for (int i = 0; i < 6000; ++i) code += "0100 0F 0100 0100 00";
    code += "00";
    ASSERT_TRUE(is_type_code(code));
    EXPECT_TRUE(is_value(code, "03 010203"));
    EXPECT_FALSE(is_value(code, "9F40" + std::string(2 * 8000, '0')));
}

}  // namespace
}  // namespace canorb::test
