#include "idlc/parse/parser.hpp"

#include <gtest/gtest.h>

#include <string>

namespace canorb::idlc {
namespace {

std::string parsed(const std::string& text) {
    const Source source{"test.idl", text};
    Diagnostics diagnostics;
    const ast::File file = parse::parse_file(tokenize(source, diagnostics), diagnostics);
    return ast::dump(file) + format(diagnostics, source);
}

TEST(ParserTest, BuildsTrees) {
    struct Case {
        const char* text;
        const char* tree;
    };
    const Case cases[] = {
        {"", ""},
        {"module A { module B {}; };", "module A\n  module B\n"},
        {"typedef long A, B[2][3];", "typedef int32 A\ntypedef int32 B[2][3]\n"},
        {"typedef unsigned long long A;", "typedef uint64 A\n"},
        {"typedef sequence<sequence<long, 4>> A;", "typedef sequence<sequence<int32, 4>> A\n"},
        {"typedef string<(16 >> 2)> A;", "typedef string<(>> 16 2)> A\n"},
        {"typedef ::A::B C;", "typedef ::A::B C\n"},
        {"const long a = 1 + 2 * 3;", "const int32 a = (+ 1 (* 2 3))\n"},
        {"const long a = 1 - 2 - 3;", "const int32 a = (- (- 1 2) 3)\n"},
        {"const long a = 1 | 2 ^ 3 & 4 << 5;", "const int32 a = (| 1 (^ 2 (& 3 (<< 4 5))))\n"},
        {"const long a = -(1 + ~2) % A::b;", "const int32 a = (% (- (+ 1 (~ 2))) A::b)\n"},
        {"const string a = \"x\" \"y\";", "const string a = \"xy\"\n"},
        {"const boolean a = TRUE;", "const boolean a = TRUE\n"},
        {"enum A { B, C };", "enum A: B C\n"},
        {"struct A { long x, y[2]; Object o; };",
         "struct A\n  int32 x\n  int32 y[2]\n  Object o\n"},
        {"exception A {};", "exception A\n"},
        {"interface A;", "interface A (forward)\n"},
        {"interface A : B, ::C::D {};", "interface A: B, ::C::D\n"},
        {"interface A { oneway void f(in octet x); };",
         "interface A\n  oneway void f(in octet x)\n"},
        {"interface A { long f(out A a, inout string s) raises (X, Y::Z); };",
         "interface A\n  int32 f(out A a, inout string s) raises (X, Y::Z)\n"},
        {"interface A { readonly attribute long x, y; attribute float z getraises (E); };",
         "interface A\n  readonly attribute int32 x\n  readonly attribute int32 y\n"
         "  attribute float z getraises (E)\n"},
        {"/// Text.\n@first_operation(1 << 4) interface A { void f(); };",
         "/// Text.\n@first_operation((<< 1 4))\ninterface A\n  void f()\n"},
    };
    for (const Case& one : cases) EXPECT_EQ(parsed(one.text), one.tree) << one.text;
}

TEST(ParserTest, GoesOnBehindAnError) {
    EXPECT_EQ(parsed("struct A { long; }; typedef long B;"),
              "typedef int32 B\n"
              "test.idl:1:16: error: expected the member's name, not ';'\n"
              "struct A { long; }; typedef long B;\n"
              "               ^\n");
}

TEST(ParserTest, SurvivesDeepNesting) {
    std::string modules;
    std::string sequences{"typedef "};
    for (int i = 0; i < 10000; ++i) {
        modules += "module A { ";
        sequences += "sequence<";
    }
    EXPECT_NE(parsed(modules).find("nested too deeply"), std::string::npos);
    EXPECT_NE(parsed(sequences).find("nested too deeply"), std::string::npos);
    EXPECT_NE(parsed("const long a = " + std::string(10000, '-') + "1;").find("nested too deeply"),
              std::string::npos);
}

}  // namespace
}  // namespace canorb::idlc
