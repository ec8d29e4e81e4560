// long double, wide characters, maps, bitmasks, what takes no octets, and nesting:
// doc/wire/ccdr.md.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "orb/ccdr/binary128.hpp"
#include "orb/ccdr/bitmask.hpp"
#include "orb/ccdr/map.hpp"
#include "orb/ccdr/nesting.hpp"
#include "tests/ccdr/codec.hpp"

namespace canorb::test {

enum class Alarms : std::uint16_t { hot = 1 << 0, stalled = 1 << 1, last = 1 << 11 };
BitmaskBits<12> bitmask_bits(const Alarms*);

enum class Few : std::uint8_t { first = 1 };
BitmaskBits<8> bitmask_bits(const Few*);

enum class Many : std::uint32_t { first = 1 };
BitmaskBits<17> bitmask_bits(const Many*);

enum class All : std::uint64_t { last = std::uint64_t{1} << 63 };
BitmaskBits<64> bitmask_bits(const All*);

using canorb::operator|, canorb::operator&, canorb::operator^, canorb::operator~,
    canorb::operator|=, canorb::operator&=, canorb::operator^=, canorb::has;

/// As generated for a struct without members.
struct Empty {
    using _takes_no_octets = void;
    friend bool operator==(const Empty&, const Empty&) = default;
};
inline void encode(ccdr::Encoder&, const Empty&) {}
inline void decode(ccdr::Decoder&, Empty&) {}

/// As generated for a recursive struct.
struct Tree {
    std::int32_t value{};
    std::vector<Tree> children;
};

inline void encode(ccdr::Encoder& out, const Tree& value) {
    const ccdr::Nesting nesting{out};
    if (!nesting) return;
    encode(out, value.value);
    encode(out, value.children);
}

inline void decode(ccdr::Decoder& in, Tree& value) {
    const ccdr::Nesting nesting{in};
    if (!nesting) return;
    decode(in, value.value);
    decode(in, value.children);
}

namespace {

using ccdr::Binary128;
using ccdr::bounded;
using ccdr::from_binary128;
using ccdr::to_binary128;

/// A value with its bounds, for encoded().
template <std::size_t... Bounds, typename T>
std::string encoded_with_bounds(const T& value) {
    return encoded(bounded<Bounds...>(value));
}

template <typename T, std::size_t... Bounds>
std::optional<T> decoded_with_bounds(std::string_view hex) {
    const auto all = octets(hex);
    ccdr::Decoder in{all};
    T value{};
    decode(in, bounded<Bounds...>(value));
    if (!in.finished()) return std::nullopt;
    return value;
}

TEST(LongDouble, IsBinary128) {
    struct {
        long double value;
        const char* octets;
    } const cases[] = {
        {0.0L, "00000000000000000000000000000000"},
        {-0.0L, "80000000000000000000000000000000"},
        {1.0L, "3FFF0000000000000000000000000000"},
        {-2.5L, "C0004000000000000000000000000000"},
        {std::numeric_limits<long double>::infinity(), "7FFF0000000000000000000000000000"},
        {-std::numeric_limits<long double>::infinity(), "FFFF0000000000000000000000000000"},
        {std::numeric_limits<double>::max(), "43FEFFFFFFFFFFFFF000000000000000"},
        {std::numeric_limits<double>::denorm_min(), "3BCD0000000000000000000000000000"},
    };
    for (const auto& [value, octets] : cases) {
        EXPECT_EQ(encoded(value), octets);
        const auto back = decoded<long double>(octets);
        ASSERT_TRUE(back) << octets;
        EXPECT_EQ(*back, value) << octets;
        EXPECT_EQ(std::signbit(*back), std::signbit(value)) << octets;
        EXPECT_EQ(prefixes_accepted<long double>(octets), 0U);
    }
}

TEST(LongDouble, NotANumberStaysOne) {
    EXPECT_EQ(encoded(std::numeric_limits<long double>::quiet_NaN()),
              "7FFF8000000000000000000000000000");
    const auto value = decoded<long double>("FFFF0000000000000000000000000001");
    ASSERT_TRUE(value);
    EXPECT_TRUE(std::isnan(*value));
    EXPECT_TRUE(std::signbit(*value));
}

TEST(LongDouble, SmallerTypesOfAHostAreExact) {
    EXPECT_EQ(to_binary128(0.1), (Binary128{0x3FFB999999999999, 0xA000000000000000}));
    EXPECT_EQ(to_binary128(0.1F), (Binary128{0x3FFB99999A000000, 0}));
    EXPECT_EQ(from_binary128<double>({0x3FFB999999999999, 0xA000000000000000}), 0.1);
    EXPECT_EQ(from_binary128<float>({0x3FFB99999A000000, 0}), 0.1F);
}

TEST(LongDouble, IsRoundedOnceToWhatTheHostHas) {
    constexpr double epsilon = std::numeric_limits<double>::epsilon();
    const auto one_and = [](std::uint64_t low) {
        return from_binary128<double>({0x3FFF000000000000, low});
    };
    EXPECT_EQ(one_and(0x0800000000000000), 1.0) << "half way: to even, down";
    EXPECT_EQ(one_and(0x0800000000000001), 1.0 + epsilon) << "just above half way";
    EXPECT_EQ(one_and(0x07FFFFFFFFFFFFFF), 1.0) << "just below half way";
    EXPECT_EQ(one_and(0x1800000000000000), 1.0 + 2 * epsilon) << "half way: to even, up";
    EXPECT_EQ(from_binary128<double>({0x3FFFFFFFFFFFFFFF, 0xFFFFFFFFFFFFFFFF}), 2.0);

    constexpr double smallest = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(from_binary128<double>({0x3BCC000000000000, 0}), 0.0) << "half the smallest: to even";
    EXPECT_EQ(from_binary128<double>({0x3BCC000000000000, 1}), smallest);
    EXPECT_EQ(from_binary128<double>({0x3BCD800000000000, 0}), 2 * smallest) << "1.5: to even";
    EXPECT_EQ(from_binary128<double>({0, 1}), 0.0) << "binary128's smallest";
    EXPECT_TRUE(std::signbit(from_binary128<double>({0x8000000000000000, 1})));
    EXPECT_EQ(from_binary128<double>({0x7FFEFFFFFFFFFFFF, 0xFFFFFFFFFFFFFFFF}),
              std::numeric_limits<double>::infinity());
    EXPECT_EQ(from_binary128<float>({0x407FFFFFFF000000, 0}),
              std::numeric_limits<float>::infinity());
}

TEST(LongDouble, EveryValueOfTheHostComesBack) {
    using Limits = std::numeric_limits<long double>;
    for (const long double value :
         {Limits::max(), Limits::min(), Limits::denorm_min(), Limits::lowest(),
          1 + Limits::epsilon(), 3 * Limits::denorm_min(), Limits::min() - Limits::denorm_min(),
          0.1L}) {
        EXPECT_EQ(from_binary128<long double>(to_binary128(value)), value);
    }
}

TEST(WideCharacter, IsACodeUnit) {
    EXPECT_EQ(encoded(u'A'), "0041");
    EXPECT_EQ(encoded(u'\xFFFF'), "FFFF");
    EXPECT_EQ(encoded(u'\0'), "0000");
    EXPECT_EQ(decoded<char16_t>("20AC"), u'\u20AC');
    EXPECT_EQ(prefixes_accepted<char16_t>("0041"), 0U);
    EXPECT_EQ(encoded(std::vector{u'A', u'B'}), "0200410042");
    EXPECT_FALSE(decoded<std::vector<char16_t>>("03 0041 0042"));
}

TEST(WideString, IsLengthUnitsZero) {
    struct {
        std::u16string value;
        const char* octets;
    } const cases[] = {
        {u"", "010000"},
        {u"A", "0200410000"},
        {u"\u00E4", "0200E40000"},
        {u"\U0001F600", "03D83DDE000000"},
        {std::u16string(1, char16_t{0xD800}), "02D8000000"},
    };
    for (const auto& [value, octets] : cases) {
        EXPECT_EQ(encoded(value), octets);
        EXPECT_EQ(decoded<std::u16string>(octets), value) << octets;
        EXPECT_EQ(prefixes_accepted<std::u16string>(octets), 0U);
        EXPECT_EQ(forgeries_changed<std::u16string>(octets), 0U);
    }
}

TEST(WideString, AnInnerZeroIsABadValue) {
    EXPECT_EQ(encoded(std::u16string(1, u'\0')), "bad_value");
    EXPECT_EQ(encoded(std::u16string{u'A', u'\0', u'B'}), "bad_value");
}

TEST(WideString, MalformedFormsAreRefused) {
    EXPECT_FALSE(decoded<std::u16string>("00")) << "length 0";
    EXPECT_FALSE(decoded<std::u16string>("010041")) << "no final 0";
    EXPECT_FALSE(decoded<std::u16string>("0300410000 0000")) << "an inner 0";
    EXPECT_FALSE(decoded<std::u16string>("0200410000 00")) << "left over";
    EXPECT_FALSE(decoded<std::u16string>("F0FFFFFFFF 00410000")) << "a length that lies";
    EXPECT_FALSE(decoded<std::u16string>("F080000001 0000")) << "twice its length is 2";
}

TEST(WideString, HasItsBoundEverywhere) {
    const std::u16string two = u"AB";
    EXPECT_EQ(encoded_with_bounds<2>(two), "03004100420000");
    EXPECT_EQ(encoded_with_bounds<1>(two), "bad_value");
    EXPECT_EQ((decoded_with_bounds<std::u16string, 2>("03004100420000")), two);
    EXPECT_FALSE((decoded_with_bounds<std::u16string, 1>("03004100420000")));
    using Texts = std::vector<std::array<std::u16string, 1>>;
    EXPECT_EQ((encoded_with_bounds<1, 2>(Texts{{two}})), "0103004100420000");
    EXPECT_EQ((encoded_with_bounds<1, 1>(Texts{{two}})), "bad_value");
    EXPECT_EQ((decoded_with_bounds<Texts, 1, 2>("0103004100420000")), (Texts{{two}}));
    EXPECT_FALSE((decoded_with_bounds<Texts, 1, 1>("0103004100420000")));
}

using Names = std::map<std::int32_t, std::string>;

TEST(Map, IsASequenceOfKeyAndValue) {
    const Names names{{-1, "A"}, {2, ""}};
    constexpr auto golden = "02 7F024100 020100";
    EXPECT_EQ(encoded(names), hex(octets(golden)));
    EXPECT_EQ(decoded<Names>(golden), names);
    EXPECT_EQ(decoded<Names>("02 020100 7F024100"), names) << "in any order";
    EXPECT_EQ(decoded<Names>("00"), Names{});
    EXPECT_EQ(prefixes_accepted<Names>(golden), 0U);
}

TEST(Map, MalformedFormsAreRefused) {
    EXPECT_FALSE(decoded<Names>("02 7F024100 7F0100")) << "a key twice";
    EXPECT_FALSE(decoded<Names>("02 7F0100 7F0100")) << "an entry twice";
    EXPECT_FALSE(decoded<Names>("F0FFFFFFFF 7F0100")) << "a count that lies";
    EXPECT_FALSE(decoded<Names>("02 7F024100")) << "an entry too few";
    EXPECT_FALSE(decoded<Names>("00 00")) << "left over";
}

TEST(Map, HasBoundsForItselfItsKeysAndItsValues) {
    const Names two{{1, "A"}, {2, "BC"}};
    constexpr auto golden = "0201024100020342430 0";
    EXPECT_EQ((encoded_with_bounds<2>(two)), hex(octets(golden)));
    EXPECT_EQ((encoded_with_bounds<1>(two)), "bad_value");
    EXPECT_EQ((encoded_with_bounds<0, 2>(two)), hex(octets(golden)));
    EXPECT_EQ((encoded_with_bounds<0, 1>(two)), "bad_value");
    EXPECT_EQ((decoded_with_bounds<Names, 2, 2>(golden)), two);
    EXPECT_FALSE((decoded_with_bounds<Names, 1, 2>(golden)));
    EXPECT_FALSE((decoded_with_bounds<Names, 2, 1>(golden)));

    using Wide = std::map<std::string, std::vector<std::u16string>>;
    const Wide wide{{"AB", {u"C"}}};
    constexpr auto wide_golden = "01 03414200 01 0200430000";
    EXPECT_EQ((encoded_with_bounds<1, 2, 1, 1>(wide)), hex(octets(wide_golden)));
    EXPECT_EQ((encoded_with_bounds<1, 2>(wide)), hex(octets(wide_golden)));
    EXPECT_EQ((encoded_with_bounds<1, 1, 1, 1>(wide)), "bad_value") << "the key";
    EXPECT_EQ((decoded_with_bounds<Wide, 0, 2, 1, 1>(wide_golden)), wide);
    EXPECT_EQ((decoded_with_bounds<Wide, 0, 2>(wide_golden)), wide);
    EXPECT_FALSE((decoded_with_bounds<Wide, 0, 1>(wide_golden))) << "the key";
    EXPECT_FALSE((decoded_with_bounds<Wide, 0, 2, 1, 1>("01 03414200 01 03004300440000")));
    EXPECT_FALSE((decoded_with_bounds<Wide, 0, 2, 1>("01 03414200 02 010000010000")));
}

TEST(Map, TakesAllKindsOfKeys) {
    EXPECT_EQ(encoded(std::map<bool, std::uint8_t>{{true, 1}}), "010101");
    EXPECT_EQ(encoded(std::map<char16_t, bool>{{u'A', true}}), "01004101");
    EXPECT_EQ(encoded(std::map<Alarms, bool>{{Alarms::hot, true}}), "010101");
    EXPECT_EQ(encoded(std::map<BoundedString<4>, bool>{{"A", true}}), "0102410001");
    EXPECT_EQ((decoded<std::map<BoundedString<4>, bool>>("0102410001")),
              (std::map<BoundedString<4>, bool>{{"A", true}}));
}

TEST(Bitmask, IsTheSmallestUnsignedTypeThatHoldsIt) {
    EXPECT_EQ(encoded(Alarms{}), "00");
    EXPECT_EQ(encoded(Alarms::hot | Alarms::stalled), "03");
    EXPECT_EQ(encoded(Alarms::last), "8800");
    EXPECT_EQ(encoded(static_cast<Few>(0x80)), "80") << "an octet";
    EXPECT_EQ(encoded(static_cast<Many>(0x10000)), "C10000") << "an unsigned long";
    EXPECT_EQ(encoded(All::last), "8000000000000000");
    EXPECT_EQ(decoded<Alarms>("8FFF"), static_cast<Alarms>(0xFFF)) << "flags without a name";
    EXPECT_EQ(decoded<Few>("FF"), static_cast<Few>(0xFF));
    EXPECT_EQ(decoded<All>("8000000000000001"), static_cast<All>(0x8000000000000001));
    EXPECT_EQ(forgeries_changed<Alarms>("8FFF"), 0U);
    EXPECT_EQ(prefixes_accepted<Alarms>("8FFF"), 0U);
}

TEST(Bitmask, BitsBeyondItsBoundAreRefused) {
    EXPECT_EQ(encoded(static_cast<Alarms>(0x1000)), "bad_value");
    EXPECT_FALSE(decoded<Alarms>("9000"));
    EXPECT_FALSE(decoded<Many>("C20000"));
    EXPECT_EQ(decoded<Many>("C1FFFF"), static_cast<Many>(0x1FFFF));
}

TEST(Bitmask, HasTheOperatorsOfASet) {
    Alarms alarms = Alarms::hot;
    alarms |= Alarms::last;
    EXPECT_TRUE(has(alarms, Alarms::last));
    EXPECT_FALSE(has(alarms, Alarms::hot | Alarms::stalled));
    alarms &= ~Alarms::hot;
    EXPECT_EQ(alarms, Alarms::last);
    alarms ^= Alarms::last;
    EXPECT_EQ(alarms, Alarms{});
    EXPECT_EQ(~alarms, static_cast<Alarms>(0xFFF));
    EXPECT_EQ(~Few{}, static_cast<Few>(0xFF));
    EXPECT_EQ(~All{}, static_cast<All>(~std::uint64_t{0}));
    static_assert((Alarms::hot | Alarms::stalled) == static_cast<Alarms>(3));
}

TEST(Octetless, ElementsAreCountedAndNothingElse) {
    EXPECT_EQ(encoded(std::vector<Empty>(3)), "03");
    EXPECT_EQ(decoded<std::vector<Empty>>("03"), std::vector<Empty>(3));
    EXPECT_EQ(decoded<std::vector<Empty>>("00"), std::vector<Empty>{});
    EXPECT_EQ((decoded<BoundedVector<Empty, 4>>("04")), (BoundedVector<Empty, 4>{{}, {}, {}, {}}));
    EXPECT_FALSE((decoded<BoundedVector<Empty, 4>>("05")));
    EXPECT_FALSE((decoded_with_bounds<std::vector<Empty>, 4>("05")));
    using Pairs = std::vector<std::array<Empty, 2>>;
    EXPECT_EQ(encoded(Pairs(2)), "02");
    EXPECT_EQ(decoded<Pairs>("02"), Pairs(2));
    using ByNumber = std::map<std::uint8_t, Empty>;
    EXPECT_EQ(decoded<ByNumber>("02 01 02"), (ByNumber{{1, {}}, {2, {}}}));
}

TEST(Octetless, ElementsAreLimitedForAWholeMessage) {
    EXPECT_EQ(decoded<std::vector<Empty>>("C10002")->size(), 65538U);
    EXPECT_FALSE(decoded<std::vector<Empty>>("C10003"));
    EXPECT_FALSE(decoded<std::vector<Empty>>("F0FFFFFFFF"));
    EXPECT_EQ(encoded(std::vector<Empty>(65538)), "C10002");
    EXPECT_EQ(encoded(std::vector<Empty>(65539)), "bad_value");
    // Two octets for each 16383 elements would otherwise be gigabytes for a message.
    using Lists = std::vector<std::vector<Empty>>;
    EXPECT_TRUE(decoded<Lists>("04 BFFF BFFF BFFF BFFF"));
    EXPECT_TRUE(decoded<Lists>("05 BFFF BFFF BFFF BFFF 06"));
    EXPECT_FALSE(decoded<Lists>("05 BFFF BFFF BFFF BFFF 07"));
    EXPECT_EQ(encoded(Lists(5, std::vector<Empty>(16383))), "bad_value");
}

std::string chain(std::size_t levels) {
    std::string octets;
    for (std::size_t i = 1; i < levels; ++i) octets += "2A01";
    return octets + "2A00";
}

TEST(Nesting, IsLimitedTo64Levels) {
    Tree tree{.value = 42, .children = {}};
    for (int level = 1; level < 64; ++level) {
        Tree above{.value = 42, .children = {}};
        above.children.push_back(std::move(tree));
        tree = std::move(above);
    }
    EXPECT_EQ(encoded(tree), chain(64));
    const auto read = decoded<Tree>(chain(64));
    ASSERT_TRUE(read);
    EXPECT_EQ(encoded(*read), chain(64));
    EXPECT_FALSE(decoded<Tree>(chain(65)));

    Tree above{.value = 42, .children = {}};
    above.children.push_back(std::move(tree));
    EXPECT_EQ(encoded(above), "bad_value");
}

TEST(Nesting, ElementsBesideEachOtherAreOneLevel) {
    std::string flat = "2ABFFF";  // 16383 children
    for (int i = 0; i < 16383; ++i) flat += "0100";
    const auto read = decoded<Tree>(flat);
    ASSERT_TRUE(read);
    EXPECT_EQ(encoded(*read), flat);
}

TEST(Nesting, AMessageOfCountsDoesNotOverflowTheStack) {
    // Each octet: value 1, one child.
    EXPECT_FALSE(decoded<Tree>(Bytes{std::vector<std::uint8_t>(65538, 1)}));
}

}  // namespace
}  // namespace canorb::test
