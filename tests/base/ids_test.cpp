#include "orb/base/ids.hpp"

#include <gtest/gtest.h>

namespace canorb {
namespace {

TEST(NodeId, IsZeroToThirty) {
    EXPECT_EQ(NodeId::from(0), NodeId{0});
    EXPECT_EQ(NodeId::from(30), NodeId{30});
    for (const long long value : {-1LL, 31LL, 32LL, 256LL, 1LL << 40}) {
        EXPECT_FALSE(NodeId::from(value)) << value;
    }
    EXPECT_TRUE(NodeId{30}.is_valid());
    EXPECT_FALSE(NodeId{31}.is_valid());
}

TEST(GroupId, IsOneToThirtyOneForApplications) {
    EXPECT_EQ(GroupId::from(1), GroupId{1});
    EXPECT_EQ(GroupId::from(31), GroupId{31});
    for (const long long value : {-1LL, 0LL, 32LL, 257LL, 1LL << 40}) {
        EXPECT_FALSE(GroupId::from(value)) << value;
    }
    EXPECT_FALSE(GroupId{0}.is_valid());
    EXPECT_TRUE(GroupId{31}.is_valid());
    EXPECT_FALSE(GroupId{32}.is_valid());
}

TEST(ObjectKey, HasTheNodeInItsFirstFiveBits) {
    const ObjectKey key{NodeId{3}, 1};
    EXPECT_EQ(key.value(), 0x1801);
    EXPECT_EQ(key.node(), NodeId{3});
    EXPECT_EQ(key.index(), 1);
    EXPECT_EQ((ObjectKey{NodeId{0}, management_object_index}.value()), 0x0000);
    EXPECT_EQ((ObjectKey{NodeId{30}, last_object_index}.value()), 0xF7FF);
    EXPECT_EQ(ObjectKey{0xF7FF}.node(), NodeId{30});
    EXPECT_EQ(ObjectKey{0xF7FF}.index(), 2047);
    EXPECT_EQ(ObjectKey{0xF800}.node().value(), 31) << "a key that no node has";
}

TEST(ObjectIndex, UsersAndSystemShareTheRange) {
    EXPECT_EQ(first_user_index, management_object_index + 1);
    EXPECT_EQ(last_user_index, 1023);
    EXPECT_EQ(first_system_index, 1024);
    EXPECT_EQ(last_object_index, 2047);
}

}  // namespace
}  // namespace canorb
