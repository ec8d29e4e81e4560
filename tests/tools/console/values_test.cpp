// Octets that were received become values that people read; and what is no value.

#include "tools/console/values.hpp"

#include <gmock/gmock.h>

#include "tests/support/octets.hpp"
#include "tests/tools/console/model_of.hpp"
#include "tools/console/arguments.hpp"

namespace canorb::console {
namespace {

using canorb::test::octets;
using test::model_of;

/// The result of an operation `TYPE op()`, behind whatever else the IDL declares.
class Values : public testing::Test {
  protected:
    void declare(const std::string& type, const std::string& idl = "") {
        model_ = model_of(idl + "\ninterface Device { " + type + " op(); void set(in " + type +
                          " x); };");
    }
    std::string text_of(std::string_view hex_octets) const {
        const Operation* op = model_->find_interface("Device")->find("op", 0);
        const auto body = octets(hex_octets);
        const auto results = decode_results(*op, body, *model_);
        if (!results) return results.error();
        return to_text(results->at(0).second);
    }
    /// What is printed may be written as an argument again, where it is JSON.
    void expect_same_octets(std::string_view hex_octets) const {
        const Operation* set = model_->find_interface("Device")->find("set", 1);
        const auto again =
            encode_arguments(*set, std::vector<std::string>{text_of(hex_octets)}, *model_);
        ASSERT_TRUE(again) << again.error();
        EXPECT_EQ(*again, octets(hex_octets));
    }

    std::unique_ptr<Model> model_;
};

TEST_F(Values, Numbers) {
    declare("unsigned short");
    EXPECT_EQ(text_of("C0FFFF"), "65535");
    EXPECT_EQ(text_of("C10000"), "what should be result is no unsigned short");
    EXPECT_EQ(text_of(""), "what should be result is no unsigned short");
    EXPECT_EQ(text_of("8001"), "what should be result is no unsigned short");
    EXPECT_EQ(text_of("00 AB CD"), "it has 2 octets too many: ABCD");
    declare("short");
    EXPECT_EQ(text_of("DF8000"), "-32768");
    declare("long long");
    EXPECT_EQ(text_of("FFFFFFFFFFFFFFFE"), "-2");
    declare("unsigned long long");
    EXPECT_EQ(text_of("FFFFFFFFFFFFFFFF"), "18446744073709551615");
    declare("int8");
    EXPECT_EQ(text_of("80"), "-128");
    declare("octet");
    EXPECT_EQ(text_of("80"), "128");
    declare("float");
    EXPECT_EQ(text_of("3DCCCCCD"), "0.1");
    EXPECT_EQ(text_of("3F800000"), "1.0");
    EXPECT_EQ(text_of("7FC00000"), "\"nan\"");
    EXPECT_EQ(text_of("FF800000"), "\"-inf\"");
    declare("double");
    EXPECT_EQ(text_of("C004000000000000"), "-2.5");
    declare("long double");
    EXPECT_EQ(text_of("C0004000000000000000000000000000"), "\"-2.5\"");
    declare("boolean");
    EXPECT_EQ(text_of("01"), "true");
    EXPECT_EQ(text_of("02"), "what should be result is no boolean");
    declare("Price", "typedef fixed<5,2> Price;");
    EXPECT_EQ(text_of("12345C"), "\"123.45\"");
    EXPECT_EQ(text_of("12345E"), "what should be result is no Price");
}

TEST_F(Values, TextsCannotGiveOrdersToATerminal) {
    declare("string");
    EXPECT_EQ(text_of("03C3A400"), "\"ä\"");
    EXPECT_EQ(text_of("04 1B5B6D 00"), R"("\u001b[m")");
    EXPECT_EQ(text_of("04 C29B7F 00"), R"("\u009B\u007F")");
    EXPECT_EQ(text_of("02 FF 00"), "\"\xEF\xBF\xBD\"");
    EXPECT_EQ(text_of("00"), "what should be result is no string");
    EXPECT_EQ(text_of("03 4100 00"), "what should be result is no string");
    EXPECT_EQ(text_of("7F 41"), "what should be result is no string");
    declare("string<1>");
    EXPECT_EQ(text_of("03 4142 00"), "what should be result is no string<1>");
    declare("wstring");
    EXPECT_EQ(text_of("03 D83D DE00 0000"), "\"\U0001F600\"");
    EXPECT_EQ(text_of("02 D83D 0000"), "\"\xEF\xBF\xBD\"");
    declare("char");
    EXPECT_EQ(text_of("41"), "\"A\"");
    EXPECT_EQ(text_of("E4"), "\"\\\\xE4\"");
    declare("wchar");
    EXPECT_EQ(text_of("00E4"), "\"ä\"");
}

TEST_F(Values, EnumeratorsAndFlags) {
    declare("Speed", "enum Speed { slow, fast };");
    EXPECT_EQ(text_of("01"), "\"fast\"");
    EXPECT_EQ(text_of("02"), "what should be result is no Speed");
    declare("Alarms", "@bit_bound(4) bitmask Alarms { hot, @position(2) stalled };");
    EXPECT_EQ(text_of("05"), "\"hot|stalled\"");
    EXPECT_EQ(text_of("09"), "\"hot|8\"");
    EXPECT_EQ(text_of("00"), "\"0\"");
    EXPECT_EQ(text_of("10"), "what should be result is no Alarms");
}

TEST_F(Values, WhatIsConstructedCanBeWrittenAgain) {
    declare("Status", R"(
        enum Form { point, circle };
        union Shape switch (Form) { case circle: float radius; };
        typedef sequence<Shape> ShapeSeq;
        typedef octet Pair[2];
        typedef map<short, string> NameMap;
        struct Status { octet level; ShapeSeq shapes; Pair sides; NameMap names; };)");
    const char* const status = "07 02 00 01 3F800000 0102 01 40 02 41 00";
    EXPECT_EQ(text_of(status),
              R"({"level":7,"shapes":[{"_d":"point"},{"_d":"circle","radius":1.0}])"
              R"(,"sides":[1,2],"names":{"-64":"A"}})");
    expect_same_octets(status);
    EXPECT_EQ(text_of("07 02 00 02"), "what should be result.shapes[1]._d is no Form");
    EXPECT_EQ(text_of("07 7F"), "what should be result.shapes is no ShapeSeq");
    EXPECT_EQ(text_of("07 00 0102 02 40 02 41 00 40 02 41 00"),
              "what should be result.names is no NameMap");
}

TEST_F(Values, References) {
    declare("Device");
    EXPECT_EQ(text_of("1649444C3A446576696365732F4D6F746F723A312E30000000031801"),
              "\"CAN_IOR:1649444c3a446576696365732f4d6f746f723a312e30000000031801\"");
    EXPECT_EQ(text_of("0100FF"), "\"nil\"");
    EXPECT_EQ(text_of("0100000120"), "what should be result is no Device");
}

TEST_F(Values, AnyShowsItsType) {
    declare("any", "struct Point { octet x; octet y; };");
    EXPECT_EQ(text_of("00"), "null");
    EXPECT_EQ(text_of("032A"), R"({"type":"long","value":42})");
    const char* const point = "0F0E49444C3A506F696E743A312E300001000201000A01000A0102";
    EXPECT_EQ(text_of(point), R"({"type":"Point","value":{"x":1,"y":2}})");
    expect_same_octets(point);
    EXPECT_EQ(text_of("13 0A 00 02 01 02"), R"({"type":"sequence<octet>","value":[1,2]})");
    // A struct of one octet that has no id.
    EXPECT_EQ(text_of("0F0100010001 0100 0A 07"),
              R"({"typecode":"0F010001000101000A","octets":"07"})");
    EXPECT_EQ(text_of("0D"), "what should be result is no any");
    EXPECT_EQ(text_of("08 02"), "what should be result.value is no boolean");
    std::string deep;
    for (int i = 0; i < 70; ++i) deep += "0B";
    EXPECT_THAT(text_of(deep + "00"), testing::EndsWith(" is no any"));
    declare("CORBA::TypeCode");
    EXPECT_EQ(text_of("04"), "\"unsigned short\"");
    EXPECT_EQ(text_of("0F0100010001 0100 0A"), "\"0F010001000101000A\"");
}

TEST_F(Values, ThatAreManyOfNothingCostLittle) {
    declare("Rooms", R"(struct Nothing {}; typedef Nothing Floor[1000]; typedef Floor House[1000];
        typedef sequence<House> Rooms;)");
    // 65538 times a million: no message has so much.
    EXPECT_THAT(text_of("C10002"), testing::StartsWith("what should be result[0][261]"));
    EXPECT_EQ(text_of("C10003"), "what should be result is no Rooms");
}

TEST_F(Values, WithinThemselvesHaveAtMost64Levels) {
    declare("Tree", R"(struct Tree; typedef sequence<Tree> Trees;
        struct Tree { octet value; Trees children; };)");
    std::string deep;
    for (int i = 0; i < 63; ++i) deep += "0101";
    EXPECT_THAT(text_of(deep + "0100"), testing::StartsWith("{\"value\":1"));
    EXPECT_THAT(text_of(deep + "01010100"), testing::EndsWith(" is no Tree"));
}

TEST(NamedValues, AreThoseOfRepliesRequestsAndExceptions) {
    const auto model = model_of(R"(exception Fault { octet code; string reason; };
        interface Motor {
            float run(in octet channel, inout short speed, out boolean on) raises (Fault); };)");
    const Operation* run = model->find_interface("Motor")->find("run", 2);
    const auto body = octets("3F800000 7F 01");
    const auto results = decode_results(*run, body, *model);
    ASSERT_TRUE(results) << results.error();
    EXPECT_EQ(to_text(*results), "{result: 1.0, speed: -1, on: true}");
    const auto request = octets("02 7F");
    const auto arguments = decode_arguments(*run, request, *model);
    ASSERT_TRUE(arguments) << arguments.error();
    EXPECT_EQ(to_text(*arguments), "{channel: 2, speed: -1}");
    const auto members_octets = octets("09 02 41 00");
    const auto members =
        decode_members(*model->find_exception("IDL:Fault:1.0"), members_octets, *model);
    ASSERT_TRUE(members) << members.error();
    EXPECT_EQ(to_text(*members), "{code: 9, reason: \"A\"}");
    const auto cut = octets("09 02 41");
    EXPECT_EQ(decode_members(*model->find_exception("IDL:Fault:1.0"), cut, *model).error(),
              "what should be reason is no string");
}

}  // namespace
}  // namespace canorb::console
