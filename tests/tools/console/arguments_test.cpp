// What people write as arguments becomes octets, or a sentence that says what is wrong. The octets
// are by hand from doc/wire/ccdr.md.

#include "tools/console/arguments.hpp"

#include <gmock/gmock.h>

#include "tests/support/octets.hpp"
#include "tests/tools/console/model_of.hpp"

namespace canorb::console {
namespace {

using test::model_of;

/// The parameters of an operation `void op(in TYPE x)`, behind whatever else the IDL declares.
class Arguments : public testing::Test {
  protected:
    void declare(const std::string& type, const std::string& idl = "") {
        model_ = model_of(idl + "\ninterface Device { void op(in " + type + " x); };");
    }
    Result<std::vector<std::uint8_t>, std::string> encoded(const std::string& text) const {
        const Operation* op = model_->find_interface("Device")->find("op", 1);
        return encode_arguments(*op, std::vector<std::string>{text}, *model_);
    }
    std::string octets_of(const std::string& text) const {
        const auto result = encoded(text);
        return result ? canorb::test::hex(*result) : result.error();
    }
    /// Without "argument 1 (x".
    std::string error_of(const std::string& text) const {
        const auto result = encoded(text);
        if (result) return "no error: " + canorb::test::hex(*result);
        constexpr std::string_view head = "argument 1 (x";
        EXPECT_TRUE(result.error().starts_with(head)) << result.error();
        return result.error().substr(head.size());
    }

    std::unique_ptr<Model> model_;
};

TEST_F(Arguments, IntegersAreWithinTheirTypes) {
    declare("unsigned short");
    EXPECT_EQ(octets_of("0"), "00");
    EXPECT_EQ(octets_of("127"), "7F");
    EXPECT_EQ(octets_of("0x80"), "8080");
    EXPECT_EQ(octets_of("+65535"), "C0FFFF");
    EXPECT_EQ(error_of("65536"), ": unsigned short): 65536 is not 0 to 65535");
    EXPECT_EQ(error_of("-1"), ": unsigned short): -1 is not 0 to 65535");
    EXPECT_EQ(error_of(""), ": unsigned short): '' is not 0 to 65535");
    EXPECT_EQ(error_of("1.5"), ": unsigned short): 1.5 is not 0 to 65535");
    EXPECT_EQ(error_of("99999999999999999999"),
              ": unsigned short): 99999999999999999999 is not 0 to 65535");

    declare("short");
    EXPECT_EQ(octets_of("-64"), "40");
    EXPECT_EQ(octets_of("-32768"), "DF8000");
    EXPECT_EQ(error_of("-32769"), ": short): -32769 is not -32768 to 32767");

    declare("long");
    EXPECT_EQ(octets_of("-65"), "BFBF");
    EXPECT_EQ(octets_of("-2147483648"), "F080000000");
    EXPECT_EQ(error_of("2147483648"), ": long): 2147483648 is not -2147483648 to 2147483647");

    declare("unsigned long");
    EXPECT_EQ(octets_of("4294967295"), "F0FFFFFFFF");
    EXPECT_EQ(error_of("4294967296"), ": unsigned long): 4294967296 is not 0 to 4294967295");

    declare("long long");
    EXPECT_EQ(octets_of("-2"), "FFFFFFFFFFFFFFFE");
    EXPECT_EQ(octets_of("-9223372036854775808"), "8000000000000000");
    EXPECT_EQ(error_of("9223372036854775808"),
              ": long long): 9223372036854775808 is not -9223372036854775808 to "
              "9223372036854775807");

    declare("unsigned long long");
    EXPECT_EQ(octets_of("18446744073709551615"), "FFFFFFFFFFFFFFFF");

    declare("octet");
    EXPECT_EQ(octets_of("255"), "FF");
    EXPECT_EQ(error_of("256"), ": octet): 256 is not 0 to 255");

    declare("int8");
    EXPECT_EQ(octets_of("-128"), "80");
    EXPECT_EQ(error_of("-129"), ": int8): -129 is not -128 to 127");
}

TEST_F(Arguments, FloatingPointNumbers) {
    declare("float");
    EXPECT_EQ(octets_of("1"), "3F800000");
    EXPECT_EQ(octets_of("-2.5"), "C0200000");
    EXPECT_EQ(octets_of("inf"), "7F800000");
    EXPECT_EQ(error_of("1e39"), ": float): 1e39 is too large, or too close to 0, for this type");
    EXPECT_EQ(error_of("fast"),
              ": float): 'fast' is not a number such as -1.5e3, or inf, -inf or nan");
    declare("double");
    EXPECT_EQ(octets_of("-2.5"), "C004000000000000");
    EXPECT_EQ(octets_of("1e39").size(), 16U);
    declare("long double");
    EXPECT_EQ(octets_of("-2.5"), "C0004000000000000000000000000000");
}

TEST_F(Arguments, BooleansAndCharacters) {
    declare("boolean");
    EXPECT_EQ(octets_of("true"), "01");
    EXPECT_EQ(octets_of("FALSE"), "00");
    EXPECT_EQ(octets_of("1"), "01");
    EXPECT_EQ(error_of("yes"), ": boolean): 'yes' is not true or false");
    declare("char");
    EXPECT_EQ(octets_of("A"), "41");
    EXPECT_EQ(octets_of("\\xE4"), "E4");
    EXPECT_EQ(error_of("ä"), ": char): 'ä' is not one character of ASCII, or one octet as \\xE4");
    EXPECT_EQ(error_of("\\xG4"),
              ": char): '\\xG4' is not one character of ASCII, or one octet as \\xE4");
    declare("wchar");
    EXPECT_EQ(octets_of("ä"), "00E4");
    EXPECT_EQ(error_of("AB"), ": wchar): 'AB' is not one character of UTF-16's first plane");
    EXPECT_EQ(error_of("\U0001F600"),
              ": wchar): '\U0001F600' is not one character of UTF-16's first plane");
}

TEST_F(Arguments, TextsAreTakenAsTheyAreAndWithinTheirBounds) {
    declare("string");
    EXPECT_EQ(octets_of(""), "0100");
    EXPECT_EQ(octets_of("A"), "024100");
    EXPECT_EQ(octets_of("\"A\""), "0422412200");
    EXPECT_EQ(octets_of("ä"), "03C3A400");
    declare("string<3>");
    EXPECT_EQ(octets_of("abc"), "0461626300");
    EXPECT_EQ(error_of("abcd"), ": string<3>): 'abcd' has 4 octets; at most 3 are accepted");
    declare("wstring<2>");
    EXPECT_EQ(octets_of("A"), "0200410000");
    EXPECT_EQ(octets_of("\U0001F600"), "03D83DDE000000");
    EXPECT_EQ(error_of("abc"), ": wstring<2>): 'abc' has 3 code units; at most 2 are accepted");
    EXPECT_EQ(error_of("\xFF"), ": wstring<2>): '\xFF' is not a text of UTF-8 in quotes");
}

TEST_F(Arguments, FixedLosesNoDigit) {
    declare("Price", "typedef fixed<5,2> Price;");
    EXPECT_EQ(octets_of("123.45"), "12345C");
    EXPECT_EQ(octets_of("-1.2"), "00120D");
    EXPECT_EQ(octets_of("-0"), "00000C");
    EXPECT_EQ(octets_of("007.500"), "00750C");
    EXPECT_EQ(error_of("1.234"),
              ": Price): 1.234 is not a number of at most 3 digits before and 2 behind the "
              "point");
    EXPECT_THAT(error_of("1234"), testing::HasSubstr("1234 is not a number of"));
    EXPECT_THAT(error_of("1e2"), testing::HasSubstr("1e2 is not a number of"));
    EXPECT_THAT(error_of("1.2.3"), testing::HasSubstr("1.2.3 is not a number of"));
    EXPECT_THAT(error_of("."), testing::HasSubstr("'.' is not a number of"));
    declare("Price", "typedef fixed<2,1> Price;");
    EXPECT_EQ(octets_of("-1.2"), "012D");
}

TEST_F(Arguments, EnumeratorsAndFlagsByName) {
    declare("Speed", "enum Speed { slow, fast };");
    EXPECT_EQ(octets_of("fast"), "01");
    EXPECT_EQ(error_of("faster"), ": Speed): 'faster' is not one of slow, fast");
    EXPECT_EQ(error_of("1"), ": Speed): 1 is not one of slow, fast");
    declare("Speed", "enum Speed { @value(5) slow, @value(300) fast };");
    EXPECT_EQ(octets_of("fast"), "812C");
    declare("Alarms", "@bit_bound(12) bitmask Alarms { hot, @position(9) stalled };");
    EXPECT_EQ(octets_of("hot|stalled"), "8201");
    EXPECT_EQ(octets_of("0"), "00");
    EXPECT_EQ(octets_of("hot|4"), "05");
    EXPECT_EQ(error_of("cold"),
              ": Alarms): 'cold' is not hot, stalled, several of them with | between, or a number "
              "from 0 to 4095");
    EXPECT_THAT(error_of("4096"), testing::HasSubstr("4096 is not hot"));
}

TEST_F(Arguments, SequencesAndArrays) {
    declare("Samples", "typedef sequence<unsigned short, 3> Samples;");
    EXPECT_EQ(octets_of("[1, 128, 65535]"), "03018080C0FFFF");
    EXPECT_EQ(octets_of("[]"), "00");
    EXPECT_EQ(error_of("[1, 70000]"), "[1]: unsigned short): 70000 is not 0 to 65535");
    EXPECT_EQ(error_of("[1, \"2\"]"), "[1]: unsigned short): '2' is not 0 to 65535");
    EXPECT_EQ(error_of("[1,2,3,4]"), ": Samples): has 4 elements; at most 3 are accepted");
    EXPECT_EQ(error_of("7"), ": Samples): 7 is not a JSON array of unsigned short");
    EXPECT_THAT(error_of("[1,"),
                testing::StartsWith(": Samples): '[1,' is not JSON, which is accepted here: parse "
                                    "error at line 1, column 4"));
    declare("Matrix", "typedef short Matrix[2][2];");
    EXPECT_EQ(octets_of("[[1, 2], [3, -1]]"), "0102037F");
    EXPECT_EQ(error_of("[[1, 2], [3]]"), "[1]: short[2]): has 1 elements; 2 are accepted");
}

TEST_F(Arguments, Structs) {
    const std::string idl = "struct Base { octet level; }; struct Status : Base { string name; };";
    declare("Status", idl);
    EXPECT_EQ(octets_of(R"({"name": "A", "level": 7})"), "07024100");
    EXPECT_EQ(error_of(R"({"level": 7})"), ": Status): the member 'name' is missing");
    EXPECT_EQ(error_of(R"({"level": 7, "name": "", "x": 1})"),
              ": Status): has no member 'x', but level, name");
    EXPECT_EQ(error_of(R"({"level": 7, "name": "", "level": 8})"),
              ": Status): has the member 'level' twice");
    EXPECT_EQ(error_of(R"({"level": 256, "name": ""})"), ".level: octet): 256 is not 0 to 255");
    EXPECT_EQ(error_of(R"({"level": 1, "name": 5})"), ".name: string): 5 is not a text in quotes");
    EXPECT_EQ(error_of(R"({"level": 1, "name": "\u0000"})"),
              ".name: string): a string cannot have a NUL in it");
    EXPECT_EQ(error_of("[]"), ": Status): an array is not an object with the members level, name");
}

TEST_F(Arguments, Unions) {
    declare("Shape", R"(enum Form { point, circle, square, oval };
        union Shape switch (Form) {
          case circle: float radius;
          case square: case oval: octet sides;
        };)");
    EXPECT_EQ(octets_of(R"({"radius": 1})"), "013F800000");
    EXPECT_EQ(octets_of(R"({"_d": "circle", "radius": 1})"), "013F800000");
    EXPECT_EQ(octets_of(R"({"sides": 4, "_d": "oval"})"), "0304");
    EXPECT_EQ(octets_of(R"({"_d": "point"})"), "00");
    EXPECT_EQ(error_of(R"({"sides": 4})"),
              ": Shape): more than one discriminator selects 'sides': say which as _d");
    EXPECT_EQ(error_of(R"({"_d": "circle", "sides": 4})"),
              ": Shape): the discriminator selects the member 'radius'");
    EXPECT_EQ(error_of(R"({"_d": "point", "sides": 4})"),
              ": Shape): the discriminator selects no member");
    EXPECT_EQ(error_of(R"({"_d": "line"})"),
              "._d: Form): 'line' is not one of point, circle, square, oval");
    EXPECT_THAT(error_of(R"({"radius": 1, "sides": 4})"), testing::HasSubstr("is too much"));
    EXPECT_THAT(error_of("{}"), testing::HasSubstr("is empty"));

    declare("Number", R"(union Number switch (short) {
        case -1: long negative; default: octet other; };)");
    EXPECT_EQ(octets_of(R"({"negative": 64})"), "7F8040");
    EXPECT_EQ(octets_of(R"({"_d": 64, "other": 1})"), "804001");
    EXPECT_THAT(error_of(R"({"other": 1})"), testing::HasSubstr("say which as _d"));
}

TEST_F(Arguments, Maps) {
    declare("Names", "typedef map<octet, string, 2> Names;");
    EXPECT_EQ(octets_of(R"({"1": "A", "2": ""})"),
              "02010241000201"
              "00");
    EXPECT_EQ(error_of(R"({"x": "A"})"), "['x']: octet): 'x' is not 0 to 255");
    EXPECT_EQ(error_of(R"({"1": "", "0x1": ""})"), "['0x1']: Names): this key is there twice");
    EXPECT_EQ(error_of(R"({"1": "", "2": "", "3": ""})"),
              ": Names): has 3 entries; at most 2 are accepted");
    EXPECT_EQ(error_of("[[1]]"), ": Names): an array is not a JSON object");
}

TEST_F(Arguments, ReferencesInBothForms) {
    declare("Device");
    EXPECT_EQ(octets_of("CAN_IOR:1649444c3a446576696365732f4d6f746f723a312e30000000031801"),
              "1649444C3A446576696365732F4D6F746F723A312E30000000031801");
    EXPECT_EQ(octets_of("corbaloc:caniop:3/1"), "01000000031801");
    EXPECT_EQ(octets_of("corbaloc:caniop:group/5"), "0100000105");
    EXPECT_EQ(octets_of("nil"), "0100FF");
    EXPECT_EQ(error_of("corbaloc:caniop:31/1"),
              ": Device): 'corbaloc:caniop:31/1' is no reference (CAN_IOR:..., "
              "corbaloc:caniop:NODE/INDEX, corbaloc:caniop:group/GROUP or nil): the node is not a "
              "number from 0 to 30");
    declare("Object");
    EXPECT_EQ(octets_of("corbaloc:caniop:group/5"), "0100000105");
}

TEST_F(Arguments, AnyNamesItsType) {
    declare("any", "struct Point { octet x; octet y; }; enum Speed { slow, fast };");
    EXPECT_EQ(octets_of("null"), "00");
    EXPECT_EQ(octets_of(R"({"type": "long", "value": 42})"), "032A");
    EXPECT_EQ(octets_of(R"({"type": "any", "value": {"type": "boolean", "value": true}})"),
              "0B0801");
    // tk_struct, "IDL:Point:1.0", "", two members "" of tk_octet
    EXPECT_EQ(octets_of(R"({"type": "Point", "value": {"x": 1, "y": 2}})"),
              "0F0E49444C3A506F696E743A312E300001000201000A01000A0102");
    // tk_enum, "IDL:Speed:1.0", "", two names ""
    EXPECT_EQ(octets_of(R"({"type": "Speed", "value": "fast"})"),
              "110E49444C3A53706565643A312E3000010002"
              "01000100"
              "01");
    EXPECT_EQ(error_of("7"),
              ": any): 7 is not an object such as {\"type\": \"long\", \"value\": 5}");
    EXPECT_EQ(error_of(R"({"type": "longer", "value": 42})"),
              ": any): 'longer' is not the name of a type, such as unsigned short or one of the "
              "IDL");
    EXPECT_EQ(error_of(R"({"type": "octet", "value": 256})"),
              ".value: octet): 256 is not 0 to 255");
}

TEST_F(Arguments, ValuesWithinThemselvesHaveAtMost64Levels) {
    declare("Tree", R"(struct Tree; typedef sequence<Tree> Trees;
        struct Tree { octet value; Trees children; };)");
    EXPECT_EQ(octets_of(R"({"value": 1, "children": [{"value": 2, "children": []}]})"), "01010200");
    const auto nest = [](int levels) {
        std::string text;
        for (int i = 0; i < levels; ++i) text += R"({"value": 1, "children": [)";
        for (int i = 0; i < levels; ++i) text += "]}";
        return text;
    };
    EXPECT_EQ(octets_of(nest(64)).size(), 256U);
    EXPECT_THAT(error_of(nest(65)), testing::EndsWith("Tree): has more than 64 levels"));
    EXPECT_THAT(error_of(nest(5000)), testing::HasSubstr("there are more than 512 levels"));
}

TEST_F(Arguments, MessagesHaveAnEnd) {
    declare("string");
    EXPECT_EQ(octets_of(std::string(65526, 'x')).size(), 2 * 65530U);
    EXPECT_EQ(error_of(std::string(65527, 'x')),
              ": string): the arguments are longer than a message can be, 65530 octets");
    declare("Nothings", "struct Nothing {}; typedef sequence<Nothing> Nothings;");
    EXPECT_EQ(octets_of("[{}, {}]"), "02");
}

TEST(ArgumentsOfOperations, AreCountedAndNamed) {
    const auto model = model_of(R"(interface Motor {
        void run(in octet channel, in unsigned short speed, out octet was, inout boolean on);
        attribute float limit;
    };)");
    const Interface* motor = model->find_interface("IDL:Motor:1.0");
    ASSERT_NE(motor, nullptr);
    const Operation* run = motor->find("run", 0);
    ASSERT_NE(run, nullptr);
    const auto encode = [&](const Operation& op, const std::vector<std::string>& texts) {
        const auto result = encode_arguments(op, texts, *model);
        return result ? canorb::test::hex(*result) : result.error();
    };
    EXPECT_EQ(encode(*run, {"1", "128", "true"}), "01808001");
    EXPECT_EQ(encode(*run, {"1", "70000", "true"}),
              "argument 2 (speed: unsigned short): 70000 is not 0 to 65535");
    EXPECT_EQ(encode(*run, {"1", "2", "3"}), "argument 3 (on: boolean): 3 is not true or false");
    EXPECT_EQ(encode(*run, {"1"}),
              "run takes 3 arguments, not 1: void run(in octet channel, in unsigned short speed, "
              "out octet was, inout boolean on)");
    // An attribute: its name reads or writes it.
    ASSERT_NE(motor->find("limit", 0), nullptr);
    ASSERT_NE(motor->find("limit", 1), nullptr);
    EXPECT_EQ(motor->find("limit", 0)->name, "_get_limit");
    EXPECT_EQ(motor->find("_set_limit", 0)->name, "_set_limit");
    EXPECT_EQ(encode(*motor->find("limit", 1), {"1"}), "3F800000");
    EXPECT_EQ(motor->find("limits", 0), nullptr);
}

}  // namespace
}  // namespace canorb::console
