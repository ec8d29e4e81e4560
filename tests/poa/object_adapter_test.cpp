#include "orb/poa/object_adapter.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

namespace canorb::poa {
namespace {

constexpr InterfaceInfo pump_interface{"IDL:Test/Pump:1.0"};

class Pump final : public Servant {
  public:
    const InterfaceInfo& _interface_info() const override { return pump_interface; }
    void _dispatch(ServerCall&) override {}
};

class ObjectAdapterTest : public testing::Test {
  protected:
    ObjectAdapter adapter_;
    Pump pump_;
    Pump other_;
};

TEST_F(ObjectAdapterTest, SystemIdsCountUpFrom1024) {
    EXPECT_EQ(*adapter_.activate(pump_), 1024);
    EXPECT_EQ(*adapter_.activate(other_), 1025);
    EXPECT_EQ(adapter_.find(1024), &pump_);
    EXPECT_EQ(adapter_.find(1025), &other_);
    EXPECT_EQ(adapter_.find(1026), nullptr);
}

TEST_F(ObjectAdapterTest, ASystemIdIsNeverUsedAgain) {
    for (ObjectIndex expected = 1024; expected < 1034; ++expected) {
        ASSERT_EQ(*adapter_.activate(pump_), expected);
        ASSERT_TRUE(adapter_.deactivate(expected));
        EXPECT_EQ(adapter_.find(expected), nullptr);
    }
}

TEST_F(ObjectAdapterTest, SystemIdsEndAt2047) {
    std::vector<Pump> pumps(1024);
    for (Pump& pump : pumps) ASSERT_TRUE(adapter_.activate(pump).ok());
    EXPECT_EQ(adapter_.find(2047), &pumps.back());
    EXPECT_EQ(adapter_.activate(pump_).error(), ActivationError::exhausted);
    // That one is free again does not help: references to it may still be around.
    ASSERT_TRUE(adapter_.deactivate(1024));
    EXPECT_EQ(adapter_.activate(pump_).error(), ActivationError::exhausted);
    EXPECT_TRUE(adapter_.activate_with_id(1, pump_).ok());
}

TEST_F(ObjectAdapterTest, UserIdsAreFrom1To1023) {
    EXPECT_EQ(*adapter_.activate_with_id(1, pump_), 1);
    EXPECT_EQ(*adapter_.activate_with_id(1023, other_), 1023);
    EXPECT_EQ(adapter_.find(1), &pump_);
    EXPECT_EQ(adapter_.find(1023), &other_);
    Pump third;
    for (const ObjectIndex index : std::initializer_list<ObjectIndex>{0, 1024, 2047, 2048, 65535}) {
        EXPECT_EQ(adapter_.activate_with_id(index, third).error(),
                  ActivationError::index_out_of_range)
            << index;
        EXPECT_EQ(adapter_.find(index), nullptr) << index;
    }
}

TEST_F(ObjectAdapterTest, AUserIdThatIsFreeAgainMayBeUsedAgain) {
    ASSERT_TRUE(adapter_.activate_with_id(7, pump_).ok());
    EXPECT_EQ(adapter_.activate_with_id(7, other_).error(), ActivationError::object_already_active);
    EXPECT_EQ(adapter_.find(7), &pump_);
    ASSERT_TRUE(adapter_.deactivate(7));
    EXPECT_EQ(*adapter_.activate_with_id(7, other_), 7);
}

TEST_F(ObjectAdapterTest, AServantIsOneObject) {
    ASSERT_TRUE(adapter_.activate_with_id(7, pump_).ok());
    EXPECT_EQ(adapter_.activate_with_id(8, pump_).error(), ActivationError::servant_already_active);
    EXPECT_EQ(adapter_.activate(pump_).error(), ActivationError::servant_already_active);
    EXPECT_EQ(adapter_.activate_with_id(7, pump_).error(), ActivationError::object_already_active);
    // What failed has used nothing up.
    EXPECT_EQ(*adapter_.activate(other_), 1024);
    ASSERT_TRUE(adapter_.deactivate(7));
    EXPECT_EQ(*adapter_.activate(pump_), 1025);
}

TEST_F(ObjectAdapterTest, OnlyAnActiveObjectCanBeDeactivated) {
    for (const ObjectIndex index :
         std::initializer_list<ObjectIndex>{0, 7, 1024, 2047, 2048, 65535}) {
        EXPECT_FALSE(adapter_.deactivate(index)) << index;
    }
    ASSERT_TRUE(adapter_.activate_with_id(7, pump_).ok());
    EXPECT_TRUE(adapter_.deactivate(7));
    EXPECT_FALSE(adapter_.deactivate(7));
}

}  // namespace
}  // namespace canorb::poa
