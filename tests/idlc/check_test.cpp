#include "idlc/check/check.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/idlc/support.hpp"

namespace canorb::idlc::test {
namespace {

std::string ids(const std::string& text) {
    const TextCompilation compilation{text};
    return compilation.messages() + model::operation_table(compilation.model);
}

TEST(OperationIdTest, FollowTheHighestInherited) {
    EXPECT_EQ(ids("interface A { void f(); attribute long x; readonly attribute long y; };\n"
                  "interface B : A { void g(); };\n"
                  "interface C : B { void h(); };\n"),
              "IDL:A:1.0\n"
              "    0  f\n"
              "    1  _get_x\n"
              "    2  _set_x\n"
              "    3  _get_y\n"
              "IDL:B:1.0\n"
              "    0  f  (from A)\n"
              "    1  _get_x  (from A)\n"
              "    2  _set_x  (from A)\n"
              "    3  _get_y  (from A)\n"
              "    4  g\n"
              "IDL:C:1.0\n"
              "    0  f  (from A)\n"
              "    1  _get_x  (from A)\n"
              "    2  _set_x  (from A)\n"
              "    3  _get_y  (from A)\n"
              "    4  g  (from B)\n"
              "    5  h\n");
}

TEST(OperationIdTest, ADiamondHasItsTopOnce) {
    EXPECT_EQ(ids("module M {\n"
                  "interface Top { void t(); };\n"
                  "interface Left : Top { void l(); };\n"
                  "@first_operation(8) interface Right : Top { void r(); };\n"
                  "interface Bottom : Left, Right { void b(); };\n"
                  "};\n")
                  .substr(std::string{"IDL:M/Top:1.0\n    0  t\n"
                                      "IDL:M/Left:1.0\n    0  t  (from M::Top)\n    1  l\n"
                                      "IDL:M/Right:1.0\n    0  t  (from M::Top)\n    8  r\n"}
                              .size()),
              "IDL:M/Bottom:1.0\n"
              "    0  t  (from M::Top)\n"
              "    1  l  (from M::Left)\n"
              "    8  r  (from M::Right)\n"
              "    9  b\n");
}

TEST(OperationIdTest, TheLastUserIdIsF7) {
    EXPECT_EQ(ids("@first_operation(0xF7) interface A { void f(); };"), "IDL:A:1.0\n  247  f\n");
}

TEST(RepositoryIdTest, NamesTheScopes) {
    const TextCompilation compilation{
        "module A { module B { interface C { exception D {}; }; }; };"};
    EXPECT_EQ(compilation.messages(), "");
    EXPECT_EQ(compilation.model.storage.back()->repository_id, "IDL:A/B/C/D:1.0");
}

model::Value constant(const std::string& text) {
    const TextCompilation compilation{text};
    EXPECT_EQ(compilation.messages(), "") << text;
    if (compilation.diagnostics.failed()) return false;
    return std::get<model::Constant>(compilation.model.definitions.back()->body).value;
}

TEST(ConstantTest, AreComputed) {
    EXPECT_EQ(constant("const long a = 2 + 3 * 4 - 10 / 3;"), model::Value{std::int64_t{11}});
    EXPECT_EQ(constant("const long a = -7 % 3;"), model::Value{std::int64_t{-1}});
    EXPECT_EQ(constant("const octet a = ~0x0F;"), model::Value{std::uint64_t{0xF0}});
    EXPECT_EQ(constant("const short a = ~0;"), model::Value{std::int64_t{-1}});
    EXPECT_EQ(constant("const long long a = -9223372036854775807 - 1;"),
              model::Value{std::numeric_limits<std::int64_t>::min()});
    EXPECT_EQ(constant("const unsigned long long a = 1 << 63;"),
              model::Value{std::uint64_t{1} << 63});
    EXPECT_EQ(constant("const long a = 0x10 | 010;"), model::Value{std::int64_t{24}});
    EXPECT_EQ(constant("const double a = 1.5 * 2.0;"), model::Value{3.0});
    EXPECT_EQ(constant("const string a = \"x\" \"y\";"), model::Value{std::string{"xy"}});
    EXPECT_EQ(constant("module M { const long b = 5; }; const long a = M::b * 2;"),
              model::Value{std::int64_t{10}});
}

TEST(ScopeTest, LooksOutwardsAndUpwards) {
    const TextCompilation compilation{
        "module A { typedef long T; };\n"
        "module A {\n"
        "  interface Base { enum State { ON, OFF }; };\n"
        "  interface Derived : Base { State get(in T value); const State first = ON; };\n"
        "};\n"
        "module B { struct S { ::A::Base::State one; A::Derived::State two; }; };\n"};
    EXPECT_EQ(compilation.messages(), "");
}

TEST(ScopeTest, ADerivedInterfaceMayDeclareATypeAnew) {
    const TextCompilation compilation{
        "interface A { typedef long T; };\n"
        "interface B : A { typedef short T; };\n"
        "interface C : A, B { void f(in T x); };\n"};
    EXPECT_EQ(compilation.messages(), "");
}

TEST(CheckTest, AManyLayeredDiamondIsQuick) {
    std::string text = "interface L0 {}; interface R0 {};\n";
    for (int i = 1; i < 60; ++i) {
        const std::string bases =
            " : L" + std::to_string(i - 1) + ", R" + std::to_string(i - 1) + " {};\n";
        text +=
            "interface L" + std::to_string(i) + bases + "interface R" + std::to_string(i) + bases;
    }
    EXPECT_EQ(TextCompilation{text}.messages(), "");
}

TEST(DiagnosticsTest, WarningsDoNotFail) {
    const TextCompilation compilation{"@unknown struct A { long x; };"};
    EXPECT_FALSE(compilation.diagnostics.failed());
    EXPECT_EQ(compilation.messages(),
              "test.idl:1:2: warning: the annotation @unknown is ignored\n"
              "@unknown struct A { long x; };\n"
              " ^\n");
}

}  // namespace
}  // namespace canorb::idlc::test
