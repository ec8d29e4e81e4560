#include "idlc/check/check.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

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

/// The repository ids of all definitions, in order.
std::vector<std::string> repository_ids(const std::string& text) {
    const TextCompilation compilation{text};
    EXPECT_EQ(compilation.messages(), "") << text;
    std::vector<std::string> ids;
    for (const auto& definition : compilation.model.storage) {
        ids.push_back(definition->repository_id);
    }
    return ids;
}

using Ids = std::vector<std::string>;

TEST(RepositoryIdTest, APrefixHoldsForTheRestOfItsScope) {
    EXPECT_EQ(repository_ids("#pragma prefix \"a.b\"\n"
                             "module M { interface I {};\n"
                             "#pragma prefix \"c\"\n"
                             "interface J { struct S { long a; }; };\n"
                             "};\n"
                             "interface K {};\n"
                             "#pragma prefix \"\"\n"
                             "interface L {};\n"),
              (Ids{"IDL:a.b/M:1.0", "IDL:a.b/M/I:1.0", "IDL:c/J:1.0", "IDL:c/J/S:1.0",
                   "IDL:a.b/K:1.0", "IDL:L:1.0"}));
}

TEST(RepositoryIdTest, APrefixHoldsForItsFileOnly) {
    EXPECT_EQ(repository_ids("# 1 \"test.idl\"\n"
                             "#pragma prefix \"outer\"\n"
                             "# 1 \"other.idl\" 1\n"
                             "interface A {};\n"
                             "#pragma prefix \"other\"\n"
                             "interface B {};\n"
                             "# 3 \"test.idl\" 2\n"
                             "interface C {};\n"),
              (Ids{"IDL:A:1.0", "IDL:other/B:1.0", "IDL:outer/C:1.0"}));
}

TEST(RepositoryIdTest, AreGivenByDirectives) {
    EXPECT_EQ(repository_ids("module M { interface I {}; interface J {}; };\n"
                             "#pragma ID M::I \"IDL:x:2.0\"\n"
                             "#pragma ID M::I \"IDL:x:2.0\"\n"
                             "#pragma version M::J 2.3\n"
                             "struct S { long a; };\n"
                             "typeid S \"LOCAL:s\";\n"),
              (Ids{"IDL:M:1.0", "IDL:x:2.0", "IDL:M/J:2.3", "LOCAL:s"}));
}

TEST(RepositoryIdTest, ATypePrefixHoldsForAllOfItsScope) {
    EXPECT_EQ(repository_ids("module M { interface I {}; typeprefix M \"omg.org\";\n"
                             "interface J {}; };\n"
                             "module M { interface K {}; };\n"),
              (Ids{"IDL:omg.org/M:1.0", "IDL:omg.org/M/I:1.0", "IDL:omg.org/M/J:1.0",
                   "IDL:omg.org/M:1.0", "IDL:omg.org/M/K:1.0"}));
    EXPECT_EQ(repository_ids("module M { interface I {};\n"
                             "#pragma version I 2.0\n"
                             "interface J {};\n"
                             "#pragma ID J \"IDL:x:3.0\"\n"
                             "typeprefix M \"omg.org\"; };\n"),
              (Ids{"IDL:omg.org/M:1.0", "IDL:omg.org/M/I:2.0", "IDL:x:3.0"}));
}

/// The last definition of the file.
template <typename Body>
Body body(const std::string& text) {
    const TextCompilation compilation{text};
    EXPECT_EQ(compilation.messages(), "") << text;
    return std::get<Body>(compilation.model.definitions.back()->body);
}

TEST(EnumTest, NumbersAreGivenOrCounted) {
    const auto numbered =
        body<model::Enum>("enum E { a, @value(7) b, c, @default_literal @value(0x100) d };");
    ASSERT_EQ(numbered.enumerators.size(), 4U);
    EXPECT_EQ(numbered.enumerators[0].number, 0U);
    EXPECT_EQ(numbered.enumerators[1].number, 7U);
    EXPECT_EQ(numbered.enumerators[2].number, 8U);
    EXPECT_EQ(numbered.enumerators[3].number, 256U);
    EXPECT_EQ(numbered.default_index, 3U);
}

TEST(BitmaskTest, FlagsHavePositions) {
    const auto mask =
        body<model::Bitmask>("@bit_bound(12) bitmask Flags { a, @position(5) b, c };");
    EXPECT_EQ(mask.bit_bound, 12U);
    ASSERT_EQ(mask.flags.size(), 3U);
    EXPECT_EQ(mask.flags[0].position, 0U);
    EXPECT_EQ(mask.flags[1].position, 5U);
    EXPECT_EQ(mask.flags[2].position, 6U);
}

TEST(UnionTest, KnowsAValueWithoutALabel) {
    const auto unlabelled = [](const std::string& text) {
        return body<model::Union>(text).unlabelled;
    };
    EXPECT_EQ(unlabelled("union U switch (long) { case 0: case 1: long a; case 3: long b; };"),
              model::Value{std::int64_t{2}});
    EXPECT_EQ(unlabelled("union U switch (octet) { case 1: long a; };"),
              model::Value{std::uint64_t{0}});
    EXPECT_EQ(unlabelled("union U switch (boolean) { case FALSE: long a; };"), model::Value{true});
    EXPECT_EQ(unlabelled("union U switch (boolean) { case TRUE: long a; case FALSE: long b; };"),
              std::nullopt);
    EXPECT_EQ(unlabelled("union U switch (wchar) { case L'\\0': long a; default: long b; };"),
              model::Value{char16_t{1}});
}

TEST(TypeTest, RecursionGoesThroughSequencesAndMaps) {
    const TextCompilation compilation{
        "struct Flat { sequence<long> list; };\n"
        "struct Tree { sequence<Tree> branches; };\n"
        "struct Forest { sequence<Tree> trees; };\n"
        "union Choice;\n"
        "typedef map<long, Choice> Choices;\n"
        "union Choice switch (long) { case 1: Choices more; };\n"};
    EXPECT_EQ(compilation.messages(), "");
    std::vector<std::string> recursive;
    for (const auto& definition : compilation.model.storage) {
        if (model::is_recursive(*definition)) recursive.push_back(definition->name);
    }
    EXPECT_EQ(recursive, (std::vector<std::string>{"Tree", "Choice"}));
}

TEST(TypeTest, EmptyStructsTakeNoOctets) {
    const TextCompilation compilation{
        "struct Empty {};\n"
        "struct Holder { Empty all[3]; };\n"
        "struct Derived : Holder {};\n"
        "struct Full : Holder { octet o; };\n"
        "struct Many { sequence<Empty> list; };\n"};
    EXPECT_EQ(compilation.messages(), "");
    std::vector<std::string> empty;
    for (const auto& definition : compilation.model.storage) {
        model::Type type;
        type.kind = model::TypeKind::named;
        type.definition = definition.get();
        if (model::takes_no_octets(type)) empty.push_back(definition->name);
    }
    EXPECT_EQ(empty, (std::vector<std::string>{"Empty", "Holder", "Derived"}));
}

TEST(ObstacleTest, AreWarningsWhereNoCodeIsWanted) {
    const std::string text = "interface A;\nstruct S { A a1; };\n";
    const Source source{"test.idl", text};
    Diagnostics diagnostics;
    const model::Model model = compile(source, diagnostics);
    report_obstacles(model, Severity::warning, diagnostics);
    EXPECT_FALSE(diagnostics.failed());
    report_obstacles(model, Severity::error, diagnostics);
    EXPECT_TRUE(diagnostics.failed());
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
    EXPECT_EQ(constant("const wstring a = L\"x\" L\"\\u00e9\";"),
              model::Value{std::u16string{u"x\u00e9"}});
    EXPECT_EQ(constant("const wchar a = L'\\u4e2d';"), model::Value{char16_t{0x4E2D}});
    EXPECT_EQ(constant("bitmask Flags { a, b, c }; const Flags d = Flags::a | Flags::c;"),
              model::Value{std::uint64_t{5}});
    EXPECT_EQ(constant("module M { const long b = 5; }; const long a = M::b * 2;"),
              model::Value{std::int64_t{10}});
}

TEST(ConstantTest, FixedIsExact) {
    const auto fixed = [](const std::string& expression) {
        return std::get<model::FixedValue>(constant("const fixed a = " + expression + ";")).text;
    };
    EXPECT_EQ(fixed("12.50d"), "12.5");
    EXPECT_EQ(fixed("-0.5d"), "-0.5");
    EXPECT_EQ(fixed("1.1d + 2.90d"), "4");
    EXPECT_EQ(fixed("1.25d * 0.4d"), "0.5");
    EXPECT_EQ(fixed("1d / 8d"), "0.125");
    // 31 digits behind the point, the others cut.
    EXPECT_EQ(fixed("1d / 3d"), "0.3333333333333333333333333333333");
    EXPECT_EQ(fixed("9999999999999999999999999999999d"), "9999999999999999999999999999999");
    const auto typed = body<model::Constant>("typedef fixed<5, 2> Money; const Money a = 1.5d;");
    EXPECT_EQ(std::get<model::FixedValue>(typed.value).text, "1.50");
    const auto untyped = body<model::Constant>("const fixed a = 0.05d;");
    EXPECT_EQ(untyped.type.digits, 2U);
    EXPECT_EQ(untyped.type.scale, 2U);
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
