#include "orb/core/reference.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "tests/support/octets.hpp"

namespace canorb::core {
namespace {

using canorb::test::hex;
using canorb::test::octets;

const Reference motor_object =
    Reference::to_object(ObjectKey{NodeId{3}, 1}, "IDL:Devices/Motor:1.0");
const Reference motor_group = Reference::to_group(GroupId{5}, "IDL:Devices/Motor:1.0");

/// As text, to compare whole references at once: "object 3/1 IDL:x:1.0", "group 5 ", "nil".
std::string describe(const Reference& reference) {
    switch (reference.kind) {
        case Reference::Kind::nil:
            return "nil";
        case Reference::Kind::object:
            return "object " + std::to_string(reference.key.node().value()) + "/" +
                   std::to_string(reference.key.index()) + " " + reference.type_id;
        case Reference::Kind::group:
            return "group " + std::to_string(reference.group.value()) + " " + reference.type_id;
    }
    return "";
}

std::string parsed(const std::string& text) {
    const auto reference = parse_reference(text);
    if (reference) return describe(*reference);
    return std::string{name(reference.error().error.kind)} + ": " +
           std::string{reference.error().why};
}

// ---- the wire documentation's own

TEST(Reference, AnObjectAsText) {
    const std::string text = "CAN_IOR:1649444c3a446576696365732f4d6f746f723a312e30000000031801";
    EXPECT_EQ(to_string(motor_object), text);
    EXPECT_EQ(parsed(text), "object 3/1 IDL:Devices/Motor:1.0");
}

TEST(Reference, AGroupAsText) {
    const std::string text = "CAN_IOR:1649444c3a446576696365732f4d6f746f723a312e3000000105";
    EXPECT_EQ(to_string(motor_group), text);
    EXPECT_EQ(parsed(text), "group 5 IDL:Devices/Motor:1.0");
}

TEST(Reference, NilAsText) {
    EXPECT_EQ(to_string(Reference{}), "CAN_IOR:0100ff");
    EXPECT_EQ(parsed("CAN_IOR:0100ff"), "nil");
}

// ---- as octets

struct Golden {
    std::string reference;
    std::string octets;
    Reference value;
};

TEST(Reference, AsOctetsBothWays) {
    const Golden goldens[] = {
        {"nil", "0100 FF", {}},
        {"object 0/0 ", "0100 00 00 00 0000", Reference::to_object(ObjectKey{0x0000}, "")},
        {"object 0/2047 ", "0100 00 00 00 07FF", Reference::to_object(ObjectKey{0x07FF}, "")},
        {"object 30/2047 A", "024100 00 00 1E F7FF", Reference::to_object(ObjectKey{0xF7FF}, "A")},
        {"group 1 ", "0100 00 01 01", Reference::to_group(GroupId{1}, "")},
        {"group 31 A", "024100 00 01 1F", Reference::to_group(GroupId{31}, "A")},
    };
    for (const Golden& golden : goldens) {
        std::array<std::uint8_t, 16> buffer{};
        ccdr::Encoder out{buffer};
        encode(out, golden.value);
        EXPECT_EQ(out.error(), ccdr::EncodeError::none);
        EXPECT_EQ(hex(out.octets()), hex(octets(golden.octets))) << golden.reference;

        const auto input = octets(golden.octets);
        ccdr::Decoder in{input};
        Reference back;
        decode(in, back);
        EXPECT_TRUE(in.finished()) << golden.reference;
        EXPECT_EQ(describe(back), golden.reference);
        EXPECT_TRUE(back.same_target(golden.value));
    }
}

TEST(Reference, DoesNotFitIntoALittleBuffer) {
    std::array<std::uint8_t, 6> buffer{};
    ccdr::Encoder out{buffer};
    encode(out, Reference::to_object(ObjectKey{0x1801}, ""));  // 7 octets
    EXPECT_EQ(out.error(), ccdr::EncodeError::buffer_full);
}

TEST(Reference, WhatFollowsInAMessageIsLeftAlone) {
    const auto input = octets("0100 FF 0100 00 01 05 2A");
    ccdr::Decoder in{input};
    Reference nil = motor_object;
    Reference group;
    decode(in, nil);
    decode(in, group);
    EXPECT_EQ(describe(nil), "nil");
    EXPECT_EQ(describe(group), "group 5 ");
    EXPECT_EQ(in.octet(), 0x2A);
    EXPECT_TRUE(in.finished());
}

TEST(Reference, SameTargetIsAboutWhereItLeads) {
    EXPECT_TRUE(motor_object.same_target(Reference::to_object(ObjectKey{0x1801}, "")));
    EXPECT_FALSE(motor_object.same_target(Reference::to_object(ObjectKey{0x1802}, "")));
    EXPECT_FALSE(motor_object.same_target(Reference::to_object(ObjectKey{0x2001}, "")));
    EXPECT_TRUE(motor_group.same_target(Reference::to_group(GroupId{5}, "")));
    EXPECT_FALSE(motor_group.same_target(Reference::to_group(GroupId{6}, "")));
    EXPECT_FALSE(motor_group.same_target(motor_object));
    EXPECT_TRUE(Reference{}.same_target({}));
    EXPECT_FALSE(Reference{}.same_target(motor_object));
}

// ---- texts

struct Text {
    std::string text;
    std::string result;
};

class Texts : public testing::TestWithParam<Text> {};

TEST_P(Texts, IsReadAs) {
    EXPECT_EQ(parsed(GetParam().text), GetParam().result);
}

const char* const no_hex = "INV_OBJREF: a character that is no hex digit";
const char* const odd = "INV_OBJREF: an odd number of hex digits";
const char* const malformed = "INV_OBJREF: the octets are no object reference";
const char* const left_over = "INV_OBJREF: octets are left over after the object reference";
const char* const bad_prefix = "BAD_PARAM: a reference begins with CAN_IOR: or corbaloc:caniop:";
const char* const bad_form = "BAD_PARAM: corbaloc:caniop: wants NODE/INDEX or group/GROUP";
const char* const bad_node = "BAD_PARAM: the node is not a number from 0 to 30";
const char* const bad_index = "BAD_PARAM: the object index is not a number from 0 to 2047";
const char* const bad_group = "BAD_PARAM: the group is not a number from 1 to 31";

INSTANTIATE_TEST_SUITE_P(
    Ior, Texts,
    testing::Values(
        // Either case, and both at once.
        Text{"CAN_IOR:0100FF", "nil"}, Text{"CAN_IOR:0100fF", "nil"},
        Text{"CAN_IOR:1649444C3A446576696365732F4D6F746F723A312E30000000031801",
             "object 3/1 IDL:Devices/Motor:1.0"},
        Text{"CAN_IOR:", "INV_OBJREF: nothing follows CAN_IOR:"}, Text{"CAN_IOR:0", odd},
        Text{"CAN_IOR:0100f", odd}, Text{"CAN_IOR:0100fg", no_hex}, Text{"CAN_IOR: 0100ff", odd},
        Text{"CAN_IOR:01 00ff ", no_hex}, Text{"CAN_IOR:0x0100ff", no_hex},
        Text{std::string{"CAN_IOR:0100f\0", 14}, no_hex},
        // Nil is exactly that.
        Text{"CAN_IOR:024100ff", malformed}, Text{"CAN_IOR:0100ff00", left_over},
        // Cut short anywhere.
        Text{"CAN_IOR:01", malformed}, Text{"CAN_IOR:0100", malformed},
        Text{"CAN_IOR:010000", malformed}, Text{"CAN_IOR:01000000", malformed},
        Text{"CAN_IOR:0100000003", malformed}, Text{"CAN_IOR:010000000318", malformed},
        Text{"CAN_IOR:01000000031801", "object 3/1 "}, Text{"CAN_IOR:0100000000180100", malformed},
        Text{"CAN_IOR:0100000003180100", left_over}, Text{"CAN_IOR:01000001", malformed},
        Text{"CAN_IOR:0100000105", "group 5 "}, Text{"CAN_IOR:010000010500", left_over},
        // Numbers that do not exist, or contradict each other.
        Text{"CAN_IOR:01000000041801", malformed}, Text{"CAN_IOR:0100000000ffff", malformed},
        Text{"CAN_IOR:010000001ff801", malformed}, Text{"CAN_IOR:010000001ef001", "object 30/1 "},
        Text{"CAN_IOR:0100000100", malformed}, Text{"CAN_IOR:010000011f", "group 31 "},
        Text{"CAN_IOR:0100000120", malformed}, Text{"CAN_IOR:01000001ff", malformed},
        // Profiles and reference types that do not exist.
        Text{"CAN_IOR:01000100031801", malformed}, Text{"CAN_IOR:0100fe00031801", malformed},
        Text{"CAN_IOR:01000002031801", malformed},
        // A type_id that is no string: no NUL, one inside, longer than the octets, long form.
        Text{"CAN_IOR:00ff", malformed}, Text{"CAN_IOR:0141ff", malformed},
        Text{"CAN_IOR:03004100000105", malformed}, Text{"CAN_IOR:7f41000000031801", malformed},
        Text{"CAN_IOR:f0ffffffff41000000031801", malformed}, Text{"CAN_IOR:800100ff", malformed}));

INSTANTIATE_TEST_SUITE_P(
    Corbaloc, Texts,
    testing::Values(
        Text{"corbaloc:caniop:3/1", "object 3/1 "}, Text{"corbaloc:caniop:0/0", "object 0/0 "},
        Text{"corbaloc:caniop:30/2047", "object 30/2047 "}, Text{"corbaloc:caniop:31/1", bad_node},
        Text{"corbaloc:caniop:3/2048", bad_index}, Text{"corbaloc:caniop:256/1", bad_node},
        Text{"corbaloc:caniop:3/65537", bad_index}, Text{"corbaloc:caniop:4294967299/1", bad_node},
        Text{"corbaloc:caniop:3/4294967297", bad_index},
        Text{"corbaloc:caniop:3/18446744073709551617", bad_index},
        Text{"corbaloc:caniop:03/1", bad_node}, Text{"corbaloc:caniop:3/01", bad_index},
        Text{"corbaloc:caniop:00/1", bad_node}, Text{"corbaloc:caniop:+3/1", bad_node},
        Text{"corbaloc:caniop:-3/1", bad_node}, Text{"corbaloc:caniop:3/+1", bad_index},
        Text{"corbaloc:caniop:3/-1", bad_index}, Text{"corbaloc:caniop:0x3/1", bad_node},
        Text{"corbaloc:caniop:3/1 ", bad_index}, Text{"corbaloc:caniop: 3/1", bad_node},
        Text{"corbaloc:caniop:3/1/1", bad_index}, Text{"corbaloc:caniop:/1", bad_node},
        Text{"corbaloc:caniop:3/", bad_index}, Text{"corbaloc:caniop:3.0/1", bad_node},
        Text{"corbaloc:caniop:3", bad_form}, Text{"corbaloc:caniop:", bad_form},
        Text{"corbaloc:caniop:group", bad_form}, Text{"corbaloc:caniop:Group/5", bad_node},
        Text{"corbaloc:caniop:group/1", "group 1 "}, Text{"corbaloc:caniop:group/5", "group 5 "},
        Text{"corbaloc:caniop:group/31", "group 31 "}, Text{"corbaloc:caniop:group/0", bad_group},
        Text{"corbaloc:caniop:group/32", bad_group}, Text{"corbaloc:caniop:group/05", bad_group},
        Text{"corbaloc:caniop:group/+5", bad_group}, Text{"corbaloc:caniop:group/-1", bad_group},
        Text{"corbaloc:caniop:group/261", bad_group},
        Text{"corbaloc:caniop:group/4294967301", bad_group},
        Text{"corbaloc:caniop:group/", bad_group}, Text{"corbaloc:caniop:group/5/1", bad_group}));

INSTANTIATE_TEST_SUITE_P(Prefix, Texts,
                         testing::Values(Text{"", bad_prefix}, Text{"IOR:0100ff", bad_prefix},
                                         Text{"can_ior:0100ff", bad_prefix},
                                         Text{" CAN_IOR:0100ff", bad_prefix},
                                         Text{"CAN_IOR", bad_prefix},
                                         Text{"corbaloc::host/x", bad_prefix},
                                         Text{"corbaloc:CANIOP:3/1", bad_prefix},
                                         Text{"corbaname:caniop:3/1", bad_prefix}));

}  // namespace
}  // namespace canorb::core
