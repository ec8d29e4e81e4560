// Sequences, arrays, structs and enums, and how they nest: doc/wire/ccdr.md, "Constructed types".
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/ccdr/codec.hpp"

namespace Devices {

// As the IDL compiler writes them, in a namespace of their own: only the Encoder and the Decoder
// lead to the functions of canorb::ccdr.
enum class State : std::uint32_t { stopped, running, broken };

void encode(canorb::ccdr::Encoder& out, State value) {
    const auto number = static_cast<std::uint32_t>(value);
    if (number > 2) return out.fail();
    out.variable_unsigned(number);
}
void decode(canorb::ccdr::Decoder& in, State& value) {
    value = static_cast<State>(in.variable_unsigned(2));
}

struct Sample {
    std::int16_t level{};
    State state{};
    std::string note;
    friend bool operator==(const Sample&, const Sample&) = default;
};

void encode(canorb::ccdr::Encoder& out, const Sample& value) {
    encode(out, value.level);
    encode(out, value.state);
    encode(out, value.note);
}
void decode(canorb::ccdr::Decoder& in, Sample& value) {
    decode(in, value.level);
    decode(in, value.state);
    decode(in, value.note);
}

}  // namespace Devices

namespace canorb::test {
namespace {

using Devices::Sample;
using Devices::State;
using ::testing::Test;

// Octets and value both ways, and every prefix refused.
template <typename T>
void expect_encoding(const T& value, std::string_view golden) {
    EXPECT_EQ(encoded(value), hex(octets(golden)));
    EXPECT_EQ(decoded<T>(golden), value) << golden;
    EXPECT_EQ(prefixes_accepted<T>(golden), 0U) << golden;
}

TEST(Enum, IsAnUnsignedLongOfItsRange) {
    expect_encoding(State::running, "01");
    EXPECT_FALSE(decoded<State>("03"));
    EXPECT_EQ(encoded(static_cast<State>(3)), "bad_value");
}

TEST(Struct, IsItsMembersInOrder) {
    expect_encoding(Sample{-65, State::broken, "A"}, "BFBF 02 024100");
}

TEST(Array, IsItsElements) {
    expect_encoding(std::array<std::uint16_t, 3>{1, 128, 3}, "01 8080 03");
    expect_encoding(std::array<std::array<std::uint8_t, 2>, 2>{{{1, 2}, {3, 4}}}, "01020304");
    expect_encoding(std::array<State, 2>{State::running, State::stopped}, "0100");
    expect_encoding(std::array<std::string, 2>{"A", ""}, "024100 0100");
}

TEST(Sequence, IsCountAndElements) {
    EXPECT_EQ(encoded(std::vector<std::uint8_t>{}), "00");
    EXPECT_EQ(decoded<std::vector<std::uint8_t>>("00"), std::vector<std::uint8_t>{});
    expect_encoding(std::vector<std::uint8_t>{0xFF, 0x00}, "02 FF00");
    expect_encoding(std::vector<bool>{true, false, true}, "03 010001");
    expect_encoding(std::vector<std::uint16_t>{1, 128, 65535}, "03 01 8080 C0FFFF");
    expect_encoding(std::vector<std::int32_t>{-1, 64}, "02 7F 8040");
    expect_encoding(std::vector<float>{1.0F}, "01 3F800000");
    expect_encoding(std::vector<double>{-2.5}, "01 C004000000000000");
    expect_encoding(std::vector<std::uint64_t>{1}, "01 0000000000000001");
    expect_encoding(std::vector<std::string>{"A", ""}, "02 024100 0100");
    expect_encoding(std::vector<State>{State::broken}, "01 02");
    expect_encoding(std::vector<Sample>{{1, State::running, ""}, {2, State::stopped, "B"}},
                    "02 01010100 0200024200");
}

TEST(Sequence, Nests) {
    expect_encoding(std::vector<std::vector<std::uint16_t>>{{1, 2}, {}, {3}}, "03 020102 00 0103");
    expect_encoding(std::vector<std::array<std::vector<State>, 2>>{{{{State::running}, {}}}},
                    "01 0101 00");
    expect_encoding(std::vector<std::array<std::uint8_t, 2>>{{1, 2}, {3, 4}}, "02 0102 0304");
    expect_encoding(std::array<std::vector<std::string>, 2>{{{"A"}, {}}}, "01024100 00");
}

TEST(Sequence, OfManyGrowsBeyondItsFirstAllocation) {
    // Strings are much larger in memory than in octets, so they are not all reserved at once.
    std::vector<std::string> texts(1000);
    texts[999] = "last";
    EXPECT_EQ(decoded<std::vector<std::string>>(encoded(texts)), texts);
}

TEST(Sequence, ABadElementRefusesAll) {
    EXPECT_FALSE(decoded<std::vector<bool>>("03 010201"));
    EXPECT_FALSE(decoded<std::vector<State>>("02 0003"));
    EXPECT_FALSE(decoded<std::vector<std::string>>("02 024100 00"));
    EXPECT_FALSE(decoded<std::vector<std::uint16_t>>("01 8001"));
    EXPECT_EQ(encoded(std::vector<State>{State::running, static_cast<State>(9)}), "bad_value");
}

TEST(Sequence, LeftOverOctetsAreRefused) {
    EXPECT_FALSE(decoded<std::vector<std::uint8_t>>("01 FF 00"));
    EXPECT_FALSE(decoded<std::vector<std::string>>("00 00"));
}

// Counts that the octets behind them cannot hold, for every kind of element.
template <typename T>
class HostileCount : public Test {};
using ElementTypes =
    ::testing::Types<bool, char, std::uint8_t, std::int8_t, std::uint16_t, std::int16_t,
                     std::uint32_t, std::int32_t, std::uint64_t, std::int64_t, float, double,
                     std::string, State, Sample, std::vector<std::uint8_t>,
                     std::vector<std::vector<std::string>>, std::array<double, 1000>,
                     BoundedString<8>, BoundedVector<std::uint32_t, 4>>;
TYPED_TEST_SUITE(HostileCount, ElementTypes);

TYPED_TEST(HostileCount, IsRefused) {
    for (const char* octets :
         {"01", "7F", "7F00", "BFFF00", "C04000 00", "DFFFFF 0100", "EFFFFFFF 0100",
          "F07FFFFFFF 0100", "F080000000 0100", "F0FFFFFFFF 0100 0100", "8001 00"}) {
        EXPECT_FALSE(decoded<std::vector<TypeParam>>(octets)) << octets;
    }
}

struct Block {
    std::array<std::uint64_t, 1000> values{};
};
void decode(ccdr::Decoder& in, Block& value) {
    decode(in, value.values);
}

TEST(HostileCounts, DoNotGetMoreMemoryThanTheOctetsAreWorth) {
    // The count is possible as far as the decoder knows: an octet for each Block, of 8000.
    std::vector<std::uint8_t> octets(3 + 20'000);
    octets[0] = 0xC0;
    octets[1] = 20'000 >> 8;
    octets[2] = 20'000 & 0xFF;
    ccdr::Decoder in{octets};
    std::vector<Block> blocks;
    decode(in, blocks);
    EXPECT_FALSE(in.ok());
    EXPECT_LE(blocks.capacity() * sizeof(Block), 16 * octets.size());
}

}  // namespace
}  // namespace canorb::test
