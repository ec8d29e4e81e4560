// Child POAs, their policies, POA managers, and what a POA knows of its servants.

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Poas : public World {
  protected:
    Orb server{bus, node(3)};
    Orb client{bus, node(4)};
    TestServant lamp{{{0, nothing}, {1, echo}}};
    TestServant other{{{0, nothing}}};

    Poa& root() { return server.root_poa(); }
    Poa& child(const PoaPolicies& policies, PoaManager* manager) {
        return root().create_POA("child", manager, policies);
    }
    static constexpr PoaPolicies user_ids{.id_assignment = IdAssignmentPolicy::user_id};

    /// Rings, and returns how that ended.
    std::string ring_object(int index) {
        try {
            at(client, 3, index).with_timeout(20ms).invoke(0, {});
        } catch (const SystemException& exception) {
            return std::string{name(exception.error().kind)} + ' ' +
                   std::string{name(exception.completed())} + ' ' +
                   std::to_string(exception.minor());
        }
        return "rang";
    }
};

TEST_F(Poas, TheTree) {
    EXPECT_EQ(root().the_name(), "RootPOA");
    EXPECT_EQ(root().the_parent(), nullptr);
    Poa& a = root().create_POA("a", nullptr);
    Poa& b = a.create_POA("b", &a.the_POAManager(), user_ids);
    EXPECT_EQ(&root().find_POA("a"), &a);
    EXPECT_EQ(&a.find_POA("b"), &b);
    EXPECT_EQ(b.the_parent(), &a);
    EXPECT_EQ(root().the_children(), std::vector<Poa*>{&a});
    EXPECT_EQ(b.policies(), user_ids);
    EXPECT_EQ(&b.the_POAManager(), &a.the_POAManager());
    EXPECT_NE(&a.the_POAManager(), &root().the_POAManager());
    EXPECT_EQ(a.the_POAManager().get_state(), PoaManagerState::holding);
    EXPECT_EQ(root().the_POAManager().get_state(), PoaManagerState::active);
    EXPECT_THROW(root().create_POA("a", nullptr), AdapterAlreadyExists);
    EXPECT_THROW(root().find_POA("b"), AdapterNonExistent);
    EXPECT_THROW(client.root_poa().create_POA("x", &a.the_POAManager()), BAD_PARAM);
}

TEST_F(Poas, PersistentNeedsUserId) {
    try {
        root().create_POA("keys", nullptr, {.lifespan = LifespanPolicy::persistent});
        FAIL();
    } catch (const InvalidPolicy& exception) {
        EXPECT_EQ(exception.index, 0);
        EXPECT_STREQ(
            exception.what(),
            "PERSISTENT needs USER_ID: the system's ids are other objects after a restart");
        EXPECT_EQ(exception._repository_id(), "IDL:omg.org/PortableServer/POA/InvalidPolicy:1.0");
    }
    EXPECT_TRUE(root().the_children().empty());
}

TEST_F(Poas, APersistentKeyIsTheSameAfterARestart) {
    const auto start = [&](Orb& orb) {
        Poa& poa = orb.root_poa().create_POA(
            "pumps", &orb.root_poa().the_POAManager(),
            {.lifespan = LifespanPolicy::persistent, .id_assignment = IdAssignmentPolicy::user_id});
        return orb.object_to_string(poa.activate_object_with_id(12, lamp));
    };
    std::string before;
    {
        Orb first{bus, node(5)};
        before = start(first);
    }
    const ObjectRef kept = client.string_to_object(before);
    EXPECT_THROW(kept.with_timeout(10ms).invoke(0, {}), TIMEOUT);
    Orb second{bus, node(5)};
    EXPECT_EQ(start(second), before);
    kept.invoke(0, {});
    EXPECT_EQ(lamp.calls, 1);
}

TEST_F(Poas, AnIdOfTheSystemIsNotUsedAgainByItself) {
    Poa& a = child({}, &root().the_POAManager());
    EXPECT_EQ(a.activate_object(lamp).index(), 1024);
    a.deactivate_object(1024);
    EXPECT_EQ(a.activate_object(lamp).index(), 1025);
    EXPECT_EQ(ring_object(1024), "OBJECT_NOT_EXIST NO 16");
    // Whoever has the reference may still put the object back.
    EXPECT_EQ(a.activate_object_with_id(1024, other).index(), 1024);
    EXPECT_EQ(ring_object(1024), "rang");
}

TEST_F(Poas, ExceptionsAreNamedAsInCorba) {
    Poa& users = child(user_ids, &root().the_POAManager());
    EXPECT_THROW(users.activate_object(lamp), WrongPolicy);
    EXPECT_THROW(users.create_reference("IDL:X:1.0"), WrongPolicy);
    EXPECT_EQ(what<BAD_PARAM>([&] { users.activate_object_with_id(1024, lamp); }),
              "BAD_PARAM (completed NO, minor 25): an argument is out of range: object index 1024 "
              "is not 1 to 1023");
    EXPECT_THROW(users.servant_to_id(lamp), ServantNotActive);
    users.activate_object_with_id(5, lamp);
    EXPECT_THROW(users.activate_object_with_id(5, other), ObjectAlreadyActive);
    EXPECT_THROW(root().activate_object_with_id(5, other), ObjectAlreadyActive);
    EXPECT_THROW(users.activate_object_with_id(6, lamp), ServantAlreadyActive);
    EXPECT_THROW(users.deactivate_object(6), ObjectNotActive);
    EXPECT_THROW(root().deactivate_object(5), ObjectNotActive);
    EXPECT_THROW(root().id_to_servant(5), ObjectNotActive);
    EXPECT_THROW(users.id_to_reference(6), ObjectNotActive);
    EXPECT_THROW(root().reference_to_id(at(server, 3, 5)), WrongAdapter);
    EXPECT_THROW(users.reference_to_id(at(server, 4, 5)), WrongAdapter);
    EXPECT_THROW(users.reference_to_id(group(server, 5)), WrongAdapter);
    EXPECT_THROW(users.reference_to_id(ObjectRef{}), WrongAdapter);
    EXPECT_EQ(ObjectNotActive{}._repository_id(),
              "IDL:omg.org/PortableServer/POA/ObjectNotActive:1.0");
    EXPECT_STREQ(AdapterInactive{}.what(),
                 "IDL:omg.org/PortableServer/POAManager/AdapterInactive:1.0");
}

TEST_F(Poas, FromServantToIdAndBack) {
    Poa& users = child(user_ids, &root().the_POAManager());
    const ObjectRef reference = users.activate_object_with_id(5, lamp);
    EXPECT_EQ(users.servant_to_id(lamp), 5);
    EXPECT_EQ(users.servant_to_reference(lamp), reference);
    EXPECT_EQ(users.servant_to_reference(lamp).type_id(), "IDL:Test/Lamp:1.0");
    EXPECT_EQ(&users.id_to_servant(5), &lamp);
    EXPECT_EQ(users.id_to_reference(5), reference);
    EXPECT_EQ(users.reference_to_id(reference), 5);
    EXPECT_EQ(&users.reference_to_servant(reference), &lamp);
    users.deactivate_object(5);
    EXPECT_EQ(users.reference_to_id(reference), 5);
    EXPECT_THROW(users.reference_to_servant(reference), ObjectNotActive);
}

TEST_F(Poas, ImplicitActivation) {
    EXPECT_EQ(root().servant_to_id(lamp), 1024);
    EXPECT_EQ(root().servant_to_id(lamp), 1024);
    EXPECT_EQ(ring_object(1024), "rang");
    Poa& many = child({.id_uniqueness = IdUniquenessPolicy::multiple_id}, &root().the_POAManager());
    // Each time another object, as CORBA has it.
    EXPECT_EQ(many.servant_to_id(lamp), 1025);
    EXPECT_EQ(many.servant_to_reference(lamp).index(), 1026);
    EXPECT_EQ(ring_object(1026), "rang");
    Poa& neither = root().create_POA("neither", nullptr,
                                     {.id_uniqueness = IdUniquenessPolicy::multiple_id,
                                      .id_assignment = IdAssignmentPolicy::user_id});
    EXPECT_THROW(neither.servant_to_id(lamp), WrongPolicy);
}

TEST_F(Poas, AReferenceMayBeThereBeforeItsObject) {
    const ObjectRef reference = root().create_reference("IDL:Test/Lamp:1.0");
    EXPECT_EQ(reference.index(), 1024);
    EXPECT_EQ(reference.type_id(), "IDL:Test/Lamp:1.0");
    EXPECT_EQ(ring_object(1024), "OBJECT_NOT_EXIST NO 16");
    EXPECT_EQ(root().activate_object_with_id(1024, lamp), reference);
    EXPECT_EQ(ring_object(1024), "rang");
    EXPECT_EQ(root().create_reference_with_id(9, "IDL:Test/Lamp:1.0").index(), 9);
    EXPECT_THROW(root().create_reference_with_id(0, "IDL:Test/Lamp:1.0"), BAD_PARAM);
    EXPECT_THROW(root().create_reference_with_id(1025, "IDL:Test/Lamp:1.0"), BAD_PARAM);
}

TEST_F(Poas, DestroyTakesObjectsOutOfServiceAndOutOfGroups) {
    Poa& a = child(user_ids, &root().the_POAManager());
    Poa& below = a.create_POA("below", &root().the_POAManager(), user_ids);
    server.object_join(a.activate_object_with_id(1, lamp), GroupId{5});
    server.object_join(below.activate_object_with_id(2, other), GroupId{5});
    a.destroy(true);
    EXPECT_TRUE(server.group_members(GroupId{5}).empty());
    EXPECT_EQ(ring_object(1), "OBJECT_NOT_EXIST NO 16");
    EXPECT_EQ(ring_object(2), "OBJECT_NOT_EXIST NO 16");
    EXPECT_EQ(what<OBJECT_NOT_EXIST>([&] { below.activate_object_with_id(2, other); }),
              "OBJECT_NOT_EXIST (completed NO, minor 47): the POA was destroyed: POA 'below'");
    EXPECT_EQ(a.the_name(), "child");
    Poa& again = child(user_ids, &root().the_POAManager());
    again.activate_object_with_id(1, lamp);
    EXPECT_EQ(ring_object(1), "rang");
}

// ---- POA managers

class Managers : public Poas {
  protected:
    Poa& poa = child(user_ids, nullptr);
    PoaManager& manager = poa.the_POAManager();

    Managers() { poa.activate_object_with_id(1, lamp); }
};

TEST_F(Managers, HeldRequestsWaitForActivate) {
    simulation.at(TimePoint{5ms}, [&] { manager.activate(); });
    at(client, 3, 1).invoke(0, {});
    EXPECT_GE(simulation.now(), TimePoint{5ms});
    EXPECT_EQ(lamp.calls, 1);
}

TEST_F(Managers, OnlyThoseThatAreHeldWait) {
    root().activate_object_with_id(2, other);
    EXPECT_EQ(ring_object(1), "TIMEOUT MAYBE 2");
    EXPECT_EQ(ring_object(2), "rang");
    EXPECT_EQ(lamp.calls, 0);
    // Nobody waits for it any more, but the server cannot know.
    manager.activate();
    simulation.run_for(5ms);
    EXPECT_EQ(lamp.calls, 1);
    EXPECT_EQ(client.counters()[Counter::unmatched_replies], 1U);
}

TEST_F(Managers, HeldRequestsGoOnInTheirOrder) {
    std::vector<std::uint8_t> order;
    TestServant recorder{{{0, [&](ServerCall& call) {
                               order.push_back(call.remaining_parameters()[0]);
                               call.reply();
                           }}}};
    poa.activate_object_with_id(2, recorder);
    for (std::uint8_t i = 0; i < 10; ++i) {
        const std::uint8_t parameters[] = {i};
        call_through(at(client, 3, 2), ring_oneway, parameters);
    }
    simulation.run_for(20ms);
    EXPECT_TRUE(order.empty());
    manager.activate();
    simulation.run_for(5ms);
    EXPECT_EQ(order, (std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST_F(Managers, TheBoundedQueueIsFullAfter64) {
    for (int i = 0; i < 32; ++i) call_through(at(client, 3, 1), ring_oneway);
    simulation.run_for(50ms);
    for (int i = 0; i < 32; ++i) call_through(at(client, 3, 1), ring_oneway);
    simulation.run_for(50ms);
    EXPECT_EQ(ring_object(1), "TRANSIENT NO 45");
    EXPECT_EQ(server.counters()[Counter::requests_refused], 1U);
    manager.activate();
    simulation.run_for(50ms);
    EXPECT_EQ(lamp.calls, 64);
    EXPECT_EQ(ring_object(1), "rang");
}

TEST_F(Managers, DiscardingAnswersTransient) {
    manager.discard_requests(true);
    EXPECT_EQ(manager.get_state(), PoaManagerState::discarding);
    EXPECT_EQ(ring_object(1), "TRANSIENT NO 44");
    manager.activate();
    EXPECT_EQ(ring_object(1), "rang");
}

TEST_F(Managers, InactiveAnswersObjAdapterForEver) {
    manager.deactivate(true);
    EXPECT_EQ(manager.get_state(), PoaManagerState::inactive);
    EXPECT_EQ(ring_object(1), "OBJ_ADAPTER NO 46");
    EXPECT_THROW(manager.activate(), AdapterInactive);
    EXPECT_THROW(manager.hold_requests(false), AdapterInactive);
    EXPECT_THROW(manager.discard_requests(false), AdapterInactive);
    EXPECT_THROW(manager.deactivate(false), AdapterInactive);
    EXPECT_THROW(root().create_POA("late", &manager), AdapterInactive);
}

TEST_F(Managers, WhatIsHeldSharesTheFateOfItsManager) {
    simulation.at(TimePoint{1ms}, [&] { manager.discard_requests(false); });
    EXPECT_EQ(ring_object(1), "TRANSIENT NO 44");
    manager.hold_requests(false);
    simulation.at(simulation.now() + 1ms, [&] { poa.deactivate_object(1); });
    EXPECT_EQ(ring_object(1), "OBJECT_NOT_EXIST NO 16");
    poa.activate_object_with_id(1, lamp);
    simulation.at(simulation.now() + 1ms, [&] { manager.deactivate(false); });
    EXPECT_EQ(ring_object(1), "OBJ_ADAPTER NO 46");
    EXPECT_EQ(lamp.calls, 0);
}

TEST_F(Managers, CallsFromTheSameNodeAreHeldToo) {
    EXPECT_EQ(error_of([&] { at(server, 3, 1).with_timeout(5ms).invoke(0, {}); }).kind,
              SystemErrorKind::timeout);
    manager.activate();
    simulation.run_for(1ms);
    EXPECT_EQ(lamp.calls, 0);  // its caller was told NO
    at(server, 3, 1).invoke(0, {});
    EXPECT_EQ(lamp.calls, 1);
}

TEST_F(Managers, EachMemberOfAGroupIsHeldForItself) {
    server.object_join(poa.id_to_reference(1), GroupId{5});
    server.object_join(root().activate_object_with_id(2, other), GroupId{5});
    call_through(group(client, 5), ring);
    call_through(group(server, 5), ring);
    simulation.run_for(5ms);
    EXPECT_EQ(lamp.calls, 0);
    EXPECT_EQ(other.calls, 2);
    manager.activate();
    simulation.run_for(1ms);
    EXPECT_EQ(lamp.calls, 2);
    EXPECT_EQ(other.calls, 2);
    manager.discard_requests(false);
    call_through(group(client, 5), ring);
    simulation.run_for(1ms);
    EXPECT_EQ(lamp.calls, 2);
    EXPECT_EQ(server.counters()[Counter::group_requests_dropped], 1U);
}

TEST_F(Managers, NotToWaitForOneself) {
    TestServant impatient{{{0, [&](ServerCall& call) {
                                EXPECT_EQ(error_of([&] { manager.hold_requests(true); }).minor,
                                          48U);
                                EXPECT_EQ(manager.get_state(), PoaManagerState::active);
                                EXPECT_THROW(poa.destroy(true), BAD_INV_ORDER);
                                EXPECT_THROW(poa.deactivate_object(2, true), BAD_INV_ORDER);
                                EXPECT_THROW(server.drain(1s), BAD_INV_ORDER);
                                nothing(call);
                            }}}};
    poa.activate_object_with_id(2, impatient);
    manager.activate();
    EXPECT_EQ(ring_object(2), "rang");
    EXPECT_EQ(ring_object(1), "rang");
}

// ---- deactivated, and gone, from inside

TEST_F(Poas, ADeactivatedObjectFinishesTheCallItIsIn) {
    TestServant leaver{{{1, [&](ServerCall& call) {
                             root().deactivate_object(1);
                             echo(call);
                         }}}};
    root().activate_object_with_id(1, leaver);
    const std::vector<std::uint8_t> octets{1, 2, 3};
    EXPECT_EQ(at(client, 3, 1).invoke(1, octets), octets);
    EXPECT_EQ(ring_object(1), "OBJECT_NOT_EXIST NO 16");
}

TEST_F(Poas, AServantMayBeDestroyedInsideItsOwnCall) {
    std::unique_ptr<TestServant> last;
    last = std::make_unique<TestServant>(std::map<OperationId, TestServant::Operation>{
        {0, [&](ServerCall& call) {
             server.object_leave(root().id_to_reference(1), GroupId{5});
             root().deactivate_object(1);
             nothing(call);
             last.reset();
         }}});
    server.object_join(root().activate_object_with_id(1, *last), GroupId{5});
    server.object_join(root().activate_object_with_id(2, other), GroupId{5});
    call_through(group(client, 5), ring);
    simulation.run_for(1ms);
    EXPECT_EQ(last, nullptr);
    EXPECT_EQ(other.calls, 1);
    EXPECT_EQ(ring_object(1), "OBJECT_NOT_EXIST NO 16");
    // The same in a two-way call.
    last = std::make_unique<TestServant>(
        std::map<OperationId, TestServant::Operation>{{0, [&](ServerCall& call) {
                                                           root().deactivate_object(1);
                                                           nothing(call);
                                                           last.reset();
                                                       }}});
    root().activate_object_with_id(1, *last);
    EXPECT_EQ(ring_object(1), "rang");
    EXPECT_EQ(last, nullptr);
}

TEST_F(Poas, Draining) {
    root().activate_object_with_id(1, lamp);
    for (int i = 0; i < 5; ++i) call_through(at(client, 3, 1), ring_oneway);
    EXPECT_TRUE(client.drain(1s));
    simulation.run_for(1ms);
    EXPECT_EQ(lamp.calls, 5);
    EXPECT_EQ(client.counters()[Counter::messages_sent], 5U);
    // Nobody acknowledges: it cannot.
    Orb lonely{simulation.add_bus(), node(7)};
    call_through(at(lonely, 3, 1), ring_oneway);
    EXPECT_FALSE(lonely.drain(10ms));
}

TEST_F(Poas, ASimulationHasNeitherWorkersNorADescriptor) {
    OrbOptions options = node(9);
    options.worker_threads = 1;
    EXPECT_THROW((Orb{bus, options}), BAD_PARAM);
    EXPECT_EQ(error_of([&] { server.event_fd(); }).minor, 49U);
}

}  // namespace
}  // namespace canorb::test
