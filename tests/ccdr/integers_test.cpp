// The variable integers: doc/wire/ccdr.md, "Integers". All octets are from that page.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>

#include "tests/ccdr/codec.hpp"

namespace canorb::test {
namespace {

using std::int16_t;
using std::int32_t;
using std::uint16_t;
using std::uint32_t;

template <typename T>
struct Vector {
    T value;
    std::string_view octets;
};

constexpr Vector<uint32_t> unsigned_vectors[] = {
    {0, "00"},
    {1, "01"},
    {43, "2B"},
    {118, "76"},
    {127, "7F"},
    {128, "8080"},
    {234, "80EA"},
    {16383, "BFFF"},
    {16384, "C04000"},
    {65535, "C0FFFF"},
    {2097151, "DFFFFF"},
    {2097152, "E0200000"},
    {268435455, "EFFFFFFF"},
    {268435456, "F010000000"},
    {4294967295, "F0FFFFFFFF"},
};

constexpr Vector<int32_t> signed_vectors[] = {
    {0, "00"},
    {-1, "7F"},
    {63, "3F"},
    {-64, "40"},
    {64, "8040"},
    {-65, "BFBF"},
    {8191, "9FFF"},
    {-8192, "A000"},
    {8192, "C02000"},
    {-8193, "DFDFFF"},
    {1048575, "CFFFFF"},
    {-1048576, "D00000"},
    {1048576, "E0100000"},
    {-1048577, "EFEFFFFF"},
    {134217727, "E7FFFFFF"},
    {-134217728, "E8000000"},
    {134217728, "F008000000"},
    {-134217729, "F0F7FFFFFF"},
    {2147483647, "F07FFFFFFF"},
    {std::numeric_limits<int32_t>::min(), "F080000000"},
};

TEST(UnsignedLong, IsWrittenInTheShortestForm) {
    for (const auto& [value, octets] : unsigned_vectors) {
        EXPECT_EQ(encoded(value), octets) << value;
    }
}

TEST(UnsignedLong, IsReadFromTheShortestForm) {
    for (const auto& [value, octets] : unsigned_vectors) {
        EXPECT_EQ(decoded<uint32_t>(octets), value) << octets;
    }
}

TEST(UnsignedLong, EveryPrefixIsRefused) {
    for (const auto& [value, octets] : unsigned_vectors) {
        EXPECT_EQ(prefixes_accepted<uint32_t>(octets), 0U) << octets;
    }
}

TEST(UnsignedLong, ALongerFormThanNeededIsRefused) {
    for (const char* octets : {"8000", "8001", "807F",                  // fits 1
                               "C00000", "C0007F", "C00080", "C03FFF",  // fits 1, 2
                               "E0000000", "E0004000", "E01FFFFF",      // fits 1, 3
                               "F000000000", "F000200000", "F00FFFFFFF"}) {
        EXPECT_FALSE(decoded<uint32_t>(octets)) << octets;
    }
}

TEST(UnsignedLong, LeadingBitsThatNoFormHasAreRefused) {
    for (const char* octets :
         {"F180000000", "F280000000", "F480000000", "F780000000",  // 11110 and a low bit
          "F880000000", "F980000000", "FC80000000", "FE80000000", "FFFFFFFFFF"}) {
        EXPECT_FALSE(decoded<uint32_t>(octets)) << octets;
        EXPECT_FALSE(decoded<int32_t>(octets)) << octets;
        EXPECT_FALSE(decoded<uint16_t>(octets)) << octets;
        EXPECT_FALSE(decoded<int16_t>(octets)) << octets;
    }
}

TEST(UnsignedShort, IsAnUnsignedLongOfItsRange) {
    for (const auto& [value, octets] : unsigned_vectors) {
        if (value <= 65535) {
            EXPECT_EQ(encoded(static_cast<uint16_t>(value)), octets);
            EXPECT_EQ(decoded<uint16_t>(octets), value);
        } else {
            EXPECT_FALSE(decoded<uint16_t>(octets)) << octets;
        }
    }
    EXPECT_FALSE(decoded<uint16_t>("C10000")) << "65536, the first beyond";
}

TEST(Long, IsWrittenInTheShortestForm) {
    for (const auto& [value, octets] : signed_vectors) EXPECT_EQ(encoded(value), octets) << value;
}

TEST(Long, IsReadFromTheShortestForm) {
    for (const auto& [value, octets] : signed_vectors) {
        EXPECT_EQ(decoded<int32_t>(octets), value) << octets;
    }
}

TEST(Long, EveryPrefixIsRefused) {
    for (const auto& [value, octets] : signed_vectors) {
        EXPECT_EQ(prefixes_accepted<int32_t>(octets), 0U) << octets;
    }
}

TEST(Long, ALongerFormThanNeededIsRefused) {
    for (const char* octets :
         {"8000", "803F", "BFFF", "BFC0",                             // 0, 63, -1, -64
          "C00000", "C01FFF", "DFFFFF", "DFE000",                     // 0, 8191, -1, -8192
          "E0000000", "E00FFFFF", "EFFFFFFF", "EFF00000",             // 0, 1048575, -1, -1048576
          "F000000000", "F007FFFFFF", "F0FFFFFFFF", "F0F8000000"}) {  // ... -1, -134217728
        EXPECT_FALSE(decoded<int32_t>(octets)) << octets;
    }
}

TEST(Short, IsALongOfItsRange) {
    EXPECT_EQ(encoded(int16_t{32767}), "C07FFF");
    EXPECT_EQ(decoded<int16_t>("C07FFF"), 32767);
    EXPECT_EQ(encoded(int16_t{-32768}), "DF8000");
    EXPECT_EQ(decoded<int16_t>("DF8000"), -32768);
    EXPECT_FALSE(decoded<int16_t>("C08000")) << "32768, the first beyond";
    EXPECT_FALSE(decoded<int16_t>("DF7FFF")) << "-32769, the first below";
    EXPECT_FALSE(decoded<int16_t>("F07FFFFFFF"));
    EXPECT_FALSE(decoded<int16_t>("F080000000"));
}

TEST(Integers, LeftOverOctetsAreRefused) {
    EXPECT_FALSE(decoded<uint32_t>("2B00"));
    EXPECT_FALSE(decoded<int32_t>("808000"));
}

// How long a value is, by the table of the page and not by the code.
constexpr std::size_t unsigned_octets(std::uint64_t value) {
    constexpr std::uint64_t limits[] = {128, 16384, 2097152, 268435456};
    std::size_t octets = 1;
    for (const std::uint64_t limit : limits) octets += value >= limit ? 1 : 0;
    return octets;
}
constexpr std::size_t signed_octets(std::int64_t value) {
    constexpr std::int64_t limits[] = {64, 8192, 1048576, 134217728};
    std::size_t octets = 1;
    for (const std::int64_t limit : limits) octets += value >= limit || value < -limit ? 1 : 0;
    return octets;
}

template <typename T>
void expect_round_trip(T value, std::size_t octets) {
    std::array<std::uint8_t, 5> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, value);
    ASSERT_EQ(out.error(), ccdr::EncodeError::none);
    ASSERT_EQ(out.size(), octets) << value;
    ASSERT_EQ(decoded<T>(out.octets()), value);
}

TEST(Integers, EverySixteenBitValueRoundTrips) {
    for (int value = 0; value <= 65535; ++value) {
        expect_round_trip(static_cast<uint16_t>(value),
                          unsigned_octets(static_cast<std::uint64_t>(value)));
    }
    for (int value = -32768; value <= 32767; ++value) {
        expect_round_trip(static_cast<int16_t>(value), signed_octets(value));
    }
}

TEST(Integers, EveryPowerOfTwoAndItsNeighboursRoundTrip) {
    for (unsigned bit = 0; bit < 32; ++bit) {
        for (const std::int64_t near : {-1, 0, 1}) {
            const std::int64_t value = (std::int64_t{1} << bit) + near;
            expect_round_trip(static_cast<uint32_t>(value),
                              unsigned_octets(static_cast<std::uint64_t>(value)));
            if (value > std::numeric_limits<int32_t>::max()) continue;
            expect_round_trip(static_cast<int32_t>(value), signed_octets(value));
            expect_round_trip(static_cast<int32_t>(-value), signed_octets(-value));
        }
    }
}

// There is one encoding for each value: of all strings of up to three octets exactly 65536 are an
// unsigned short, and as many a short.
template <typename T>
std::size_t valid_strings(std::size_t size) {
    std::size_t valid = 0;
    std::array<std::uint8_t, 3> octets{};
    for (uint32_t n = 0; n < (uint32_t{1} << (8 * size)); ++n) {
        for (std::size_t i = 0; i < size; ++i) {
            octets[i] = static_cast<std::uint8_t>(n >> (8 * (size - 1 - i)));
        }
        if (decoded<T>(Bytes{octets}.first(size))) ++valid;
    }
    return valid;
}

TEST(Integers, EverySixteenBitValueHasOneEncoding) {
    EXPECT_EQ(valid_strings<uint16_t>(1), 128U);
    EXPECT_EQ(valid_strings<uint16_t>(2), 16384U - 128U);
    EXPECT_EQ(valid_strings<uint16_t>(3), 65536U - 16384U);
    EXPECT_EQ(valid_strings<int16_t>(1), 128U);
    EXPECT_EQ(valid_strings<int16_t>(2), 16384U - 128U);
    EXPECT_EQ(valid_strings<int16_t>(3), 65536U - 16384U);
}

}  // namespace
}  // namespace canorb::test
