#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "orb/base/bytes.hpp"
#include "orb/base/fifo.hpp"
#include "orb/base/result.hpp"

namespace canorb {
namespace {

TEST(BigEndian, HasTheHighOctetFirst) {
    std::uint8_t octets[2] = {};
    write_be16(octets, 0x12FE);
    EXPECT_EQ(octets[0], 0x12);
    EXPECT_EQ(octets[1], 0xFE);
    EXPECT_EQ(read_be16(octets), 0x12FE);
}

enum class Error { first, second };

Result<std::string, Error> answer(bool well) {
    if (!well) return Failure{Error::second};
    return std::string{"well"};
}

TEST(Result, IsAValueOrAnError) {
    const auto good = answer(true);
    ASSERT_TRUE(good.ok());
    EXPECT_TRUE(good);
    EXPECT_EQ(*good, "well");
    EXPECT_EQ(good->size(), 4U);
    const auto bad = answer(false);
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.error(), Error::second);
}

TEST(Result, TellsValueAndErrorOfOneTypeApart) {
    const Result<int, int> good{1};
    const Result<int, int> bad{Failure{1}};
    EXPECT_TRUE(good.ok());
    EXPECT_FALSE(bad.ok());
}

TEST(Fifo, GivesBackInTheOrderOfThePushes) {
    Fifo<std::unique_ptr<int>> fifo{3};
    EXPECT_TRUE(fifo.empty());
    EXPECT_FALSE(fifo.pop());
    int pushed = 0;
    int popped = 0;
    // More rounds than places, so that it wraps around at every place.
    for (int round = 0; round < 4; ++round) {
        while (!fifo.full()) fifo.push(std::make_unique<int>(pushed++));
        EXPECT_EQ(fifo.size(), 3U);
        for (int i = 0; i < 2; ++i) EXPECT_EQ(**fifo.pop(), popped++);
    }
    while (const auto item = fifo.pop()) EXPECT_EQ(**item, popped++);
    EXPECT_EQ(popped, pushed);
    EXPECT_TRUE(fifo.empty());
}

}  // namespace
}  // namespace canorb
