// The management object: what it tells, octet by octet, and its pages at their edges.

#include <canorb/node.hpp>

#include <deque>

#include "tests/runtime/world.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr InterfaceInfo pump_interface{"IDL:T/P:1.0", {}, 0xF99F8D5E};
constexpr const InterfaceInfo* pump_bases[] = {&pump_interface};
constexpr InterfaceInfo fast_pump_interface{"IDL:T/FastP:1.0", pump_bases};

constexpr OperationId identity_operation = 0;
constexpr OperationId active_objects_operation = 2;
constexpr OperationId local_groups_operation = 3;
constexpr OperationId group_members_operation = 4;
constexpr OperationId counters_operation = 5;

class NodeObject : public World {
  protected:
    NodeObject() {
        OrbOptions options = node(3);
        options.name = "pump-3";
        options.vendor = "Acme";
        options.product = "P7";
        options.serial = 0x42;
        options.software_version = "1.2.3";
        options.boot_count = 300;
        server.emplace(bus, options);
    }

    Node node_3() { return at(client, 3, 0).narrow<Node>(); }

    std::string invoke(OperationId operation, std::string_view parameters) {
        return hex(at(client, 3, 0).invoke(operation, octets(parameters)));
    }

    /// A frame from something that is no ORB, to node 3.
    void send_to_3(const std::vector<std::uint8_t>& payload) {
        if (!stranger) stranger = bus.attach("stranger");
        const can::Frame frame = can::Frame::standard(0b1'00011'01001, payload);
        ASSERT_TRUE(std::holds_alternative<can::TransmitHandle>(stranger->send(frame)));
        simulation.run_for(1ms);
    }

    std::optional<Orb> server;
    Orb client{bus, node(1)};
    std::unique_ptr<can::Controller> stranger;
};

std::vector<ObjectIndex> indices(const Node::ActiveObjects& page) {
    std::vector<ObjectIndex> result;
    for (const Node::ActiveObject& object : page) result.push_back(object.index);
    return result;
}

std::vector<ObjectIndex> indices(const Node::MemberIndices& page) {
    return {page.begin(), page.end()};
}

// ---- what is on the bus

TEST_F(NodeObject, IsCalledLikeAnyObject) {
    const auto status = node_3().controller();
    EXPECT_EQ(status, (Node::ControllerStatus{Node::ControllerState::ERROR_ACTIVE, 0, 0}));

    // The last three frames; before them narrow() asked for the type.
    ASSERT_GE(seen.size(), 3U);
    const auto last = std::span{seen}.last(3);
    const std::string id = hex(last[0].frame.payload().subspan(3, 2));
    EXPECT_EQ(last[0].frame.id, 0b1'00011'00001U);
    // Request, object key: node 3, index 0; operation 6.
    EXPECT_EQ(hex(last[0].frame.payload()), "100005" + id + "180006");
    EXPECT_EQ(last[1].frame.id, 0b1'00001'00011U);
    // Reply, NO_EXCEPTION; ERROR_ACTIVE, TEC 0 | REC 0.
    EXPECT_EQ(hex(last[1].frame.payload()), "110006" + id + "000000");
    EXPECT_EQ(hex(last[2].frame.payload()), "8100");
}

TEST_F(NodeObject, TellsItsIdentity) {
    EXPECT_EQ(invoke(identity_operation, ""),
              "03"                // node
              "0770756D702D3300"  // "pump-3"
              "0541636D6500"      // "Acme"
              "03503700"          // "P7"
              "0000000000000042"  // serial
              "06312E322E3300"    // "1.2.3"
              "812C");            // 300 boots
    const Node::NodeIdentity identity = node_3().identity();
    EXPECT_EQ(identity, (Node::NodeIdentity{3, "pump-3", "Acme", "P7", 0x42, "1.2.3", 300}));
}

TEST_F(NodeObject, TellsAPageOfObjects) {
    TestServant pumps[] = {TestServant{{}, pump_interface}, TestServant{{}, lamp_interface}};
    server->root_poa().activate_object_with_id(1, pumps[0]);
    server->root_poa().activate_object(pumps[1]);
    EXPECT_EQ(invoke(active_objects_operation, "01 8080"),  // from 1, at most 128
              "02"                                          // objects
              "01"                                          // index 1
              "0C49444C3A542F503A312E3000"                  // "IDL:T/P:1.0"
              "F0F99F8D5E"                                  // its structural hash
              "8400"                                        // index 1024
              "1249444C3A546573742F4C616D703A312E3000"      // "IDL:Test/Lamp:1.0"
              "00");                                        // not known
}

TEST_F(NodeObject, TellsAPageOfGroups) {
    TestServant pumps[] = {TestServant{{}, pump_interface}, TestServant{{}, fast_pump_interface}};
    const auto slow = server->root_poa().activate_object_with_id(1, pumps[0]);
    const auto fast = server->root_poa().activate_object(pumps[1]);
    server->object_join(fast, GroupId{31});
    server->object_join(fast, GroupId{5});
    server->object_join(slow, GroupId{5});
    EXPECT_EQ(invoke(local_groups_operation, "00 02"),
              "02"                                  // groups
              "05"                                  // group 5
              "0C49444C3A542F503A312E3000"          // "IDL:T/P:1.0", what both are
              "02"                                  // members here
              "02018400"                            // 1, 1024
              "1F"                                  // group 31
              "1049444C3A542F46617374503A312E3000"  // "IDL:T/FastP:1.0"
              "01"                                  //
              "018400");                            // 1024
    EXPECT_EQ(invoke(group_members_operation, "05 02 80FF"), "018400");  // of group 5, from 2
}

TEST_F(NodeObject, TellsAPageOfCounters) {
    send_to_3({0x13, 0x00, 0x00});  // no message has type 3
    EXPECT_EQ(invoke(counters_operation, "14 01"),
              "01"                                        // counters
              "14"                                        // position 20
              "136D616C666F726D65645F6D6573736167657300"  // "malformed_messages"
              "0000000000000001");
}

// ---- what it says

TEST_F(NodeObject, IsOfItsType) {
    EXPECT_TRUE(at(client, 3, 0)._is_a("IDL:canorb/Node:1.0"));
    EXPECT_EQ(at(client, 3, 0)._interface_id(), "IDL:canorb/Node:1.0");
    EXPECT_FALSE(at(client, 3, 0)._non_existent());
    EXPECT_FALSE(node_3().is_nil());
    EXPECT_TRUE(at(client, 3, 0).narrow<Node>().canorb::ObjectRef::node() == NodeId{3});
}

TEST_F(NodeObject, IsReachedFromItsOwnNode) {
    EXPECT_EQ(at(*server, 3, 0).narrow<Node>().identity().name, "pump-3");
    EXPECT_THAT(seen, IsEmpty());
}

TEST_F(NodeObject, SaysNothingThatNobodyToldIt) {
    const Node::NodeIdentity identity = at(client, 1, 0).narrow<Node>().identity();
    EXPECT_EQ(identity, (Node::NodeIdentity{1, "node-1", "", "", 0, "", 0}));
}

TEST_F(NodeObject, CountsItsTime) {
    simulation.run_until(TimePoint{} + 100s);
    const std::uint64_t before = node_3().uptime_ms();
    simulation.run_for(86'400'000ms * 60);  // 60 days are more than 32 bits of milliseconds
    const std::uint64_t up = node_3().uptime_ms() - before;
    EXPECT_GE(up, 5'184'000'000U);
    EXPECT_LE(up, 5'184'010'000U);

    Orb late{bus, node(4)};
    EXPECT_LE(at(client, 4, 0).narrow<Node>().uptime_ms(), 10U);
}

TEST_F(NodeObject, TellsTheErrorStateOfItsController) {
    Simulation elsewhere;
    SimulatedBus& empty_bus = elsewhere.add_bus();
    Orb alone{empty_bus, node(7)};
    group(alone, 5).invoke(0, {});  // nobody acknowledges
    elsewhere.run_for(100ms);
    const auto status = at(alone, 7, 0).narrow<Node>().controller();
    EXPECT_EQ(status, (Node::ControllerStatus{Node::ControllerState::ERROR_PASSIVE, 128, 0}));
}

TEST_F(NodeObject, ListsItselfFirst) {
    TestServant lamp;
    server->root_poa().activate_object_with_id(7, lamp);
    const Node::ActiveObjects page = node_3().active_objects(0, 8);
    ASSERT_THAT(indices(page), ElementsAre(0, 7));
    EXPECT_EQ(page[0].type_id, "IDL:canorb/Node:1.0");
    EXPECT_EQ(page[0].structural_hash, NodeInterface.structural_hash);
    EXPECT_NE(page[0].structural_hash, 0U);

    server->root_poa().deactivate_object(7);
    EXPECT_THAT(indices(node_3().active_objects(0, 8)), ElementsAre(0));
}

TEST_F(NodeObject, PagesOfObjectsHaveEdges) {
    std::deque<TestServant> lamps(10);
    std::vector<ObjectIndex> all{0};
    for (ObjectIndex i = 0; i < 9; ++i) {
        const auto index = static_cast<ObjectIndex>(100 * i + 1);
        server->root_poa().activate_object_with_id(index, lamps[i]);
        all.push_back(index);
    }
    server->root_poa().activate_object(lamps[9]);
    all.push_back(1024);

    const Node node = node_3();
    std::vector<ObjectIndex> listed;
    std::vector<std::size_t> sizes;
    for (ObjectIndex first = 0;;) {
        const auto page = indices(node.active_objects(first, 65535));
        sizes.push_back(page.size());
        if (page.empty()) break;
        listed.insert(listed.end(), page.begin(), page.end());
        first = static_cast<ObjectIndex>(listed.back() + 1);
    }
    EXPECT_EQ(listed, all);
    EXPECT_THAT(sizes, ElementsAre(8, 3, 0));

    EXPECT_THAT(node.active_objects(0, 0), IsEmpty());
    EXPECT_THAT(node.active_objects(5, 0), IsEmpty());
    EXPECT_THAT(indices(node.active_objects(0, 1)), ElementsAre(0));
    EXPECT_THAT(indices(node.active_objects(1, 1)), ElementsAre(1));
    EXPECT_THAT(indices(node.active_objects(2, 2)), ElementsAre(101, 201));
    EXPECT_THAT(node.active_objects(0, 8), SizeIs(8));
    EXPECT_THAT(node.active_objects(0, 9), SizeIs(8));
    for (const int beyond : {1025, 2047, 2048, 65535}) {
        EXPECT_THAT(node.active_objects(static_cast<ObjectIndex>(beyond), 8), IsEmpty()) << beyond;
    }
}

TEST_F(NodeObject, ListsTheVeryLastObject) {
    std::deque<TestServant> lamps(1024);
    for (TestServant& lamp : lamps) server->root_poa().activate_object(lamp);
    EXPECT_THAT(indices(node_3().active_objects(2046, 8)), ElementsAre(2046, 2047));
    EXPECT_THAT(indices(node_3().active_objects(2047, 8)), ElementsAre(2047));
}

TEST_F(NodeObject, PagesOfGroupsHaveEdges) {
    TestServant lamp;
    const auto self = server->root_poa().activate_object_with_id(1, lamp);
    const Node node = node_3();
    EXPECT_THAT(node.local_groups(0, 8), IsEmpty());
    for (int i = 31; i > 20; --i) server->object_join(self, GroupId{static_cast<std::uint8_t>(i)});

    const auto numbers = [&](Node::GroupNumber first, std::uint16_t max) {
        std::vector<int> result;
        for (const auto& group : node.local_groups(first, max)) result.push_back(group.number);
        return result;
    };
    EXPECT_THAT(numbers(0, 65535), ElementsAre(21, 22, 23, 24, 25, 26, 27, 28));
    EXPECT_THAT(numbers(29, 8), ElementsAre(29, 30, 31));
    EXPECT_THAT(numbers(31, 8), ElementsAre(31));
    EXPECT_THAT(numbers(22, 1), ElementsAre(22));
    EXPECT_THAT(numbers(0, 0), IsEmpty());
    EXPECT_THAT(numbers(32, 8), IsEmpty());
    EXPECT_THAT(numbers(255, 8), IsEmpty());

    server->object_leave(self, GroupId{21});
    EXPECT_THAT(numbers(0, 2), ElementsAre(22, 23));
}

TEST_F(NodeObject, PagesOfMembersHaveEdges) {
    std::deque<TestServant> lamps(40);
    std::vector<ObjectRef> references;
    for (ObjectIndex i = 0; i < 40; ++i) {
        const auto index = static_cast<ObjectIndex>(i + 1);
        references.push_back(server->root_poa().activate_object_with_id(index, lamps[i]));
    }
    // The order of joining is not that of the page.
    for (auto one = references.rbegin(); one != references.rend(); ++one) {
        server->object_join(*one, GroupId{5});
    }

    const Node node = node_3();
    const Node::LocalGroups groups = node.local_groups(5, 1);
    ASSERT_THAT(groups, SizeIs(1));
    EXPECT_EQ(groups[0].member_count, 40);
    ASSERT_THAT(groups[0].members, SizeIs(32));
    EXPECT_EQ(groups[0].members.front(), 1);
    EXPECT_EQ(groups[0].members.back(), 32);

    EXPECT_EQ(node.group_members(5, 0, 65535), groups[0].members);
    EXPECT_THAT(indices(node.group_members(5, 33, 32)),
                ElementsAre(33, 34, 35, 36, 37, 38, 39, 40));
    EXPECT_THAT(indices(node.group_members(5, 40, 8)), ElementsAre(40));
    EXPECT_THAT(indices(node.group_members(5, 3, 1)), ElementsAre(3));
    for (const int beyond : {41, 2047, 65535}) {
        EXPECT_THAT(node.group_members(5, static_cast<ObjectIndex>(beyond), 8), IsEmpty())
            << beyond;
    }
    EXPECT_THAT(node.group_members(5, 0, 0), IsEmpty());
    EXPECT_THAT(node.group_members(6, 0, 8), IsEmpty());
    EXPECT_THAT(node.group_members(1, 0, 8), IsEmpty());
    EXPECT_THAT(node.group_members(31, 0, 8), IsEmpty());
    for (const int none : {0, 32, 255}) {
        EXPECT_EQ(
            error_of([&] {
                static_cast<void>(node.group_members(static_cast<Node::GroupNumber>(none), 0, 8));
            }),
            (SystemError{SystemErrorKind::bad_param, Completion::no, 25}))
            << none;
    }
}

TEST_F(NodeObject, PagesOfCountersHaveEdges) {
    const Node node = node_3();
    std::vector<std::string> names;
    for (std::uint16_t first = 0;;) {
        const Node::NamedCounters page = node.counters(first, 65535);
        if (page.empty()) break;
        EXPECT_LE(page.size(), Node::COUNTERS_PER_PAGE);
        for (const Node::NamedCounter& counter : page) {
            EXPECT_EQ(counter.position, names.size());
            names.emplace_back(counter.name.view());
        }
        first = static_cast<std::uint16_t>(page.back().position + 1);
    }
    ASSERT_THAT(names, SizeIs(counter_count));
    for (std::size_t i = 0; i < counter_count; ++i) {
        EXPECT_EQ(names[i], name(static_cast<Counter>(i)));
    }

    const auto last = static_cast<std::uint16_t>(counter_count - 1);
    EXPECT_THAT(node.counters(0, 0), IsEmpty());
    EXPECT_THAT(node.counters(0, 1), SizeIs(1));
    EXPECT_THAT(node.counters(0, 17), SizeIs(16));
    EXPECT_THAT(node.counters(last, 16), SizeIs(1));
    EXPECT_THAT(node.counters(static_cast<std::uint16_t>(last + 1), 16), IsEmpty());
    EXPECT_THAT(node.counters(65535, 16), IsEmpty());
}

TEST_F(NodeObject, CountsWhatWasDropped) {
    send_to_3({0x13, 0x00, 0x00});                                   // malformed
    send_to_3({0x13, 0x00, 0x00});                                   // and its answer suppressed
    send_to_3({0x81, 0x01});                                         // nothing to continue
    send_to_3({0x10, 0x00, 0x20, 0x00, 0x01, 0x18, 0x01, 0x00});     // 35 octets, of which
    send_to_3({0x83, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07});     // the second frame is missing
    send_to_3({0x10, 0x00});                                         // no whole header
    EXPECT_THROW(at(client, 3, 9).invoke(0, {}), OBJECT_NOT_EXIST);  // refused

    std::map<std::string, std::uint64_t> counted;
    for (std::uint16_t first = 0; first < counter_count; ++first) {
        for (const auto& counter : node_3().counters(first, 1)) {
            counted[std::string{counter.name.view()}] = counter.value;
        }
    }
    EXPECT_EQ(counted.size(), counter_count);
    EXPECT_EQ(counted["malformed_messages"], 2U);
    EXPECT_EQ(counted["message_errors_sent"], 1U);
    EXPECT_EQ(counted["message_errors_suppressed"], 1U);
    EXPECT_EQ(counted["continuations_without_message"], 1U);
    EXPECT_EQ(counted["sequence_errors"], 1U);
    EXPECT_EQ(counted["short_first_frames"], 1U);
    EXPECT_EQ(counted["requests_refused"], 1U);
    EXPECT_EQ(counted["duplicate_requests"], 0U);
    EXPECT_GE(counted["frames_received"], 6U);
    EXPECT_LE(counted["frames_received"], server->counters()[Counter::frames_received]);
}

TEST_F(NodeObject, KeepsItsPagesBelowTheLimitOfMessages) {
    const std::string longest = "IDL:" + std::string(247, 'x') + ":1.0";
    const std::string longer = longest + "0";
    const InterfaceInfo fits{longest};
    const InterfaceInfo too_long{longer};
    ASSERT_EQ(longest.size(), 255U);
    std::deque<TestServant> servants;
    for (int i = 0; i < 7; ++i)
        servants.emplace_back(std::map<OperationId, TestServant::Operation>{}, fits);
    servants.emplace_back(std::map<OperationId, TestServant::Operation>{}, too_long);
    std::vector<ObjectRef> references;
    for (TestServant& servant : servants) {
        references.push_back(server->root_poa().activate_object(servant));
    }
    for (std::uint8_t i = 1; i <= 8; ++i) server->object_join(references[0], GroupId{i});

    const Node node = node_3().with_timeout(5s);
    const Node::ActiveObjects objects = node.active_objects(1, 8);
    ASSERT_THAT(objects, SizeIs(8));
    EXPECT_EQ(objects[0].type_id, longest);
    EXPECT_EQ(objects[7].type_id, "");  // half a repository id would be another one
    EXPECT_EQ(references[7].type_id(), longer);
    ASSERT_THAT(node.local_groups(1, 8), SizeIs(8));
}

// ---- whose it is

TEST_F(NodeObject, IsNoObjectOfAnyPoa) {
    const ObjectRef self = at(*server, 3, 0);
    TestServant lamp;
    EXPECT_THROW(server->root_poa().activate_object_with_id(0, lamp), BAD_PARAM);
    EXPECT_THROW(server->root_poa().deactivate_object(0), ObjectNotActive);
    EXPECT_THROW(server->root_poa().id_to_servant(0), ObjectNotActive);
    EXPECT_THROW(server->root_poa().id_to_reference(0), ObjectNotActive);
    EXPECT_THAT(what<BAD_PARAM>([&] { server->object_join(self, GroupId{5}); }),
                HasSubstr("the node's management object is a member of no group"));
    EXPECT_FALSE(server->object_is_member(self, GroupId{5}));
    server->object_leave(self, GroupId{5});
    EXPECT_THAT(server->group_members(GroupId{5}), IsEmpty());
    EXPECT_FALSE(at(client, 3, 0)._non_existent());
}

TEST_F(NodeObject, CanBeLeftOff) {
    OrbOptions options = node(4);
    options.management_object = false;
    Orb without{bus, options};
    TestServant lamp{{{0, nothing}}};
    without.root_poa().activate_object_with_id(1, lamp);
    EXPECT_EQ(error_of([&] { at(client, 4, 0).invoke(identity_operation, {}); }),
              (SystemError{SystemErrorKind::object_not_exist, Completion::no, 16}));
    EXPECT_TRUE(at(client, 4, 0)._non_existent());
    EXPECT_EQ(without.counters()[Counter::requests_refused], 2U);
    at(client, 4, 1).invoke(0, {});
    EXPECT_EQ(lamp.calls, 1);
}

TEST_F(NodeObject, IsThereOnceTheNodeHasANumber) {
    Orb unnumbered{bus, node(std::nullopt)};
    EXPECT_THROW(at(client, 9, 0).with_timeout(10ms)._is_a("x"), TIMEOUT);
    unnumbered.set_node(9);
    EXPECT_EQ(at(client, 9, 0).narrow<Node>().identity(),
              (Node::NodeIdentity{9, "node", "", "", 0, "", 0}));
    unnumbered.set_node(10);
    EXPECT_EQ(at(client, 10, 0).narrow<Node>().identity().node, 10);
}

TEST_F(NodeObject, RefusesWhatItDoesNotKnow) {
    const ObjectRef object = at(client, 3, 0);
    EXPECT_EQ(error_of([&] { object.invoke(8, {}); }).kind, SystemErrorKind::bad_operation);
    EXPECT_EQ(error_of([&] { object.invoke(active_objects_operation, octets("00")); }),
              (SystemError{SystemErrorKind::marshal, Completion::no, 20}));
    EXPECT_EQ(error_of([&] { object.invoke(identity_operation, octets("00")); }),
              (SystemError{SystemErrorKind::marshal, Completion::no, 20}));
}

TEST_F(NodeObject, RefusesIdentitiesThatItCouldNotTell) {
    const auto refusal = [&](const std::function<void(OrbOptions&)>& change) {
        OrbOptions options = node(5);
        change(options);
        return what<BAD_PARAM>([&] { const Orb orb{bus, options}; });
    };
    const std::string longest(32, 'x');
    const std::string longer(33, 'x');
    EXPECT_THAT(refusal([&](auto& o) { o.vendor = longer; }),
                HasSubstr("vendor '" + longer + "' is longer than 32 characters"));
    EXPECT_THAT(refusal([&](auto& o) { o.product = longer; }), HasSubstr("product 'xx"));
    EXPECT_THAT(refusal([&](auto& o) { o.software_version = longer; }),
                HasSubstr("software_version 'xx"));
    EXPECT_THAT(refusal([&](auto& o) { o.vendor = std::string{"a\0b", 3}; }),
                HasSubstr("vendor has a NUL in it"));
    EXPECT_THAT(refusal([&](auto& o) { o.name = std::string{"a\0b", 3}; }),
                HasSubstr("the node's name has a NUL in it"));

    OrbOptions options = node(5);
    options.name = "sixteen letters.";
    options.vendor = options.product = options.software_version = longest;
    options.serial = 0xFFFFFFFFFFFFFFFF;
    options.boot_count = 0xFFFFFFFF;
    Orb orb{bus, options};
    EXPECT_EQ(at(client, 5, 0).narrow<Node>().identity(),
              (Node::NodeIdentity{5, "sixteen letters.", longest, longest, 0xFFFFFFFFFFFFFFFF,
                                  longest, 0xFFFFFFFF}));
}

}  // namespace
}  // namespace canorb::test
