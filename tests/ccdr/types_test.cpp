// The fixed-size types, strings, and the encoder's and decoder's own rules: doc/wire/ccdr.md.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>

#include "tests/ccdr/codec.hpp"

namespace canorb::test {
namespace {

using std::string_view_literals::operator""sv;

TEST(OneOctet, IsItself) {
    EXPECT_EQ(encoded(std::uint8_t{0xC3}), "C3");
    EXPECT_EQ(decoded<std::uint8_t>("C3"), 0xC3);
    EXPECT_EQ(encoded(std::int8_t{-2}), "FE");
    EXPECT_EQ(decoded<std::int8_t>("FE"), -2);
    EXPECT_EQ(encoded('A'), "41");
    EXPECT_EQ(decoded<char>("41"), 'A');
    EXPECT_FALSE(decoded<std::uint8_t>(""));
    EXPECT_FALSE(decoded<char>("4142"));
}

TEST(Boolean, IsZeroOrOne) {
    EXPECT_EQ(encoded(false), "00");
    EXPECT_EQ(encoded(true), "01");
    EXPECT_EQ(decoded<bool>("00"), false);
    EXPECT_EQ(decoded<bool>("01"), true);
    for (unsigned octet = 2; octet <= 0xFF; ++octet) {
        const std::array octets{static_cast<std::uint8_t>(octet)};
        EXPECT_FALSE(decoded<bool>(Bytes{octets})) << octet;
    }
    EXPECT_FALSE(decoded<bool>(""));
}

TEST(LongLong, HasEightOctets) {
    EXPECT_EQ(encoded(std::uint64_t{0x0102030405060708}), "0102030405060708");
    EXPECT_EQ(decoded<std::uint64_t>("0102030405060708"), 0x0102030405060708U);
    EXPECT_EQ(encoded(std::int64_t{-2}), "FFFFFFFFFFFFFFFE");
    EXPECT_EQ(decoded<std::int64_t>("FFFFFFFFFFFFFFFE"), -2);
    EXPECT_EQ(encoded(std::numeric_limits<std::int64_t>::min()), "8000000000000000");
    EXPECT_EQ(prefixes_accepted<std::int64_t>("8000000000000000"), 0U);
    EXPECT_EQ(prefixes_accepted<std::uint64_t>("0102030405060708"), 0U);
}

TEST(Floating, IsIeee754) {
    EXPECT_EQ(encoded(1.0F), "3F800000");
    EXPECT_EQ(decoded<float>("3F800000"), 1.0F);
    EXPECT_EQ(encoded(-0.0F), "80000000");
    EXPECT_EQ(encoded(std::numeric_limits<float>::infinity()), "7F800000");
    EXPECT_EQ(encoded(-2.5), "C004000000000000");
    EXPECT_EQ(decoded<double>("C004000000000000"), -2.5);
    EXPECT_EQ(prefixes_accepted<float>("3F800000"), 0U);
    EXPECT_EQ(prefixes_accepted<double>("C004000000000000"), 0U);
}

TEST(Floating, NotANumberKeepsItsBits) {
    for (const char* octets : {"7FC00001", "7F800001", "FFFFFFFF"}) {
        const std::optional<float> value = decoded<float>(octets);
        ASSERT_TRUE(value);
        EXPECT_EQ(encoded(*value), octets);
    }
}

TEST(String, IsLengthOctetsNul) {
    EXPECT_EQ(encoded(std::string{}), "0100");
    EXPECT_EQ(decoded<std::string>("0100"), "");
    EXPECT_EQ(encoded(std::string{"A"}), "024100");
    EXPECT_EQ(decoded<std::string>("024100"), "A");
    EXPECT_EQ(encoded(std::string{"\xC3\xA4"}), "03C3A400") << "untranscoded";
    EXPECT_EQ(decoded<std::string>("03C3A400"), "\xC3\xA4");
}

TEST(String, ItsLengthIsAnUnsignedLong) {
    const std::string text(126, 'x');
    const std::string octets = encoded(text);
    EXPECT_EQ(octets.substr(0, 4), "7F78") << "127 with the NUL";
    EXPECT_EQ(encoded(text + 'x').substr(0, 6), "808078") << "128 with the NUL";
    EXPECT_EQ(decoded<std::string>(encoded(text + 'x')), text + 'x');
}

TEST(String, AnInnerNulIsABadValue) {
    using namespace std::string_literals;
    EXPECT_EQ(encoded("a\0b"s), "bad_value");
    EXPECT_EQ(encoded("\0"s), "bad_value");
}

TEST(String, MalformedFormsAreRefused) {
    EXPECT_FALSE(decoded<std::string>("")) << "no length";
    EXPECT_FALSE(decoded<std::string>("00")) << "length 0";
    EXPECT_FALSE(decoded<std::string>("0000")) << "length 0";
    EXPECT_FALSE(decoded<std::string>("0141")) << "no NUL";
    EXPECT_FALSE(decoded<std::string>("024142")) << "no NUL";
    EXPECT_FALSE(decoded<std::string>("03410000")) << "inner NUL";
    EXPECT_FALSE(decoded<std::string>("03004100")) << "inner NUL";
    EXPECT_FALSE(decoded<std::string>("80024100")) << "length not in its shortest form";
    EXPECT_FALSE(decoded<std::string>("02410000")) << "left over";
    EXPECT_EQ(prefixes_accepted<std::string>("0541424344 00"), 0U);
}

TEST(String, LengthsThatLieAreRefused) {
    for (const char* octets : {"034100", "7F4100", "80804100", "BFFF4100", "DFFFFF4100",
                               "EFFFFFFF4100", "F07FFFFFFF4100", "F0FFFFFFFF4100", "F0FFFFFFFF"}) {
        EXPECT_FALSE(decoded<std::string>(octets)) << octets;
    }
}

// void SetAttributeValueUL(in string attrName, in unsigned long idxVal, in unsigned long attrValue)
constexpr std::string_view set_attribute_value_parameters =
    "11"                                // string length, 16 and the NUL
    "6D61785F616363656C65726174696F6E"  // max_acceleration
    "00"
    "03"   // idxVal
    "2A";  // attrValue

TEST(Parameters, OfTheSizeVectorAreTwentyOctets) {
    std::array<std::uint8_t, 64> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, "max_acceleration"sv);
    encode(out, std::uint32_t{3});
    encode(out, std::uint32_t{42});
    ASSERT_EQ(out.error(), ccdr::EncodeError::none);
    EXPECT_EQ(out.size(), 20U);
    EXPECT_EQ(hex(out.octets()), set_attribute_value_parameters);
}

TEST(Parameters, OfTheSizeVectorAreRead) {
    const auto golden = octets(set_attribute_value_parameters);
    ccdr::Decoder in{golden};
    std::string name;
    std::uint32_t index{};
    std::uint32_t value{};
    decode(in, name);
    decode(in, index);
    decode(in, value);
    EXPECT_TRUE(in.finished());
    EXPECT_EQ(name, "max_acceleration");
    EXPECT_EQ(index, 3U);
    EXPECT_EQ(value, 42U);
}

TEST(Encoder, ABufferThatIsTooSmallIsSaidAndNotOverrun) {
    for (std::size_t size = 0; size < 20; ++size) {
        std::vector<std::uint8_t> buffer(size);
        ccdr::Encoder out{buffer};
        encode(out, "max_acceleration"sv);
        encode(out, std::uint32_t{3});
        encode(out, std::uint32_t{42});
        EXPECT_EQ(out.error(), ccdr::EncodeError::buffer_full) << size;
        EXPECT_LE(out.size(), size);
    }
}

TEST(Encoder, TheFirstErrorSticks) {
    std::array<std::uint8_t, 2> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, std::uint8_t{1});
    out.fail();
    encode(out, std::uint64_t{1});
    encode(out, std::uint8_t{2});
    EXPECT_EQ(out.error(), ccdr::EncodeError::bad_value);
    EXPECT_EQ(hex(out.octets()), "01");
}

TEST(Decoder, AfterAnErrorEverythingIsZeroAndEmpty) {
    const auto golden = octets("02 2A 2A 024100");
    ccdr::Decoder in{golden};
    bool flag = true;
    decode(in, flag);
    EXPECT_FALSE(in.ok());
    EXPECT_FALSE(flag);
    std::uint32_t number = 7;
    std::int64_t long_number = 7;
    std::string text = "seven";
    decode(in, number);
    decode(in, long_number);
    decode(in, text);
    EXPECT_EQ(number, 0U);
    EXPECT_EQ(long_number, 0);
    EXPECT_EQ(text, "");
    EXPECT_EQ(in.remaining(), 0U);
    EXPECT_FALSE(in.finished());
}

TEST(Decoder, CarriesTheContextThatItWasGiven) {
    struct Orb final : ccdr::DecodeContext {};
    const Orb orb;
    EXPECT_EQ(ccdr::Decoder({}, &orb).context(), &orb);
    EXPECT_EQ(ccdr::Decoder(Bytes{}).context(), nullptr);
}

}  // namespace
}  // namespace canorb::test
