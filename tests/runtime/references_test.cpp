// References: their strings, narrowing, nil, and those that outlive their Orb.

#include <sstream>

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

struct Lamp : ObjectRef {
    static constexpr const InterfaceInfo& _interface = lamp_interface;
    Lamp() = default;
    explicit Lamp(const ObjectRef& reference) : ObjectRef(reference) {}
};
struct Device : ObjectRef {
    static constexpr const InterfaceInfo& _interface = device_interface;
    Device() = default;
    explicit Device(const ObjectRef& reference) : ObjectRef(reference) {}
};
struct Horn : ObjectRef {
    static constexpr const InterfaceInfo& _interface = horn_interface;
    Horn() = default;
    explicit Horn(const ObjectRef& reference) : ObjectRef(reference) {}
};

class References : public World {
  protected:
    References() { self = server.root_poa().activate_object_with_id(1, servant); }

    Orb server{bus, node(3)};
    Orb client{bus, node(5)};
    TestServant servant{{{0, nothing}}};
    ObjectRef self;
};

TEST_F(References, GoToStringsAndBack) {
    // String of 18 octets, profile 0, object reference, node 3, key 0x1801.
    EXPECT_EQ(server.object_to_string(self),
              "CAN_IOR:1249444c3a546573742f4c616d703a312e30000000031801");
    const ObjectRef there = client.string_to_object(server.object_to_string(self));
    EXPECT_EQ(there, self);
    EXPECT_EQ(there.type_id(), "IDL:Test/Lamp:1.0");
    EXPECT_EQ(there.node(), NodeId{3});
    EXPECT_EQ(there.index(), ObjectIndex{1});
    EXPECT_FALSE(there.group());
    there.invoke(0, {});
    EXPECT_EQ(servant.calls, 1);

    const ObjectRef nil = client.string_to_object("CAN_IOR:0100FF");
    EXPECT_TRUE(nil.is_nil());
    EXPECT_EQ(client.object_to_string(nil), "CAN_IOR:0100ff");
    EXPECT_TRUE(group(client, 31).is_group());
    EXPECT_EQ(group(client, 31).group(), GroupId{31});
    EXPECT_EQ(at(client, 30, 2047).index(), ObjectIndex{2047});
}

TEST_F(References, NonsenseSaysWhy) {
    const auto bad_param = [&](std::string_view text) {
        return what<BAD_PARAM>([&] { client.string_to_object(text); });
    };
    const auto inv_objref = [&](std::string_view text) {
        return what<INV_OBJREF>([&] { client.string_to_object(text); });
    };
    using testing::HasSubstr;
    EXPECT_THAT(bad_param("nonsense"), HasSubstr("'nonsense': a reference begins with CAN_IOR: or "
                                                 "corbaloc:caniop:"));
    bad_param("");
    bad_param("IOR:00");
    EXPECT_THAT(bad_param("corbaloc:caniop:31/1"), HasSubstr("the node is not a number from 0 to "
                                                             "30"));
    bad_param("corbaloc:caniop:3");
    bad_param("corbaloc:caniop:/1");
    bad_param("corbaloc:caniop:+3/1");
    EXPECT_THAT(bad_param("corbaloc:caniop:3/2048"), HasSubstr("0 to 2047"));
    bad_param("corbaloc:caniop:3/1x");
    EXPECT_THAT(bad_param("corbaloc:caniop:group/0"), HasSubstr("1 to 31"));
    bad_param("corbaloc:caniop:group/32");
    inv_objref("CAN_IOR:");
    inv_objref("CAN_IOR:0");
    inv_objref("CAN_IOR:zz");
    inv_objref("CAN_IOR:0100ff00");
    inv_objref("CAN_IOR:0100000000031f01");  // another node in the key
    inv_objref(
        "CAN_IOR:01000001"
        "20");  // group 32
}

TEST_F(References, NarrowAsksOnlyWhereTheTypeIsNotKnown) {
    const ObjectRef known = client.string_to_object(server.object_to_string(self));
    EXPECT_FALSE(known.narrow<Lamp>().is_nil());
    EXPECT_TRUE(seen.empty());
    EXPECT_FALSE(known.narrow<Device>().is_nil());  // is it? only the object knows
    EXPECT_FALSE(seen.empty());
    EXPECT_TRUE(known.narrow<Horn>().is_nil());
    EXPECT_FALSE(at(client, 3, 1).narrow<Lamp>().is_nil());
    EXPECT_TRUE(at(client, 3, 1).narrow<Horn>().is_nil());
    EXPECT_THROW(at(client, 3, 2).narrow<Lamp>(), OBJECT_NOT_EXIST);
    EXPECT_THROW(at(client, 9, 1).with_timeout(5ms).narrow<Lamp>(), TIMEOUT);
    EXPECT_TRUE(ObjectRef{}.narrow<Lamp>().is_nil());
    EXPECT_FALSE(at(client, 9, 1).unchecked_narrow<Lamp>().is_nil());
}

TEST_F(References, NarrowTrustsAGroup) {
    server.object_join(self, GroupId{5});
    const ObjectRef lamps = client.string_to_object(server.group_to_string(GroupId{5}));
    EXPECT_FALSE(lamps.narrow<Lamp>().is_nil());
    EXPECT_TRUE(lamps.narrow<Horn>().is_nil());
    EXPECT_FALSE(group(client, 5).narrow<Lamp>().is_nil());
    EXPECT_FALSE(group(client, 5).narrow<Horn>().is_nil());
    EXPECT_TRUE(seen.empty());
}

TEST_F(References, NilAndUnboundOnesRefuseCalls) {
    EXPECT_THAT(what<INV_OBJREF>([] { ObjectRef{}.invoke(0, {}); }),
                "INV_OBJREF (completed NO, minor 34): the reference is nil: invoke");
    EXPECT_THROW(static_cast<void>(ObjectRef{}._is_a("IDL:Test/Lamp:1.0")), INV_OBJREF);
    EXPECT_EQ(ObjectRef{}, client.string_to_object("CAN_IOR:0100ff"));
    EXPECT_FALSE(ObjectRef{} == self);
}

TEST_F(References, OutliveTheirOrb) {
    ObjectRef orphan;
    bool sent = false;
    {
        Orb gone{bus, node(6)};
        orphan = at(gone, 3, 1);
        orphan.invoke(0, {});
        // A callback that holds a reference does not keep the ORB alive.
        gone.every(1s, [orphan] { orphan.invoke(0, {}); });
        gone.on_event([orphan](const Event&) {});
    }
    EXPECT_THAT(what<BAD_INV_ORDER>([&] { orphan.invoke(0, {}); }),
                "BAD_INV_ORDER (completed NO, minor 38): the Orb is gone");
    EXPECT_THROW(orphan.with_sent([&] { sent = true; }).invoke(0, {}), BAD_INV_ORDER);
    EXPECT_EQ(orphan, self);
    EXPECT_FALSE(sent);
    simulation.run_for(5s);
    EXPECT_EQ(servant.calls, 1);
}

TEST_F(References, InAnAnyOutliveTheOrbThatReceivedThem) {
    Any received;
    {
        Orb gone{bus, node(6)};
        TestServant keeper{{{0, [&](ServerCall& call) {
                                 if (call.read(received)) call.reply();
                             }}}};
        gone.root_poa().activate_object_with_id(1, keeper);
        Any any;
        any <<= self;
        std::vector<std::uint8_t> buffer(200);
        ccdr::Encoder out{buffer};
        encode(out, any);
        at(client, 6, 1).invoke(0, out.octets());
        ObjectRef there;
        ASSERT_TRUE(received >>= there);
        EXPECT_EQ(there, self);
        there.invoke(0, {});
        EXPECT_EQ(servant.calls, 1);
    }
    ObjectRef orphan;
    ASSERT_TRUE(received >>= orphan);
    EXPECT_EQ(orphan, self);
    EXPECT_THAT(what<BAD_INV_ORDER>([&] { orphan.invoke(0, {}); }),
                "BAD_INV_ORDER (completed NO, minor 38): the Orb is gone");
}

TEST_F(References, ComeOutOfAnAnyAsTheyWentIn) {
    Any any;
    any <<= std::vector{at(client, 3, 1)};
    std::vector<ObjectRef> taken;
    ASSERT_TRUE(any >>= taken);
    taken.at(0).invoke(0, {});
    EXPECT_EQ(servant.calls, 1);
}

TEST_F(References, Print) {
    std::ostringstream out;
    out << ObjectRef{} << ", " << self << ", " << group(client, 5) << ", " << at(client, 30, 7);
    EXPECT_EQ(out.str(), "nil, node 3 object 1 IDL:Test/Lamp:1.0, group 5, node 30 object 7");
}

TEST_F(References, ActivationKeepsTheIndices) {
    TestServant more[3];
    EXPECT_EQ(server.root_poa().activate_object(more[0]).index(), ObjectIndex{1024});
    EXPECT_EQ(server.root_poa().activate_object(more[1]).index(), ObjectIndex{1025});
    EXPECT_THROW(server.root_poa().activate_object(more[0]), ServantAlreadyActive);
    EXPECT_THROW(server.root_poa().activate_object_with_id(1, more[2]), ObjectAlreadyActive);
    EXPECT_THROW(server.root_poa().activate_object_with_id(2, servant), ServantAlreadyActive);
    for (const ObjectIndex index : std::initializer_list<ObjectIndex>{0, 1030, 5000}) {
        EXPECT_THAT(
            what<BAD_PARAM>([&] { server.root_poa().activate_object_with_id(index, more[2]); }),
            testing::HasSubstr("object index " + std::to_string(index) + " is not 1 to 1023"));
    }
    server.root_poa().deactivate_object(1025);
    EXPECT_THROW(server.root_poa().deactivate_object(1025), ObjectNotActive);
    EXPECT_EQ(server.root_poa().activate_object(more[1]).index(), ObjectIndex{1026});
}

}  // namespace
}  // namespace canorb::test
