#include "orb/caniop/identifier.hpp"

#include <gtest/gtest.h>

namespace canorb::caniop {
namespace {

TEST(Identifier, PutsItsFieldsWhereTheTableSays) {
    // 1 00011 00101
    EXPECT_EQ(Identifier::to_node(NodeId{3}, NodeId{5}).can_id(), 0x465U);
    // 0 00011 00101
    EXPECT_EQ(Identifier::to_group(GroupId{3}, NodeId{5}).can_id(), 0x065U);
    // The ends of the ranges.
    EXPECT_EQ(Identifier::to_node(NodeId{0}, NodeId{0}).can_id(), 0x400U);
    EXPECT_EQ(Identifier::to_node(NodeId{30}, NodeId{30}).can_id(), 0x7DEU);
    EXPECT_EQ(Identifier::to_group(GroupId{0}, NodeId{0}).can_id(), 0x000U);
    EXPECT_EQ(Identifier::to_group(GroupId{31}, NodeId{30}).can_id(), 0x3FEU);
}

TEST(Identifier, ReadsEveryFieldBack) {
    const auto identifier = Identifier::from_can_id(0x465);
    ASSERT_TRUE(identifier);
    EXPECT_TRUE(identifier->peer_to_peer);
    EXPECT_EQ(identifier->receiver, 3);
    EXPECT_EQ(identifier->sender, 5);
    const auto group = Identifier::from_can_id(0x3FF);
    ASSERT_TRUE(group);
    EXPECT_FALSE(group->peer_to_peer);
    EXPECT_EQ(group->receiver, 31);
    EXPECT_EQ(group->sender, 31);
}

TEST(Identifier, KnowsExactlyThoseThatCaniopSends) {
    for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
        const auto identifier = Identifier::from_can_id(id);
        ASSERT_EQ(identifier.has_value(), id < 0x7E0) << id;
        if (identifier) {
            ASSERT_EQ(identifier->can_id(), id);
        }
    }
    EXPECT_FALSE(Identifier::from_can_id(0x800));
    EXPECT_FALSE(Identifier::from_can_id(0x10000465));
}

TEST(Identifier, EveryGroupWinsArbitrationOverEveryNodeAndALowerGroupOverAHigher) {
    EXPECT_LT(Identifier::to_group(GroupId{31}, NodeId{30}).can_id(),
              Identifier::to_node(NodeId{0}, NodeId{0}).can_id());
    EXPECT_LT(Identifier::to_group(GroupId{4}, NodeId{30}).can_id(),
              Identifier::to_group(GroupId{5}, NodeId{0}).can_id());
}

}  // namespace
}  // namespace canorb::caniop
