#include "orb/caniop/filters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/octets.hpp"

namespace canorb::caniop {
namespace {

using can::Filter;
using can::Frame;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<GroupId> groups(std::initializer_list<int> numbers) {
    std::vector<GroupId> result;
    for (const int number : numbers) result.emplace_back(static_cast<std::uint8_t>(number));
    return result;
}

std::vector<Filter> exact(std::optional<NodeId> self, std::initializer_list<int> numbers) {
    const FilterSet set = exact_filters(self, groups(numbers));
    return {set.span().begin(), set.span().end()};
}

std::vector<Filter> mask(std::optional<NodeId> self, std::initializer_list<int> numbers) {
    const FilterSet set = mask_filters(self, groups(numbers));
    return {set.span().begin(), set.span().end()};
}

bool pass(const std::vector<Filter>& filters, std::uint32_t id) {
    const Frame frame = Frame::standard(id, {});
    return std::any_of(filters.begin(), filters.end(),
                       [&](const Filter& filter) { return filter.accepts(frame); });
}

constexpr Filter node_3{.mask = 0x7E0, .value = 0x460, .data_only = true};

TEST(Filters, ExactOnesAreTheNodesOwnAndOneForEachGroup) {
    EXPECT_THAT(exact(NodeId{3}, {5, 1}),
                ElementsAre(node_3, Filter{.mask = 0x7E0, .value = 0x020, .data_only = true},
                            Filter{.mask = 0x7E0, .value = 0x0A0, .data_only = true}));
    EXPECT_THAT(exact(NodeId{3}, {}), ElementsAre(node_3));
    EXPECT_THAT(exact(std::nullopt, {31}),
                ElementsAre(Filter{.mask = 0x7E0, .value = 0x3E0, .data_only = true}));
    EXPECT_THAT(exact(std::nullopt, {}), IsEmpty());
}

TEST(Filters, ExactOnesHaveRoomForEveryGroup) {
    std::vector<GroupId> all;
    for (std::uint8_t group = 0; group <= GroupId::highest; ++group) all.emplace_back(group);
    EXPECT_EQ(exact_filters(NodeId{0}, all).size(), 33U);
}

TEST(Filters, MasksAreThoseOfTheWorkedExample) {
    // M = 11001, V = 00001; RMIM = 1 11001 00000, RMIS = 0 00001 00000.
    const auto filters = mask(NodeId{3}, {1, 3, 5});
    EXPECT_THAT(filters, ElementsAre(node_3, Filter{.mask = 0x720, .value = 0x020}));
    const auto passes = [&](int group) {
        return pass(filters, static_cast<std::uint32_t>(group << 5 | 9));
    };
    EXPECT_TRUE(passes(1));
    EXPECT_TRUE(passes(3));
    EXPECT_TRUE(passes(5));
    EXPECT_TRUE(passes(7));  // the false positive
    EXPECT_FALSE(passes(14));
    EXPECT_FALSE(passes(0));
}

TEST(Filters, MasksForOtherLists) {
    EXPECT_THAT(mask(NodeId{3}, {}), ElementsAre(node_3));
    EXPECT_THAT(mask(std::nullopt, {}), IsEmpty());
    EXPECT_THAT(mask(std::nullopt, {5}), ElementsAre(Filter{.mask = 0x7E0, .value = 0x0A0}));
    EXPECT_THAT(mask(std::nullopt, {31, 0}), ElementsAre(Filter{.mask = 0x400, .value = 0x000}));
    // 00110, 01110: M = 10111, V = 00110.
    EXPECT_THAT(mask(std::nullopt, {6, 14}), ElementsAre(Filter{.mask = 0x6E0, .value = 0x0C0}));
}

TEST(Filters, LetEveryMemberGroupAndTheNodePassAndNoOtherNode) {
    const auto members = {2, 9, 30};
    for (const auto& filters : {exact(NodeId{7}, members), mask(NodeId{7}, members)}) {
        for (std::uint32_t sender = 0; sender <= 31; ++sender) {
            for (const int group : members) {
                EXPECT_TRUE(pass(filters, static_cast<std::uint32_t>(group) << 5 | sender));
            }
            for (std::uint32_t node = 0; node <= 31; ++node) {
                EXPECT_EQ(pass(filters, 0x400U | node << 5 | sender), node == 7);
            }
        }
    }
}

TEST(Admit, NamesTheIdentifierOfWhatIsForThisNode) {
    const auto node = admit(Frame::standard(0x465, {}), NodeId{3}, groups({1}));
    EXPECT_EQ(std::get<Identifier>(node), Identifier::to_node(NodeId{3}, NodeId{5}));
    const auto group = admit(Frame::standard(0x025, {}), std::nullopt, groups({2, 1}));
    EXPECT_EQ(std::get<Identifier>(group), Identifier::to_group(GroupId{1}, NodeId{5}));
}

TEST(Admit, NamesTheCounterOfWhatIsNot) {
    Frame extended = Frame::standard(0x465, {});
    extended.extended = true;
    Frame remote = Frame::standard(0x465, {});
    remote.remote = true;
    Frame error = Frame::standard(0x465, {});
    error.error = true;
    const struct {
        Frame frame;
        Counter counter;
    } cases[] = {
        {extended, Counter::frames_not_caniop},
        {remote, Counter::frames_not_caniop},
        {error, Counter::frames_not_caniop},
        {Frame::standard(0x7E5, {}), Counter::frames_not_caniop},
        {Frame::standard(0x7F5, {}), Counter::frames_not_caniop},
        {Frame::standard(0x47F, {}), Counter::frames_not_caniop},  // sender without a number
        {Frame::standard(0x463, {}), Counter::frames_of_duplicate_node},
        {Frame::standard(0x4A3, {}), Counter::frames_of_duplicate_node},  // 3 to another node
        {Frame::standard(0x0E3, {}), Counter::frames_of_duplicate_node},  // 3 to another group
        {Frame::standard(0x485, {}), Counter::frames_for_other_nodes},
        {Frame::standard(0x0E5, {}), Counter::frames_of_other_groups},
    };
    for (const auto& each : cases) {
        const auto verdict = admit(each.frame, NodeId{3}, groups({1, 3, 5}));
        ASSERT_TRUE(std::holds_alternative<Counter>(verdict)) << each.frame.id;
        EXPECT_EQ(std::get<Counter>(verdict), each.counter) << each.frame.id;
    }
    // Without a number nothing peer to peer is for this node.
    EXPECT_EQ(std::get<Counter>(admit(Frame::standard(0x465, {}), std::nullopt, {})),
              Counter::frames_for_other_nodes);
}

}  // namespace
}  // namespace canorb::caniop
