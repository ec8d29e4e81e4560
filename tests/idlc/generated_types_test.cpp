// What the golden files' unions, bitmasks, recursive and inherited types do when they run.

#include <canorb/types.hpp>

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "composites.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {
namespace {

using namespace Parts;  // NOLINT: what is tested

template <typename T>
std::string encoded(const T& value) {
    std::array<std::uint8_t, 8192> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, value);
    if (out.error() == ccdr::EncodeError::bad_value) return "bad value";
    return hex(out.octets());
}

template <typename T>
bool decoded(std::string_view text, T& value) {
    const std::vector<std::uint8_t> in_octets = octets(text);
    ccdr::Decoder in{in_octets};
    decode(in, value);
    return in.finished();
}

template <typename T>
std::string printed(const T& value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

/// Both ways, and that no beginning of the octets is a value.
template <typename T>
void expect_octets(const T& value, std::string_view golden) {
    EXPECT_EQ(encoded(value), golden);
    T back{};
    EXPECT_TRUE(decoded(golden, back)) << golden;
    EXPECT_EQ(back, value);
    for (std::size_t digits = 0; digits < golden.size(); digits += 2) {
        T none{};
        EXPECT_FALSE(decoded(golden.substr(0, digits), none)) << golden.substr(0, digits);
    }
}

/// Through an any: the type code is well-formed and describes these octets.
template <typename T>
void expect_in_any(const T& value) {
    Any any;
    any <<= value;
    std::array<std::uint8_t, 8192> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, any);
    ASSERT_EQ(out.error(), ccdr::EncodeError::none);
    Any received;
    ccdr::Decoder in{out.octets()};
    decode(in, received);
    ASSERT_TRUE(in.finished()) << hex(any.type().octets());
    T back{};
    EXPECT_TRUE(received >>= back);
    EXPECT_EQ(back, value);
    std::int32_t other{};
    EXPECT_FALSE(received >>= other);
}

template <typename Call>
std::string bad_param(Call call) {
    try {
        call();
    } catch (const BAD_PARAM& error) {
        return error.what();
    }
    return "nothing";
}

TEST(GeneratedEnumTest, HasTheNumbersOfTheIdl) {
    static_assert(static_cast<std::uint32_t>(Gear::NEUTRAL) == 4);
    expect_octets(Gear::LOW, "03");
    expect_octets(Gear::HIGH, "09");
    Gear gear{};
    for (const char* wrong : {"00", "02", "05", "08", "0A", "F0FFFFFFFF"}) {
        EXPECT_FALSE(decoded(wrong, gear)) << wrong;
    }
    EXPECT_EQ(encoded(Gear{5}), "bad value");
    expect_in_any(Gear::HIGH);
    expect_in_any(Mode::RUN);
    EXPECT_EQ(printed(Gear::NEUTRAL), "NEUTRAL");
    EXPECT_EQ(printed(Gear{5}), "5");
}

TEST(GeneratedBitmaskTest, CombinesFlags) {
    static_assert((Alarms::HOT | Alarms::STALLED) == urgent);
    static_assert(canorb::has(urgent, Alarms::HOT) && !canorb::has(urgent, Alarms::LATE));
    expect_octets(Alarms::HOT | Alarms::LATE, "8801");
    expect_octets(Wide::TOP, "F080000000");
    expect_octets(Widest::FIRST | Widest::LAST, "8000000000000001");
    Alarms alarms{};
    EXPECT_TRUE(decoded("02", alarms));  // a bit without a name
    EXPECT_FALSE(decoded("9000", alarms));
    EXPECT_EQ(encoded(static_cast<Alarms>(0x1000)), "bad value");
    expect_in_any(urgent);
    expect_in_any(Widest::LAST);
    EXPECT_EQ(printed(urgent), "HOT|STALLED");
    const Stock::State state = Stock::State::FULL | Stock::start;
    EXPECT_EQ(printed(state), "FULL|LOCKED");
    EXPECT_EQ(printed(FileFlags::ONE | FileFlags::ONE), "ONE");
}

TEST(GeneratedStructTest, BeginsWithItsDefaults) {
    const Defaults defaults;
    EXPECT_EQ(encoded(defaults),
              "01"              // enabled
              "78"              // letter
              "7B"              // count
              "3F000000"        // share
              "056E6F6E6500"    // text
              "0673686F727400"  // tag
              "0200770000"      // wide
              "01"              // how
              "09"              // fastest
              "8801"            // pending
              "00150C"          // cost
              "04"              // current
              "01"              // running
              "00");            // plain
    expect_in_any(defaults);
}

TEST(GeneratedStructTest, InheritsMembers) {
    Part part;
    part.id = 300;
    part.at = {-1, 64};
    part.called = "pump";
    expect_octets(part, "812C7F80400570756D7000");
    Part other = part;
    other.at.x = 0;
    EXPECT_NE(part, other);
    expect_in_any(part);
    Marker marker;
    marker.id = 5;
    expect_octets(marker, "050000");
    expect_in_any(marker);
    EXPECT_EQ(printed(part),
              "{id: 300, at: {x: -1, y: 64}, called: \"pump\", reserved: {none: [{}, {}]}}");
}

TEST(GeneratedStructTest, TakesNoOctetsWhenEmpty) {
    EXPECT_EQ(encoded(AlsoNothing{}), "");
    EXPECT_EQ(ccdr::fewest_octets<AlsoNothing>, 0U);
    EXPECT_EQ(ccdr::fewest_octets<Marker>, 1U);
    expect_octets(std::vector<AlsoNothing>(3), "03");
    expect_in_any(AlsoNothing{});
}

Tree deep_tree(int levels) {
    Tree tree;
    if (levels > 1) tree.children.push_back(deep_tree(levels - 1));
    return tree;
}

TEST(GeneratedStructTest, ContainsItself) {
    Tree tree;
    tree.called = "a";
    tree.children.resize(1);
    tree.named["b"].called = "c";
    expect_octets(tree, "0261000101000000010262000263000000");
    expect_in_any(tree);
    EXPECT_EQ(printed(tree), R"({called: "a", children: [{called: "", children: [], named: {}}], )"
                             R"(named: {"b": {called: "c", children: [], named: {}}}})");
    EXPECT_NE(encoded(deep_tree(64)), "bad value");
    EXPECT_EQ(encoded(deep_tree(65)), "bad value");
    std::string hostile;
    for (int level = 0; level < 200; ++level) hostile += "010001";
    Tree back;
    EXPECT_FALSE(decoded(hostile, back));
}

TEST(GeneratedStructTest, CarriesEveryType) {
    Values values;
    values.precise = 1.0L;
    values.letter = u'\xD83D';
    values.text = u"\xD83D\xDE00";
    values.few = u"12345";
    values.sum = Money{"-99999999999999999999999999.99999"};
    values.anything <<= std::int32_t{5};
    values.names_of["pump"] = {std::string(300, 'x')};
    values.modes[-1] = Mode::RUN;
    values.flags_of[Gear::HIGH] = {true, false};
    values.of_both[1] = urgent;
    values.names[1][2] = "last";
    values.rows = {{}, {true}};
    values.kind = type_code<Tree>();
    const std::string golden = encoded(values);
    Values back;
    ASSERT_TRUE(decoded(golden, back));
    EXPECT_EQ(back, values);
    expect_in_any(values);
    EXPECT_NE(printed(values).find(R"(names: [["", "", ""], ["", "", "last"]])"),
              std::string::npos);
    for (std::size_t digits = 0; digits < golden.size(); digits += 2) {
        EXPECT_FALSE(decoded(std::string_view{golden}.substr(0, digits), back));
    }
    Values wrong = values;
    wrong.few = u"123456";
    EXPECT_EQ(encoded(wrong), "bad value");
    wrong = values;
    wrong.names_of["pump"][0] += 'x';
    EXPECT_EQ(encoded(wrong), "bad value");
    wrong = values;
    wrong.flags_of[Gear{1}];
    EXPECT_EQ(encoded(wrong), "bad value");
}

TEST(GeneratedExceptionTest, CarriesTypesOfItsOwn) {
    const Broken broken{Broken::Cause::FORCE, 7, "axle"};
    EXPECT_EQ(encoded(broken), "01070561786C6500");
    EXPECT_STREQ(broken.UserException::what(), "IDL:Parts/Broken:1.0");
    EXPECT_EQ(printed(broken), R"({why: FORCE, repository_id: 7, what: "axle"})");
    Any any;
    any <<= broken;
    Broken back;
    ASSERT_TRUE(any >>= back);
    EXPECT_EQ(back.what, "axle");
}

TEST(GeneratedUnionTest, HasTheMemberThatTheDiscriminatorSelects) {
    Reading reading;
    EXPECT_EQ(reading._d(), Mode::IDLE);
    EXPECT_EQ(reading.voltage(), 0.0);
    reading.voltage(1.0);
    expect_octets(reading, "003FF0000000000000");
    reading.voltage() = 2.0;
    EXPECT_EQ(printed(reading), "{_d: IDLE, voltage: 2}");
    reading.text("ok");
    EXPECT_EQ(reading._d(), Mode::RUN);
    expect_octets(reading, "01036F6B00");
    expect_in_any(reading);
    EXPECT_EQ(printed(reading), R"({_d: RUN, text: "ok"})");
    reading.text(std::string(401, 'x'));
    EXPECT_EQ(encoded(reading), "bad value");
    EXPECT_FALSE(decoded("02", reading));
}

TEST(GeneratedUnionTest, RefusesTheOtherMembers) {
    Reading reading;
    const Reading& constant = reading;
    for (const std::string& message :
         {bad_param([&] { reading.text(); }), bad_param([&] { (void)constant.text(); })}) {
        EXPECT_NE(message.find("BAD_PARAM"), std::string::npos) << message;
        EXPECT_NE(message.find("Parts::Reading::text"), std::string::npos) << message;
    }
    EXPECT_NE(bad_param([&] { reading._d(Mode::RUN); }).find("Parts::Reading::_d"),
              std::string::npos);
    EXPECT_NE(bad_param([&] { reading._d(static_cast<Mode>(9)); }), "nothing");
    EXPECT_EQ(reading, Reading{});
    reading._d(Mode::IDLE);
    EXPECT_EQ(reading, Reading{});
}

TEST(GeneratedUnionTest, TakesOneOfSeveralLabels) {
    Choice choice;
    EXPECT_EQ(choice._d(), 1);
    choice.number(-1, 2);
    expect_octets(choice, "027F");
    choice._d(1);
    expect_octets(choice, "017F");
    EXPECT_NE(bad_param([&] { choice.number(5, 3); }).find("Parts::Choice::number"),
              std::string::npos);
    EXPECT_EQ(choice.number(), -1);
    choice.octets({1, 2});
    EXPECT_EQ(choice._d(), std::numeric_limits<std::int32_t>::min());
    expect_octets(choice, "F080000000020102");
    choice.whole(Part{});
    EXPECT_EQ(choice._d(), 0);
    choice.whole(Part{}, 100);
    expect_octets(choice, "80640000000100");
    choice._d(-7);
    expect_in_any(choice);
    EXPECT_NE(bad_param([&] { choice.whole(Part{}, 1); }), "nothing");
    choice.number(6);
    expect_in_any(choice);
    EXPECT_EQ(printed(choice), "{_d: 1, number: 6}");
}

TEST(GeneratedUnionTest, MayHaveNoMember) {
    Maybe maybe;
    EXPECT_EQ(maybe.given(), Gear::NEUTRAL);
    expect_octets(maybe, "0104");
    maybe._default();
    EXPECT_FALSE(maybe._d());
    expect_octets(maybe, "00");
    EXPECT_EQ(printed(maybe), "{_d: false}");
    EXPECT_NE(bad_param([&] { maybe.given(); }), "nothing");
    EXPECT_NE(bad_param([&] { maybe._d(true); }), "nothing");
    expect_in_any(maybe);
    EXPECT_FALSE(decoded("02", maybe));
    EXPECT_FALSE(decoded("0100", maybe));
    EXPECT_FALSE(decoded("0000", maybe));
}

TEST(GeneratedUnionTest, IsSwitchedByEveryKindOfDiscriminator) {
    Letters letters;
    letters.value(5, 'b');
    expect_octets(letters, "6205");
    letters.discriminator(-1);
    expect_octets(letters, "FF7F");
    expect_in_any(letters);
    letters.encode("x");
    expect_octets(letters, "76027800");
    letters._default();
    letters._d('z');
    expect_octets(letters, "7A");
    expect_in_any(letters);

    Wides wides;
    wides.money(1.0F);
    expect_octets(wides, "20AC3F800000");
    expect_in_any(wides);
    Longs longs;
    expect_octets(longs, "800000000000000000");
    longs.one(3, 1);
    expect_octets(longs, "000000000000000103");
    expect_in_any(longs);
    Counts counts;
    counts.all(7);
    expect_octets(counts, "FFFFFFFFFFFFFFFF07");
    expect_in_any(counts);
    Tiny tiny;
    expect_octets(tiny, "FF00000000");
    tiny.none(Nothing{}, 127);
    expect_octets(tiny, "7F");
    expect_in_any(tiny);
    Gears gears;
    gears.other(1, Gear::HIGH);
    expect_octets(gears, "0901");
    expect_in_any(gears);
    EXPECT_FALSE(decoded("0001", gears));
}

TEST(GeneratedUnionTest, ContainsItself) {
    Expression one;
    one.constant(1.0);
    Expression sum;
    sum.sum({one, one});
    expect_octets(sum, "0102003FF0000000000000003FF0000000000000");
    Expression power;
    power.raised({{sum}, 2});
    expect_octets(power, "02010102003FF0000000000000003FF000000000000002");
    expect_in_any(power);
    expect_in_any(power.raised());
    EXPECT_EQ(printed(power),
              "{_d: 2, raised: {base: [{_d: 1, sum: [{_d: 0, constant: 1}, {_d: 0, constant: 1}]}],"
              " exponent: 2}}");
    std::string hostile;
    for (int level = 0; level < 1000; ++level) hostile += "0101";
    Expression back;
    EXPECT_FALSE(decoded(hostile, back));
}

TEST(GeneratedUnionTest, HasTypesOfItsOwn) {
    Inner inner;
    inner.near_side(Inner::Side::FAR);
    expect_octets(inner, "0001");
    Inner::Again again;
    again.one(Inner::Which::RIGHT);
    inner.more(again);
    expect_octets(inner, "010501");
    expect_in_any(inner);
    EXPECT_EQ(printed(inner), "{_d: RIGHT, more: {_d: 5, one: RIGHT}}");
}

TEST(GeneratedUnionTest, BelongsToAnInterface) {
    Stock::Found found;
    found.now(Stock::start);
    expect_octets(found, "0102");
    found.reason("none");
    expect_in_any(found);
    Stock::Next next;
    EXPECT_TRUE(next.bigger().is_nil());
    next.smaller({});
    expect_octets(next, "0200");
    expect_in_any(next);
}

TEST(GeneratedUnionTest, MayBeNamedAsTheGeneratedCodeNamesThings) {
    Awkward::value value;
    value.flow({1, 2, 3});
    expect_octets(value, "00010203");
    Awkward::Words words;
    words._cxx_template(1);
    expect_octets(words, "0101");
    EXPECT_EQ(printed(words), "{_d: default, template: 1}");
    words._cxx_class({Awkward::number::_cxx_EOF, Awkward::has::_cxx_union, 1, 2});
    expect_octets(words, "0202010102");
    expect_in_any(words);
}

TEST(GeneratedTypeCodeTest, IsAsTheWirePageSays) {
    const auto code = [](std::string_view octets_of_it) {
        return hex(
            {reinterpret_cast<const std::uint8_t*>(octets_of_it.data()), octets_of_it.size()});
    };
    // struct "IDL:Parts/Nothing:1.0", "", no members
    EXPECT_EQ(code(type_code_of(static_cast<const Nothing*>(nullptr))),
              "0F1649444C3A50617274732F4E6F7468696E673A312E30000100"
              "00");
    // union "IDL:Parts/Maybe:1.0", "", boolean, no default, 1 case: TRUE, "", alias of ulong
    EXPECT_EQ(code(type_code_of(static_cast<const Maybe*>(nullptr))),
              "101449444C3A50617274732F4D617962653A312E30000100"
              "08"
              "7F"
              "01"
              "01"
              "0100"
              "151349444C3A50617274732F476561723A312E30000100"
              "05");
    // enum "IDL:Parts/Mode:1.0", "", 2 names
    EXPECT_EQ(code(type_code_of(static_cast<const Mode*>(nullptr))),
              "111349444C3A50617274732F4D6F64653A312E30000100"
              "02"
              "0100"
              "0100");
}

TEST(GeneratedConstantsTest, AreOfEveryType) {
    static_assert(price == Fixed<3, 1>{"12.5"});
    static_assert(sign == u"5 \x20AC");
    static_assert(euro == u'\x20AC');
    static_assert(third == 0.25L);
    static_assert(slowest == Gear::LOW);
    static_assert(Stock::start == Stock::State::LOCKED);
}

}  // namespace
}  // namespace canorb::test
