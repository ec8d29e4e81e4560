// System exceptions and their minor codes, as applications see them: doc/errors.md. Those of
// deadlines, limits and faults are tested with what causes them.

#include <utility>

#include "canorb/union.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

template <typename E>
std::string caught_as(const SystemError& error) {
    try {
        throw_system_exception(error, "in a test");
    } catch (const E& exception) {
        EXPECT_EQ(exception.error(), error);
        return std::string{exception._repository_id()};
    } catch (...) {
        return "another class";
    }
}

template <std::size_t Kind>
void expect_own_class() {
    constexpr SystemErrorKind kind{Kind};
    EXPECT_EQ(caught_as<StandardException<kind>>({kind, Completion::yes, 200}),
              repository_id(kind));
}

template <std::size_t... Kinds>
void expect_own_classes(std::index_sequence<Kinds...>) {
    (expect_own_class<Kinds>(), ...);
}

TEST(Exceptions, EachKindIsThrownAsItsClass) {
    expect_own_classes(std::make_index_sequence<system_error_kind_count>{});
    EXPECT_EQ(caught_as<DATA_CONVERSION>({SystemErrorKind::data_conversion}),
              "IDL:omg.org/CORBA/DATA_CONVERSION:1.0");
    EXPECT_EQ(caught_as<TRANSIENT>({SystemErrorKind::rebind}), "another class");
}

TEST(Exceptions, SayTheirMinorInWordsWhereItIsCanorbs) {
    EXPECT_STREQ(
        (TIMEOUT{"start", Completion::no, 1}.what()),
        "TIMEOUT (completed NO, minor 1): the deadline passed in the transmit queue: start");
    EXPECT_STREQ((TIMEOUT{"", Completion::no, 1}.what()),
                 "TIMEOUT (completed NO, minor 1): the deadline passed in the transmit queue");
    EXPECT_STREQ((TIMEOUT{"start", Completion::maybe, 127}.what()),
                 "TIMEOUT (completed MAYBE, minor 127): start");
    EXPECT_STREQ((MARSHAL{"start", Completion::no, 1}.what()),
                 "MARSHAL (completed NO, minor 1): start");
    EXPECT_STREQ(TIMEOUT{"start"}.what(), "TIMEOUT (completed NO): start");
    EXPECT_STREQ(TIMEOUT{}.what(), "TIMEOUT (completed NO)");
}

class ExceptionsOverTheBus : public World {
  protected:
    ExceptionsOverTheBus() { server.root_poa().activate_object_with_id(1, servant); }

    Orb server{bus, node(3)};
    Orb client{bus, node(5)};
    TestServant servant{
        {{0, nothing},
         {1, [](ServerCall&) { throw DATA_CONVERSION{"", Completion::yes, 4'000'000'000}; }},
         {2, [](ServerCall&) { throw std::runtime_error{"a bug"}; }}}};
    ObjectRef target = at(client, 3, 1);
};

TEST_F(ExceptionsOverTheBus, AnyOfCorbasArrivesAsItself) {
    EXPECT_EQ(what<DATA_CONVERSION>([&] { target.invoke(1, {}); }),
              "DATA_CONVERSION (completed YES, minor 4000000000): invoke on node 3, object 1");
}

TEST_F(ExceptionsOverTheBus, WhyItWasRaisedThereIsSaidHere) {
    EXPECT_EQ(
        what<OBJECT_NOT_EXIST>([&] { at(client, 3, 2).invoke(0, {}); }),
        "OBJECT_NOT_EXIST (completed NO, minor 16): no such object: invoke on node 3, object 2");
    EXPECT_EQ(what<UNKNOWN>([&] { target.invoke(2, {}); }),
              "UNKNOWN (completed MAYBE, minor 40): the servant raised what the operation does not "
              "declare: invoke on node 3, object 1");
    // The number takes one octet: id 39 with its length, minor, completion, behind a header of 6.
    seen.clear();
    EXPECT_THROW(at(client, 3, 2).invoke(0, {}), OBJECT_NOT_EXIST);
    std::vector<std::uint8_t> octets;
    for (const Seen& frame : seen) {
        if (frame.frame.id != 0x4A3) continue;  // node 3 to 5
        const Bytes payload = frame.frame.payload();
        const Bytes part = octets.empty() ? payload : payload.subspan(1);
        octets.insert(octets.end(), part.begin(), part.end());
    }
    ASSERT_EQ(octets.size(), 6U + 1 + 39 + 1 + 1);
    EXPECT_EQ(octets[octets.size() - 3], 0);   // the NUL of the id
    EXPECT_EQ(octets[octets.size() - 2], 16);  // minor
    EXPECT_EQ(octets[octets.size() - 1], 1);   // NO
}

TEST_F(ExceptionsOverTheBus, WhatIsKnownAtOnceHasItsMinor) {
    const auto minor = [](auto call) { return error_of(call).minor; };
    const OperationInfo query{&lamp_interface, 9, "query", false, false};
    EXPECT_EQ(minor([&] { call_through(group(client, 7), query); }), 19U);
    EXPECT_EQ(minor([&] { throw_not_selected("Shape::radius"); }), 29U);
    EXPECT_EQ(minor([&] { const Orb orb{bus, node(31)}; }), 24U);
    EXPECT_EQ(minor([&] { simulation.add_bus({.bitrate = 1}); }), 24U);
    EXPECT_EQ(minor([&] { static_cast<void>(target.with_timeout(Duration{0})); }), 25U);
    EXPECT_EQ(minor([&] { client.every(Duration{0}, [] {}); }), 25U);
    EXPECT_EQ(minor([&] { client.set_node(31); }), 25U);
    EXPECT_EQ(minor([&] { static_cast<void>(client.group_reference(GroupId{32})); }), 25U);
    EXPECT_EQ(minor([&] { client.root_poa().activate_object_with_id(1024, servant); }), 25U);
    EXPECT_EQ(minor([&] { static_cast<void>(parse_node_id("x")); }), 25U);
    EXPECT_EQ(minor([&] { static_cast<void>(open_bus("can0")); }), 25U);
    EXPECT_EQ(minor([&] { static_cast<void>(open_bus("sim:/nonexistent/bus")); }), 9U);
    EXPECT_EQ(minor([&] { client.string_to_object("IOR:00"); }), 26U);
    EXPECT_EQ(minor([&] { client.string_to_object("CAN_IOR:0g"); }), 35U);
    EXPECT_EQ(minor([&] { client.object_join(target, GroupId{7}); }), 27U);
    EXPECT_EQ(minor([&] { client.object_join(at(client, 5, 9), GroupId{7}); }), 27U);
    EXPECT_EQ(minor([&] { ObjectRef{}.invoke(0, {}); }), 34U);
    ObjectRef orphan;
    {
        Orb short_lived{bus, node(9)};
        orphan = at(short_lived, 3, 1);
    }
    EXPECT_EQ(minor([&] { orphan.invoke(0, {}); }), 38U);
    Orb numberless{bus, node(std::nullopt)};
    EXPECT_EQ(minor([&] { at(numberless, 3, 1).invoke(0, {}); }), 36U);
}

}  // namespace
}  // namespace canorb::test
