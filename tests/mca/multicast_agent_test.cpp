#include "orb/mca/multicast_agent.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace canorb::mca {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// What derives from what:
//
//     device     sensor     alone
//      |   |      |   |
//    motor valve  |   gauge
//      |   |      |
//      +---+------+
//        station           a diamond below device, and a sensor
constexpr InterfaceInfo device{"IDL:device:1.0"};
constexpr InterfaceInfo sensor{"IDL:sensor:1.0"};
constexpr InterfaceInfo alone{"IDL:alone:1.0"};
constexpr const InterfaceInfo* device_only[] = {&device};
constexpr const InterfaceInfo* sensor_only[] = {&sensor};
constexpr InterfaceInfo motor{"IDL:motor:1.0", device_only};
constexpr InterfaceInfo valve{"IDL:valve:1.0", device_only};
constexpr InterfaceInfo gauge{"IDL:gauge:1.0", sensor_only};
constexpr const InterfaceInfo* station_bases[] = {&motor, &valve, &sensor};
constexpr InterfaceInfo station{"IDL:station:1.0", station_bases};

constexpr GroupId group{5};

std::vector<int> indices(const MulticastAgent& agent, GroupId of) {
    std::vector<int> result;
    for (const Member& member : agent.members(of)) result.push_back(member.index);
    return result;
}

std::vector<int> groups(const MulticastAgent& agent) {
    std::vector<int> result;
    for (const GroupId id : agent.groups()) result.push_back(id.value());
    return result;
}

std::string common(const MulticastAgent& agent) {
    const InterfaceInfo* interface = agent.common_interface(group);
    return interface == nullptr ? "" : std::string{interface->repository_id};
}

TEST(MulticastAgent, KeepsMembersInTheOrderOfTheirJoining) {
    MulticastAgent agent;
    EXPECT_TRUE(agent.join(group, {7, &motor}));
    EXPECT_TRUE(agent.join(group, {1024, &motor}));
    EXPECT_TRUE(agent.join(group, {3, &motor}));
    EXPECT_THAT(indices(agent, group), ElementsAre(7, 1024, 3));
    agent.leave(group, 7);
    EXPECT_TRUE(agent.join(group, {7, &motor}));
    EXPECT_THAT(indices(agent, group), ElementsAre(1024, 3, 7));
    EXPECT_TRUE(agent.is_member(group, 3));
    EXPECT_FALSE(agent.is_member(group, 4));
    EXPECT_FALSE(agent.is_member(GroupId{6}, 3));
}

TEST(MulticastAgent, JoiningTwiceIsJoiningOnce) {
    MulticastAgent agent;
    EXPECT_TRUE(agent.join(group, {7, &motor}));
    EXPECT_TRUE(agent.join(group, {7, &motor}));
    EXPECT_THAT(indices(agent, group), ElementsAre(7));
    agent.leave(group, 7);
    EXPECT_FALSE(agent.has_members(group));
    agent.leave(group, 7);
    EXPECT_THAT(groups(agent), IsEmpty());
}

TEST(MulticastAgent, ListsGroupsWithMembersLowestFirst) {
    MulticastAgent agent;
    EXPECT_THAT(groups(agent), IsEmpty());
    for (const int id : {31, 5, 17, 1}) {
        EXPECT_TRUE(agent.join(GroupId{static_cast<std::uint8_t>(id)}, {7, &motor}));
    }
    EXPECT_TRUE(agent.join(GroupId{17}, {8, &motor}));
    EXPECT_THAT(groups(agent), ElementsAre(1, 5, 17, 31));
    agent.leave(GroupId{17}, 7);
    EXPECT_THAT(groups(agent), ElementsAre(1, 5, 17, 31));
    agent.leave(GroupId{5}, 7);
    EXPECT_THAT(groups(agent), ElementsAre(1, 17, 31));
    agent.leave_all(7);
    EXPECT_THAT(groups(agent), ElementsAre(17));
    EXPECT_THAT(indices(agent, GroupId{17}), ElementsAre(8));
}

TEST(MulticastAgent, RefusesWhoSharesNoInterfaceWithTheMembers) {
    MulticastAgent agent;
    EXPECT_TRUE(agent.join(group, {1, &motor}));
    EXPECT_FALSE(agent.join(group, {2, &alone}));
    EXPECT_FALSE(agent.join(group, {2, &gauge}));
    EXPECT_THAT(indices(agent, group), ElementsAre(1));
    EXPECT_TRUE(agent.join(group, {2, &valve}));
    // Nothing of the kind elsewhere, or once they have left.
    EXPECT_TRUE(agent.join(GroupId{6}, {3, &alone}));
    agent.leave_all(1);
    agent.leave_all(2);
    EXPECT_TRUE(agent.join(group, {3, &alone}));
}

TEST(MulticastAgent, OneInterfaceForEachPairIsNotEnough) {
    // station shares device with motor and sensor with gauge, but the three have none.
    MulticastAgent agent;
    EXPECT_TRUE(agent.join(group, {1, &motor}));
    EXPECT_TRUE(agent.join(group, {2, &station}));
    EXPECT_FALSE(agent.join(group, {3, &gauge}));
    agent.leave(group, 1);
    EXPECT_TRUE(agent.join(group, {3, &gauge}));
    EXPECT_FALSE(agent.join(group, {1, &motor}));
}

TEST(MulticastAgent, CorbaObjectIsNoInterfaceInCommon) {
    static constexpr InterfaceInfo object{corba_object_id};
    static constexpr const InterfaceInfo* object_only[] = {&object};
    static constexpr InterfaceInfo one{"IDL:one:1.0", object_only};
    static constexpr InterfaceInfo two{"IDL:two:1.0", object_only};
    MulticastAgent agent;
    EXPECT_TRUE(agent.join(group, {1, &one}));
    EXPECT_FALSE(agent.join(group, {2, &two}));
}

TEST(MulticastAgent, InterfacesAreComparedByRepositoryId) {
    // Two programs' or two libraries' constants for one interface.
    static constexpr InterfaceInfo other_device{"IDL:device:1.0"};
    MulticastAgent agent;
    EXPECT_TRUE(agent.join(group, {1, &motor}));
    EXPECT_TRUE(agent.join(group, {2, &other_device}));
    EXPECT_EQ(common(agent), "IDL:device:1.0");
}

struct Commonness {
    std::string name;
    std::vector<const InterfaceInfo*> members;
    std::string expected;
};

// Two levels of diamonds in which the first branch's first candidate (x) hides y from a search that
// asks each branch for one, although w, which the second branch offers behind v, derives from x.
constexpr InterfaceInfo x{"IDL:x:1.0"};
constexpr InterfaceInfo v{"IDL:v:1.0"};
constexpr const InterfaceInfo* x_only[] = {&x};
constexpr InterfaceInfo w{"IDL:w:1.0", x_only};
constexpr const InterfaceInfo* v_and_w[] = {&v, &w};
constexpr InterfaceInfo second_branch{"IDL:second:1.0", v_and_w};
constexpr InterfaceInfo first_branch{"IDL:first:1.0", x_only};
constexpr const InterfaceInfo* both_branches[] = {&first_branch, &second_branch};
constexpr InterfaceInfo bottom{"IDL:bottom:1.0", both_branches};
constexpr const InterfaceInfo* w_and_v[] = {&w, &v};
constexpr InterfaceInfo peer{"IDL:peer:1.0", w_and_v};

class CommonInterface : public testing::TestWithParam<Commonness> {};

TEST_P(CommonInterface, IsTheMostDerived) {
    MulticastAgent agent;
    ObjectIndex index = 1;
    for (const InterfaceInfo* interface : GetParam().members) {
        ASSERT_TRUE(agent.join(group, {index++, interface}));
    }
    EXPECT_EQ(common(agent), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(
    Members, CommonInterface,
    testing::Values(Commonness{"Nobody", {}, ""}, Commonness{"One", {&motor}, "IDL:motor:1.0"},
                    Commonness{"Same", {&motor, &motor}, "IDL:motor:1.0"},
                    Commonness{"Siblings", {&motor, &valve}, "IDL:device:1.0"},
                    Commonness{"BaseFirst", {&device, &motor}, "IDL:device:1.0"},
                    Commonness{"BaseLast", {&motor, &device}, "IDL:device:1.0"},
                    Commonness{"DiamondAndItsSide", {&station, &valve}, "IDL:valve:1.0"},
                    Commonness{"SideAndItsDiamond", {&motor, &station}, "IDL:motor:1.0"},
                    Commonness{"DiamondAndItsTop", {&station, &device}, "IDL:device:1.0"},
                    Commonness{"DiamondAndBothSides", {&station, &motor, &valve}, "IDL:device:1.0"},
                    Commonness{"OtherBranch", {&station, &gauge}, "IDL:sensor:1.0"},
                    // v and w are both most derived: the one found first from the first member.
                    Commonness{"SeveralMostDerived", {&peer, &second_branch}, "IDL:w:1.0"},
                    Commonness{"NotHiddenBehindABase", {&bottom, &peer}, "IDL:w:1.0"}),
    [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace canorb::mca
