#include "orb/base/interface_info.hpp"

#include <gtest/gtest.h>

namespace canorb {
namespace {

constexpr InterfaceInfo base{"IDL:Devices/Base:1.0"};
constexpr InterfaceInfo logged{"IDL:Devices/Logged:1.0"};
constexpr const InterfaceInfo* motor_bases[] = {&base, &logged};
constexpr InterfaceInfo motor{"IDL:Devices/Motor:1.0", motor_bases};
constexpr const InterfaceInfo* servo_bases[] = {&motor};
constexpr InterfaceInfo servo{"IDL:Devices/Servo:1.0", servo_bases};

TEST(Crc16, AgreesWithPublishedValues) {
    EXPECT_EQ(crc16_ccitt_false(""), 0xFFFF);
    EXPECT_EQ(crc16_ccitt_false("123456789"), 0x29B1);
    EXPECT_EQ(crc16_ccitt_false("IDL:Devices/Motor:1.0"), 0x4DDB);
}

TEST(GroupKey, IsTheCrcOfTheRepositoryId) {
    EXPECT_EQ(motor.group_key(), 0x4DDB);
}

TEST(GroupKey, IsOneWhereTheCrcIsZero) {
    // Its own big-endian CRC behind a text makes the CRC of the whole 0.
    constexpr std::string_view text = "123456789\x29\xB1";
    ASSERT_EQ(crc16_ccitt_false(text), 0);
    EXPECT_EQ(InterfaceInfo{text}.group_key(), 1);
}

TEST(InterfaceInfo, IsItselfAndAllItsBases) {
    EXPECT_TRUE(servo.is_a("IDL:Devices/Servo:1.0"));
    EXPECT_TRUE(servo.is_a("IDL:Devices/Motor:1.0"));
    EXPECT_TRUE(servo.is_a("IDL:Devices/Logged:1.0"));
    EXPECT_FALSE(base.is_a("IDL:Devices/Motor:1.0"));
    EXPECT_FALSE(servo.is_a("IDL:Devices/Servo:1.1"));
    EXPECT_TRUE(servo.has_group_key(0x4DDB));
    EXPECT_TRUE(servo.has_group_key(base.group_key()));
    EXPECT_FALSE(base.has_group_key(0x4DDB));
}

}  // namespace
}  // namespace canorb
