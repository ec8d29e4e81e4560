// canorb::Any: doc/wire/ccdr.md, "Type codes".
#include "orb/ccdr/any.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "orb/ccdr/map.hpp"
#include "orb/ccdr/nesting.hpp"
#include "tests/ccdr/codec.hpp"

namespace canorb::test {
namespace {

/// As generated for struct Status { unsigned short speed; string name; };
struct Status {
    std::uint16_t speed{};
    std::string name;
    friend bool operator==(const Status&, const Status&) = default;
};
void encode(ccdr::Encoder& out, const Status& value) {
    encode(out, value.speed);
    encode(out, value.name);
}
void decode(ccdr::Decoder& in, Status& value) {
    decode(in, value.speed);
    decode(in, value.name);
}
constexpr std::string_view type_code_of(const Status*) {
    return {"\x0F\x0AIDL:S:1.0\0\x01\0\x02\x01\0\x04\x01\0\x12\0", 22};
}
constexpr std::string_view status_code =
    "0F 0A49444C3A533A312E3000 0100 02"
    "0100 04"
    "0100 12 00";

template <typename T>
std::string encoded_any(const T& value) {
    Any any;
    any <<= value;
    return encoded(any);
}

/// The T in an any of these octets.
template <typename T>
std::optional<T> taken(std::string_view hex) {
    const auto any = decoded<Any>(hex);
    T value{};
    if (!any || !(*any >>= value)) return std::nullopt;
    return value;
}

TEST(Any, IsATypeCodeAndAValue) {
    EXPECT_EQ(encoded(Any{}), "00");
    EXPECT_EQ(encoded_any(true), "0801");
    EXPECT_EQ(encoded_any('A'), "0941");
    EXPECT_EQ(encoded_any(u'A'), "1A0041");
    EXPECT_EQ(encoded_any(std::uint8_t{255}), "0AFF");
    EXPECT_EQ(encoded_any(std::int8_t{-2}), "0AFE");
    EXPECT_EQ(encoded_any(std::int16_t{-1}), "027F");
    EXPECT_EQ(encoded_any(std::uint16_t{128}), "048080");
    EXPECT_EQ(encoded_any(std::int32_t{42}), "032A");
    EXPECT_EQ(encoded_any(std::uint32_t{42}), "052A");
    EXPECT_EQ(encoded_any(std::int64_t{1}), "170000000000000001");
    EXPECT_EQ(encoded_any(std::uint64_t{1}), "180000000000000001");
    EXPECT_EQ(encoded_any(1.0F), "063F800000");
    EXPECT_EQ(encoded_any(-2.5), "07C004000000000000");
    EXPECT_EQ(encoded_any(1.0L), "193FFF0000000000000000000000000000");
    EXPECT_EQ(encoded_any("A"), "1200024100");
    EXPECT_EQ(encoded_any(std::string{"A"}), "1200024100");
    EXPECT_EQ(encoded_any(BoundedString<5>{"A"}), "1205024100");
    EXPECT_EQ(encoded_any(std::u16string{u"A"}), "1B000200410000");
    EXPECT_EQ((encoded_any(Fixed<5, 2>{"123.45"})), "1C050212345C");
    EXPECT_EQ(encoded_any(std::vector<std::uint16_t>{1, 128}),
              "130400"
              "02018080");
    EXPECT_EQ((encoded_any(BoundedVector<bool, 3>{true})),
              "130803"
              "0101");
    EXPECT_EQ((encoded_any(std::array<std::uint8_t, 2>{1, 2})),
              "140A02"
              "0102");
    EXPECT_EQ((encoded_any(std::map<std::string, std::int32_t>{{"A", 42}})),
              hex(octets("13 0F 0100 0100 02 0100 1200 0100 03 00"
                         "01 024100 2A")));
    EXPECT_EQ(encoded_any(Status{.speed = 3, .name = "A"}),
              hex(octets(std::string{status_code} + "03 024100")));
    EXPECT_EQ(encoded_any(type_code<bool>()), "0C08");
    Any inner;
    inner <<= true;
    EXPECT_EQ(encoded_any(inner), "0B0801");
}

TEST(Any, GivesBackWhatItHolds) {
    EXPECT_EQ(taken<bool>("0801"), true);
    EXPECT_EQ(taken<std::int32_t>("032A"), 42);
    EXPECT_EQ(taken<std::string>("1200024100"), "A");
    EXPECT_EQ(taken<std::string>("1205024100"), "A") << "the bound does not matter";
    EXPECT_EQ(taken<BoundedString<5>>("1205024100"), "A");
    EXPECT_EQ((taken<Fixed<5, 2>>("1C050212345C")), (Fixed<5, 2>{"123.45"}));
    EXPECT_EQ(taken<Status>(std::string{status_code} + "03 024100"),
              (Status{.speed = 3, .name = "A"}));
    EXPECT_EQ(taken<Any>("0B 0801")->type().kind(), TCKind::tk_boolean);
    EXPECT_EQ(taken<TypeCode>("0C 08"), type_code<bool>());
    EXPECT_EQ(taken<bool>("15 024100 0100 08 01"), true) << "an alias";
}

TEST(Any, GivesNothingElse) {
    EXPECT_FALSE(taken<std::int32_t>("052A"));
    EXPECT_FALSE(taken<bool>("00"));
    EXPECT_FALSE(taken<BoundedString<4>>("1205024100"));
    EXPECT_FALSE(taken<Status>("032A"));
    Any any;
    any <<= 1.0;
    Status status{.speed = 7, .name = "seven"};
    EXPECT_FALSE(any >>= status);
    EXPECT_EQ(status, (Status{.speed = 7, .name = "seven"})) << "untouched";
}

TEST(Any, OfATypeThatNobodyKnowsIsPassedOn) {
    constexpr auto golden =
        "0F 0100 0100 02 0100 0B 0100 13 1A 00"
        "03 2A 01 0041";
    const auto any = decoded<Any>(golden);
    ASSERT_TRUE(any);
    EXPECT_EQ(encoded(*any), hex(octets(golden)));
    EXPECT_EQ(hex(any->value()), "032A010041");
    EXPECT_EQ(any->type().kind(), TCKind::tk_struct);
    EXPECT_EQ(prefixes_accepted<Any>(golden), 0U);
    EXPECT_EQ(forgeries_changed<Any>(golden), 0U);
}

TEST(Any, IsEqualOctetByOctet) {
    Any a;
    Any b;
    EXPECT_EQ(a, b);
    a <<= std::int32_t{1};
    EXPECT_NE(a, b);
    b <<= std::int32_t{1};
    EXPECT_EQ(a, b);
    b <<= std::uint32_t{1};
    EXPECT_NE(a, b);
    b <<= std::int32_t{2};
    EXPECT_NE(a, b);
}

TEST(Any, MalformedFormsAreRefused) {
    for (const char* octets : {"", "0D", "03", "0802", "0300 00", "120002 4142", "13 03 F0FFFFFFFF",
                               "13 13 13", "0B", "0B0B", "1C05021234"}) {
        EXPECT_FALSE(decoded<Any>(octets)) << octets;
    }
}

TEST(Any, OfWhatCannotBeSentCannotBeSent) {
    EXPECT_EQ(encoded_any(BoundedString<2>{"ABC"}), "bad_value");
    EXPECT_EQ((encoded_any(Fixed<1, 0>{10})), "bad_value");
    EXPECT_EQ(encoded_any(std::string(70'000, 'x')), "bad_value");
    Any any;
    any <<= BoundedString<2>{"ABC"};
    EXPECT_NE(any, Any{});
    any <<= true;
    EXPECT_EQ(encoded(any), "0801") << "a new value";
}

TEST(Any, HoldsAsMuchAsAMessage) {
    const std::string text(65'000, 'x');
    Any any;
    any <<= text;
    std::string back;
    ASSERT_TRUE(any >>= back);
    EXPECT_EQ(back, text);
}

std::string nested(std::size_t levels) {
    std::string octets;
    for (std::size_t i = 1; i < levels; ++i) octets += "0B";
    return octets + "0801";
}

TEST(Any, WithinAnyIsLimitedTo64Levels) {
    EXPECT_TRUE(decoded<Any>(nested(64)));
    EXPECT_FALSE(decoded<Any>(nested(65)));
    EXPECT_FALSE(decoded<Any>(Bytes{std::vector<std::uint8_t>(65538, 0x0B)}));

    Any any;
    any <<= true;
    for (int level = 1; level < 64; ++level) {
        Any around;
        around <<= any;
        any = around;
    }
    EXPECT_EQ(encoded(any), nested(64));
    Any around;
    around <<= any;
    EXPECT_EQ(encoded(around), "bad_value");
}

TEST(Any, InAnyWithinOtherLevelsIsLimitedToo) {
    // Sent as its receiver counts: the levels around the any and those in it.
    const Any any = *decoded<Any>(nested(64));
    std::vector<std::uint8_t> buffer(100);
    ccdr::Encoder out{buffer};
    {
        const ccdr::Nesting nesting{out};
        encode(out, any);
    }
    EXPECT_EQ(out.error(), ccdr::EncodeError::bad_value);
}

TEST(Any, MayBePutIntoItself) {
    Any any;
    any <<= true;
    any <<= any;
    EXPECT_EQ(encoded(any), "0B0801");
}

TEST(Any, KeepsTheContextOfItsReferences) {
    struct Context final : ccdr::DecodeContext, std::enable_shared_from_this<Context> {
        std::shared_ptr<const DecodeContext> shared() const override { return shared_from_this(); }
    };
    auto context = std::make_shared<Context>();
    const std::weak_ptr<Context> watched = context;
    const auto golden = octets("0801");
    ccdr::Decoder in{golden, context.get()};
    Any any;
    decode(in, any);
    EXPECT_EQ(any.context(), context.get());
    context.reset();
    EXPECT_FALSE(watched.expired()) << "it may be needed when the value is taken";
    any <<= any;
    EXPECT_FALSE(watched.expired()) << "still, though deeper inside";
    any <<= true;
    EXPECT_TRUE(watched.expired());
}

TEST(Any, MayHoldAnyInSequencesAndMaps) {
    std::map<std::string, std::vector<Any>> properties;
    properties["A"].resize(2);
    properties["A"][0] <<= true;
    EXPECT_EQ(encoded(properties), "0102410002080100");
    EXPECT_EQ((decoded<std::map<std::string, std::vector<Any>>>("0102410002080100")), properties);
}

}  // namespace
}  // namespace canorb::test
