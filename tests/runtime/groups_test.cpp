// Groups: one message, every member once, wherever it is.

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Groups : public World {
  protected:
    static TestServant lamp() { return TestServant{{{0, nothing}, {1, echo}}}; }

    Orb one{bus, node(1)};
    Orb two{bus, node(2)};
    Orb three{bus, node(3)};
    TestServant servants[4] = {lamp(), lamp(), lamp(), lamp()};
};

TEST_F(Groups, EveryMemberIsCalledOnceAndLocalOnesNotOnTheCallersStack) {
    const ObjectRef first = one.root_poa().activate_object(servants[0]);
    const ObjectRef second = one.root_poa().activate_object(servants[1]);
    one.object_join(first, GroupId{5});
    one.object_join(second, GroupId{5});
    one.object_join(second, GroupId{5});  // once is enough
    two.object_join(two.root_poa().activate_object(servants[2]), GroupId{5});
    three.object_join(three.root_poa().activate_object(servants[3]), GroupId{6});

    one.group_reference(GroupId{5}).invoke(0, {});
    EXPECT_EQ(servants[0].calls + servants[1].calls, 0);
    simulation.run_for(10ms);
    EXPECT_EQ(servants[0].calls, 1);
    EXPECT_EQ(servants[1].calls, 1);
    EXPECT_EQ(servants[2].calls, 1);
    EXPECT_EQ(servants[3].calls, 0);
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_EQ(seen[0].frame.id, 0b0'00101'00001U);  // group 5, from node 1

    // From a node that is no member, and from a member's servant's own group reference.
    group(three, 5).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(servants[0].calls, 2);
    EXPECT_EQ(servants[1].calls, 2);
    EXPECT_EQ(servants[2].calls, 2);

    two.object_leave(two.group_members(GroupId{5}).at(0), GroupId{5});
    one.root_poa().deactivate_object(*first.index());
    group(three, 5).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(servants[0].calls, 2);
    EXPECT_EQ(servants[1].calls, 3);
    EXPECT_EQ(servants[2].calls, 2);
}

TEST_F(Groups, CallWithoutGeneratedCodeNamesTheInterfaceThatDeclaresIt) {
    two.object_join(two.root_poa().activate_object(servants[0]), GroupId{5});
    const std::vector<std::uint8_t> octets{7};
    const InvokeResult result = group(one, 5).invoke(ring, octets);
    EXPECT_EQ(result.exception_id, "");
    EXPECT_EQ(result.body, std::vector<std::uint8_t>{});
    simulation.run_for(10ms);
    ASSERT_EQ(seen.size(), 2U);
    const std::uint16_t key = lamp_interface.group_key();
    EXPECT_EQ(seen[0].frame.data[5] << 8 | seen[0].frame.data[6], key);

    const OperationInfo with_result{&lamp_interface, 1, "echo"};
    EXPECT_EQ(error_of([&] { group(one, 5).invoke(with_result, {}); }),
              (SystemError{SystemErrorKind::bad_operation, Completion::no, 19}));
}

TEST_F(Groups, MemberMayLeaveWhileTheGroupIsCalled) {
    TestServant leaver{{{0, [this](ServerCall& call) {
                             for (const ObjectRef& member : one.group_members(GroupId{5})) {
                                 one.object_leave(member, GroupId{5});
                             }
                             nothing(call);
                         }}}};
    one.object_join(one.root_poa().activate_object(leaver), GroupId{5});
    one.object_join(one.root_poa().activate_object(servants[0]), GroupId{5});
    group(two, 5).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(leaver.calls, 1);
    EXPECT_EQ(servants[0].calls, 0);
    EXPECT_TRUE(one.group_members(GroupId{5}).empty());
}

TEST_F(Groups, ReferenceCarriesTheMostDerivedCommonInterface) {
    TestServant horn{{}, horn_interface};
    EXPECT_EQ(one.group_reference(GroupId{5}).type_id(), "");
    one.object_join(one.root_poa().activate_object(servants[0]), GroupId{5});
    one.object_join(one.root_poa().activate_object(servants[1]), GroupId{5});
    EXPECT_EQ(one.group_reference(GroupId{5}).type_id(), "IDL:Test/Lamp:1.0");
    // "IDL:Test/Lamp:1.0", profile 0, group reference, group 5.
    EXPECT_EQ(one.group_to_string(GroupId{5}),
              "CAN_IOR:1249444c3a546573742f4c616d703a312e3000000105");
    const ObjectRef horn_reference = one.root_poa().activate_object(horn);
    one.object_join(horn_reference, GroupId{5});
    EXPECT_EQ(one.group_reference(GroupId{5}).type_id(), "IDL:Test/Device:1.0");
    EXPECT_TRUE(one.object_is_member(horn_reference, GroupId{5}));
    EXPECT_FALSE(one.object_is_member(horn_reference, GroupId{6}));
    EXPECT_EQ(one.group_members(GroupId{5}).size(), 3U);
}

TEST_F(Groups, JoinSaysWhyNot) {
    TestServant stranger{{}, other_interface};
    const ObjectRef lamp_reference = one.root_poa().activate_object(servants[0]);
    one.object_join(lamp_reference, GroupId{5});
    const ObjectRef other = one.root_poa().activate_object(stranger);
    EXPECT_THAT(
        what<BAD_PARAM>([&] { one.object_join(other, GroupId{5}); }),
        testing::AllOf(testing::HasSubstr("IDL:Test/Other:1.0"), testing::HasSubstr("group 5")));
    EXPECT_THAT(what<BAD_PARAM>([&] { one.object_join(lamp_reference, GroupId{0}); }),
                testing::HasSubstr("group 0 is not 1 to 31"));
    EXPECT_THAT(what<BAD_PARAM>([&] { one.object_join(lamp_reference, GroupId{32}); }),
                testing::HasSubstr("group 32 is not 1 to 31"));
    EXPECT_THAT(what<BAD_PARAM>([&] { two.object_join(lamp_reference, GroupId{5}); }),
                testing::HasSubstr("only an object of this node"));
    EXPECT_THROW(one.object_join(group(one, 5), GroupId{5}), BAD_PARAM);
    EXPECT_THROW(one.object_join(ObjectRef{}, GroupId{5}), BAD_PARAM);
    EXPECT_THAT(what<BAD_PARAM>([&] { one.object_join(at(one, 1, 7), GroupId{5}); }),
                testing::HasSubstr("object 7 is not active"));
    EXPECT_THROW(one.group_reference(GroupId{0}), BAD_PARAM);
}

TEST_F(Groups, OperationWithAnAnswerCannotBeSentToAGroup) {
    constexpr OperationInfo query{&lamp_interface, 1, "query"};
    EXPECT_THAT(what<BAD_OPERATION>([&] { call_through(group(one, 5), query); }),
                testing::HasSubstr("query on group 5"));
    EXPECT_THROW(static_cast<void>(group(one, 5)._is_a("IDL:Test/Lamp:1.0")), BAD_OPERATION);
    EXPECT_THROW(static_cast<void>(group(one, 5)._non_existent()), BAD_OPERATION);
    simulation.run_for(10ms);
    EXPECT_TRUE(seen.empty());
}

TEST_F(Groups, MembersWithoutTheInterfaceSkipTheMessage) {
    TestServant horn{{{0, nothing}}, horn_interface};
    two.object_join(two.root_poa().activate_object(servants[0]), GroupId{5});
    three.object_join(three.root_poa().activate_object(horn), GroupId{5});
    one.object_join(one.root_poa().activate_object(servants[1]), GroupId{5});

    constexpr OperationInfo ring_horn{&horn_interface, 0, "ring", false, true};
    call_through(group(one, 5), ring_horn);
    simulation.run_for(10ms);
    EXPECT_EQ(horn.calls, 1);
    EXPECT_EQ(servants[0].calls + servants[1].calls, 0);
    EXPECT_EQ(one.counters()[Counter::group_interface_mismatches], 1U);
    EXPECT_EQ(two.counters()[Counter::group_interface_mismatches], 1U);

    // The CRC of a base interface reaches all, and so does 0.
    constexpr OperationInfo ring_device{&device_interface, 0, "ring", false, true};
    call_through(group(one, 5), ring_device);
    group(one, 5).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(horn.calls, 3);
    EXPECT_EQ(servants[0].calls, 2);
    EXPECT_EQ(servants[1].calls, 2);
    ASSERT_EQ(seen.size(), 3U);
    EXPECT_EQ(seen[2].frame.data[5], 0);
    EXPECT_EQ(seen[2].frame.data[6], 0);
}

TEST_F(Groups, FailuresOfMembersAreCountedAndHarmNobody) {
    TestServant broken{{{0, [](ServerCall&) { throw std::runtime_error{"a bug"}; }}}};
    two.object_join(two.root_poa().activate_object(broken), GroupId{5});
    two.object_join(two.root_poa().activate_object(servants[0]), GroupId{5});
    group(one, 5).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(broken.calls, 1);
    EXPECT_EQ(servants[0].calls, 1);
    EXPECT_EQ(two.counters()[Counter::group_requests_failed], 1U);
    EXPECT_EQ(log.size(), 1U);
    EXPECT_EQ(seen.size(), 1U);  // nobody answers
}

class BasicCan : public World {
  protected:
    BasicCan() : World({.basic_can = true}) {}
};

// doc/wire/caniop.md: {1, 3, 5} gives a mask that 5 and 7 pass and 14 does not.
TEST_F(BasicCan, FalsePositivesAreDropped) {
    Orb sender{bus, node(1)};
    Orb receiver{bus, node(2)};
    TestServant servant{{{0, nothing}}};
    const ObjectRef self = receiver.root_poa().activate_object(servant);
    for (const GroupId member : {GroupId{1}, GroupId{3}, GroupId{5}}) {
        receiver.object_join(self, member);
    }
    for (const int number : {5, 7, 14}) group(sender, number).invoke(0, {});
    simulation.run_for(10ms);
    EXPECT_EQ(servant.calls, 1);
    EXPECT_EQ(receiver.counters()[Counter::frames_of_other_groups], 1U);
    EXPECT_EQ(receiver.counters()[Counter::frames_received], 1U);
}

}  // namespace
}  // namespace canorb::test
