#include "idlc/structure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/idlc/support.hpp"

namespace canorb::idlc::test {
namespace {

const model::Definition* find(const model::Definitions& definitions, const std::string& name) {
    for (const model::Definition* each : definitions) {
        if (const auto* module = std::get_if<model::Module>(&each->body)) {
            if (const auto* inner = find(module->definitions, name)) return inner;
        }
        if (each->name == name && std::holds_alternative<model::Interface>(each->body)) return each;
    }
    return nullptr;
}

/// The structure of the interface M.
std::string structure_of(const std::string& text) {
    const TextCompilation compilation{text};
    EXPECT_EQ(compilation.messages(), "");
    const model::Definition* interface = find(compilation.model.definitions, "M");
    return interface == nullptr ? "no interface M" : structure(*interface);
}

TEST(StructureTest, HasEachOperationAndEachTypeOnce) {
    EXPECT_EQ(structure_of(R"(
module T {
  enum State { OFF, @value(4) ON, @value(2) IDLE };
  @bit_bound(16) bitmask Faults { HOT, @position(7) WET };
  struct Point { long x, y; };
  struct Line : Point { Point to; State now; };
  exception Broken { string<8> why; };
  exception Busy { };
  union Value switch (State) {
    case OFF: fixed<5,2> number;
    case ON: default: wstring<9> text;
  };
  typedef sequence<Line, 4> Lines;
  typedef short Grid[2][3];
  typedef map<string, any> More;
  interface Device {
    readonly attribute Faults all;
  };
  interface M : Device {
    oneway void stop(in Value how);
    Lines sample(inout Grid from, out More rest) raises (Busy, Broken);
    attribute M leader;
    Object peer();
  };
};)"),
              R"(interface IDL:T/M:1.0
inherits IDL:T/Device:1.0
operation 0 of IDL:T/Device:1.0: IDL:T/Faults:1.0 _get_all()
operation 1 of IDL:T/M:1.0: oneway void stop(in IDL:T/Value:1.0 how)
operation 2 of IDL:T/M:1.0: sequence<IDL:T/Line:1.0,4> sample(inout array<array<short,3>,2> from, out map<string,any> rest) raises IDL:T/Broken:1.0 raises IDL:T/Busy:1.0
operation 3 of IDL:T/M:1.0: IDL:T/M:1.0 _get_leader()
operation 4 of IDL:T/M:1.0: void _set_leader(in IDL:T/M:1.0 value)
operation 5 of IDL:T/M:1.0: Object peer()
bitmask IDL:T/Faults:1.0 16 { 0 HOT 7 WET }
union IDL:T/Value:1.0 IDL:T/State:1.0 { case 0: fixed<5,2> number; case 4 default: wstring<9> text; }
struct IDL:T/Line:1.0 { long x; long y; IDL:T/Point:1.0 to; IDL:T/State:1.0 now; }
exception IDL:T/Broken:1.0 { string<8> why; }
exception IDL:T/Busy:1.0 { }
enum IDL:T/State:1.0 { 0 OFF 2 IDLE 4 ON }
struct IDL:T/Point:1.0 { long x; long y; }
)");
}

TEST(StructureTest, EndsForRecursiveTypes) {
    EXPECT_EQ(structure_of("struct Node; typedef sequence<Node> Nodes;"
                           "struct Node { Nodes children; };"
                           "interface M { void f(in Node root); };"),
              "interface IDL:M:1.0\n"
              "operation 0 of IDL:M:1.0: void f(in IDL:Node:1.0 root)\n"
              "struct IDL:Node:1.0 { sequence<IDL:Node:1.0> children; }\n");
}

// There are as many ways up as 2 to the power of the diamonds.
TEST(StructureTest, EndsForManyDiamonds) {
    constexpr int diamonds = 64;
    std::string text = "interface D0 { void f(); };";
    for (int i = 0; i < diamonds; ++i) {
        const std::string below = std::to_string(i);
        const std::string here = std::to_string(i + 1);
        text += "interface A" + here + " : D" + below + " {}; interface B" + here + " : D" + below +
                " {}; interface D" + here + " : A" + here + ", B" + here + " {};";
    }
    text += "interface M : D" + std::to_string(diamonds) + " {};";
    const std::string structure = structure_of(text);
    EXPECT_EQ(std::count(structure.begin(), structure.end(), '\n'), 1 + (3 * diamonds + 1) + 1)
        << structure;
}

TEST(StructureTest, HasNoOperationsOfALocalInterface) {
    EXPECT_EQ(structure_of("interface D { void f(); }; local interface M : D { void g(); };"),
              "local interface IDL:M:1.0\ninherits IDL:D:1.0\n");
}

TEST(StructureTest, SpellsEveryBasicType) {
    EXPECT_EQ(structure_of("struct S { boolean a; char b; wchar c; octet d; int8 e; uint8 f;"
                           "short g; unsigned short h; long i; unsigned long j; long long k;"
                           "unsigned long long l; float m; double n; long double o; any p;"
                           "string q; wstring r; };"
                           "interface M { S f(); };"),
              "interface IDL:M:1.0\n"
              "operation 0 of IDL:M:1.0: IDL:S:1.0 f()\n"
              "struct IDL:S:1.0 { boolean a; char b; wchar c; octet d; int8 e; uint8 f; short g; "
              "unsigned short h; long i; unsigned long j; long long k; unsigned long long l; "
              "float m; double n; long double o; any p; string q; wstring r; }\n");
}

TEST(StructureTest, DoesNotCountWhatTheWireDoesNot) {
    // An alias, a comment, another order of declarations and of raises, another word for the type.
    EXPECT_EQ(structure_of("typedef int32 Number; exception B {}; typedef sequence<Number> Numbers;"
                           "exception A {}; /* of M */ interface M {\n"
                           "  void f(in Numbers x) raises (B, A); };"),
              structure_of("typedef sequence<long> Longs; exception A {}; exception B {};"
                           "interface M { void f(in Longs x) raises (A, B); };"));
}

TEST(StructureTest, CountsEverythingElse) {
    const std::string base = "interface M { void f(in long x); };";
    const char* others[] = {
        "interface M { void g(in long x); };",
        "interface M { void f(in long y); };",
        "interface M { void f(inout long x); };",
        "interface M { void f(in unsigned long x); };",
        "interface M { long f(in long x); };",
        "interface M { oneway void f(in long x); };",
        "interface M { void f(in long x); void g(); };",
        "@first_operation(1) interface M { void f(in long x); };",
        "interface M { void f(in long x); };\n#pragma version M 1.1\n",
        "interface D {}; interface M : D { void f(in long x); };",
        "exception E {}; interface M { void f(in long x) raises (E); };",
        "local interface M { void f(in long x); };",
    };
    for (const char* other : others) EXPECT_NE(structure_of(base), structure_of(other)) << other;
}

TEST(StructuralHashTest, IsTheCrcOfTheText) {
    // The check value of CRC-32, and the CRC of nothing.
    EXPECT_EQ(crc32("123456789"), 0xCBF43926U);
    EXPECT_EQ(crc32(""), 0U);
    const TextCompilation compilation{"interface M { };"};
    const model::Definition& interface = *compilation.model.definitions.at(0);
    EXPECT_EQ(structure(interface), "interface IDL:M:1.0\n");
    // As zlib's crc32 says.
    EXPECT_EQ(structural_hash(interface), 0x40E378E0U);
}

TEST(GroupKeyTest, IsThatOfTheWire) {
    const TextCompilation compilation{"module Devices { interface Motor { }; };"};
    // doc/wire/giop.md, "object_key".
    EXPECT_EQ(group_key(*find(compilation.model.definitions, "Motor")), 0x4DDBU);
}

}  // namespace
}  // namespace canorb::idlc::test
