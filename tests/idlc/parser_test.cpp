#include "idlc/parse/parser.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace canorb::idlc {
namespace {

struct Parsed {
    explicit Parsed(const std::string& text)
        : source("test.idl", text),
          file(parse::parse_file(tokenize(source, diagnostics), diagnostics)) {}

    Source source;
    Diagnostics diagnostics;
    ast::File file;
};

/// The tree, and what was said.
std::string parsed(const std::string& text) {
    const Parsed parsed{text};
    return ast::dump(parsed.file) + format(parsed.diagnostics, parsed.source);
}

/// What was said, each as "line:column text".
std::string messages(const std::string& text) {
    const Parsed parsed{text};
    std::string all;
    for (const Diagnostic& one : parsed.diagnostics.all()) {
        const Position place = parsed.source.position(one.where);
        all +=
            std::to_string(place.line) + ':' + std::to_string(place.column) + ' ' + one.text + '\n';
    }
    return all;
}

struct Case {
    const char* text;
    const char* tree;
};

void expect_trees(std::initializer_list<Case> cases) {
    for (const Case& one : cases) EXPECT_EQ(parsed(one.text), one.tree) << one.text;
}

void expect_messages(std::initializer_list<Case> cases) {
    for (const Case& one : cases) EXPECT_EQ(messages(one.text), one.tree) << one.text;
}

TEST(ParserTest, ReadsModulesAndInterfaces) {
    expect_trees({
        {"", ""},
        {"module A { module B { native C; }; };", "module A\n  module B\n    native C\n"},
        {"interface A;", "interface A (forward)\n"},
        {"interface A : B, ::C::D {};", "interface A: B, ::C::D\n"},
        {"local interface A; local interface A {};",
         "local interface A (forward)\nlocal interface A\n"},
        {"abstract interface A; abstract interface A : B {};",
         "abstract interface A (forward)\nabstract interface A: B\n"},
        {"interface _interface {};", "interface interface\n"},
        {"/// Text.\n@first_operation(1 << 4) interface A { void f(); };",
         "/// Text.\n@first_operation((<< 1 4))\ninterface A\n  void f()\n"},
        {"interface A { typedef long B; struct C {}; exception D {}; const long E = 1; native F; "
         "};",
         "interface A\n  typedef int32 B\n  struct C\n  exception D\n  const int32 E = 1\n"
         "  native F\n"},
    });
}

TEST(ParserTest, ReadsOperations) {
    expect_trees({
        {"interface A { oneway void f(in octet x); };",
         "interface A\n  oneway void f(in octet x)\n"},
        {"interface A { long f(out A a, inout string<3> s) raises (X, Y::Z) context (\"a.b\", "
         "\"c*\"); };",
         "interface A\n  int32 f(out A a, inout string<3> s) raises (X, Y::Z) context (\"a.b\", "
         "\"c*\")\n"},
        {"interface A { map<long, any> f(in map<long, long, 4> x); };",
         "interface A\n  map<int32, any> f(in map<int32, int32, 4> x)\n"},
        {"interface A { @a void f(@b(1) @c in long x, out @d long y); };",
         "interface A\n  @a\n  void f(@b(1) @c in int32 x, @d out int32 y)\n"},
    });
}

TEST(ParserTest, ReadsAttributes) {
    expect_trees({
        {"interface A { readonly attribute long x, y; };",
         "interface A\n  readonly attribute int32 x\n  readonly attribute int32 y\n"},
        {"interface A { readonly attribute long x raises (E, F); };",
         "interface A\n  readonly attribute int32 x getraises (E, F)\n"},
        {"interface A { attribute float z getraises (E) setraises (::F); };",
         "interface A\n  attribute float z getraises (E) setraises (::F)\n"},
        {"interface A { attribute long x setraises (E); attribute long getraises; };",
         "interface A\n  attribute int32 x setraises (E)\n  attribute int32 getraises\n"},
    });
}

TEST(ParserTest, ReadsTypes) {
    expect_trees({
        {"typedef long A, B[2][3];", "typedef int32 A\ntypedef int32 B[2][3]\n"},
        {"struct A { boolean a; char b; wchar c; octet d; short e; unsigned short f; long g; };",
         "struct A\n  boolean a\n  char b\n  wchar c\n  octet d\n  int16 e\n  uint16 f\n"
         "  int32 g\n"},
        {"struct A { unsigned long a; long long b; unsigned long long c; float d; double e; };",
         "struct A\n  uint32 a\n  int64 b\n  uint64 c\n  float d\n  double e\n"},
        {"struct A { long double a; any b; Object c; string d; wstring e; fixed<5, 2> f; };",
         "struct A\n  long double a\n  any b\n  Object c\n  string d\n  wstring e\n"
         "  fixed<5, 2> f\n"},
        {"typedef sequence<sequence<long, 4>> A;", "typedef sequence<sequence<int32, 4>> A\n"},
        {"typedef sequence<sequence<sequence<wstring<3>>>> A;",
         "typedef sequence<sequence<sequence<wstring<3>>>> A\n"},
        {"typedef map<string<3>, map<long, A::B>, 9> A;",
         "typedef map<string<3>, map<int32, A::B>, 9> A\n"},
        {"typedef string<(16 >> 2)> A;", "typedef string<(>> 16 2)> A\n"},
        {"typedef string<16>>2> A;", "typedef string<(>> 16 2)> A\n"},
        {"typedef sequence<string<16>>2>> A;", "typedef sequence<string<(>> 16 2)>> A\n"},
        {"typedef ::A::B C; typedef CORBA::Object D; typedef CORBA::TypeCode E;",
         "typedef ::A::B C\ntypedef CORBA::Object D\ntypedef CORBA::TypeCode E\n"},
    });
}

TEST(ParserTest, ReadsConstants) {
    expect_trees({
        {"const long a = 1 + 2 * 3;", "const int32 a = (+ 1 (* 2 3))\n"},
        {"const long a = 1 - 2 - 3;", "const int32 a = (- (- 1 2) 3)\n"},
        {"const long a = 1 | 2 ^ 3 & 4 << 5;", "const int32 a = (| 1 (^ 2 (& 3 (<< 4 5))))\n"},
        {"const long a = -(1 + ~2) % A::b;", "const int32 a = (% (- (+ 1 (~ 2))) A::b)\n"},
        {"const long long a = -9223372036854775808;", "const int64 a = (- 9223372036854775808)\n"},
        {"const octet a = 017; const octet b = 0xfF; const octet c = 0;",
         "const octet a = 15\nconst octet b = 255\nconst octet c = 0\n"},
        {"const string<9> a = \"x\" \"y\\n\\\"\\xf6\";",
         "const string<9> a = \"xy\\n\\\"\\xf6\"\n"},
        {"const wstring a = L\"x\" L\"\\u20ac\";", "const wstring a = L\"x\\u20ac\"\n"},
        {"const char a = '\\''; const wchar b = L'\\xff';",
         "const char a = '\\''\nconst wchar b = L'\\u00ff'\n"},
        {"const boolean a = TRUE | FALSE;", "const boolean a = (| TRUE FALSE)\n"},
        {"const float a = 1.; const double b = .5; const double c = 1.5E-3; const double d = 1e3;",
         "const float a = 1.0\nconst double b = 0.5\nconst double c = 0.0015\n"
         "const double d = 1000.0\n"},
        {"const fixed a = 012.50d; const fixed b = -.5D;",
         "const fixed a = 012.50d\nconst fixed b = (- .5d)\n"},
    });
}

TEST(ParserTest, ReadsStructsAndExceptions) {
    expect_trees({
        {"struct A {};", "struct A\n"},
        {"struct A; struct A { sequence<A> a; };",
         "struct A (forward)\nstruct A\n  sequence<A> a\n"},
        {"struct A { long x, y[2]; sequence<long> z[3]; };",
         "struct A\n  int32 x\n  int32 y[2]\n  sequence<int32> z[3]\n"},
        {"struct A : ::B::C { long x; };", "struct A: ::B::C\n  int32 x\n"},
        {"exception A {}; exception B { string why; };",
         "exception A\nexception B\n  string why\n"},
        {"struct A {\n// One.\n@key @id(3) long x, @optional y; };",
         "struct A\n  // One.\n  @key\n  @id(3)\n  int32 x\n  // One.\n  @key\n  @id(3)\n"
         "  @optional\n  int32 y\n"},
    });
}

TEST(ParserTest, ReadsEnumsAndBitmasks) {
    expect_trees({
        {"enum A { B, C };", "enum A: B C\n"},
        {"enum A { @default_literal B, @value(4) C };", "enum A: @default_literal B @value(4) C\n"},
        {"@bit_bound(8) bitmask A { B, @position(7) C };",
         "@bit_bound(8)\nbitmask A: B @position(7) C\n"},
    });
}

TEST(ParserTest, ReadsUnions) {
    expect_trees({
        {"union A; union A switch (long) { case 1: long x; case -2: case B::c: default: A y[2]; };",
         "union A (forward)\nunion A switch (int32)\n  case 1: int32 x\n"
         "  case (- 2): case B::c: default: A y[2]\n"},
        {"union A switch (@key octet) {\n/// One.\n@a case 1: @b long x; };",
         "union A switch (@key octet)\n  /// One.\n  @a\n  @b\n  case 1: int32 x\n"},
        {"union A switch (enum B { C, D }) { case C: struct E { long x; } y; };",
         "union A switch (B)\n  enum B: C D\n  struct E\n    int32 x\n  case C: E y\n"},
    });
}

TEST(ParserTest, TakesTypesOutThatAreDeclaredInPlace) {
    expect_trees({
        {"typedef struct S { long x; } T, U[3];",
         "struct S\n  int32 x\ntypedef S T\ntypedef S U[3]\n"},
        {"typedef enum A { B } C; typedef union D switch (long) { case 1: long x; } E;",
         "enum A: B\ntypedef A C\nunion D switch (int32)\n  case 1: int32 x\ntypedef D E\n"},
        {"struct S { struct T { enum E { P } e; } a, b[2]; };",
         "struct S\n  struct T\n    enum E: P\n    E e\n  T a\n  T b[2]\n"},
        {"struct S { bitmask B { F } b; }; exception X { union U switch (long) { case 1: long x; } "
         "u; };",
         "struct S\n  bitmask B: F\n  B b\nexception X\n  union U switch (int32)\n"
         "    case 1: int32 x\n  U u\n"},
    });
}

TEST(ParserTest, ReadsAnnotations) {
    expect_trees({
        {"@a() @::b::c(1) @default(x = -1, y = \"z\") typedef long A;",
         "@a\n@::b::c(1)\n@default(x = (- 1), y = \"z\")\ntypedef int32 A\n"},
        {"@a module A { @b const long c = 1; }; @d interface E; @f native G;",
         "@a\nmodule A\n  @b\n  const int32 c = 1\n@d\ninterface E (forward)\n@f\nnative G\n"},
        {"interface A { @a readonly attribute @b long x; @c exception D {}; };",
         "interface A\n  @a\n  @b\n  readonly attribute int32 x\n  @c\n  exception D\n"},
        {"@annotation A { enum B { C }; const long D = 1; typedef long E; B f default C; string g; "
         "any h; };",
         "@annotation A\n  enum B: C\n  const int32 D = 1\n  typedef int32 E\n  B f default C\n"
         "  string g\n  any h\n"},
        {"@annotation annotation {}; @annotation struct A {};",
         "@annotation annotation\n@annotation\nstruct A\n"},
    });
    EXPECT_EQ(messages("typedef sequence<@external long> A;"),
              "1:18 annotations of elements are ignored\n");
}

TEST(ParserTest, ReadsRepositoryIds) {
    expect_trees({
        {"#pragma prefix \"x\"\nmodule A {\n#pragma prefix \"y\"\ninterface B {\n"
         "#pragma ID C \"z\"\ntypedef long C;\n#pragma version C 1.10\n};\n};\n#pragma prefix "
         "\"\"\n",
         "#pragma prefix \"x\"\nmodule A\n  #pragma prefix \"y\"\n  interface B\n"
         "    #pragma ID C \"z\"\n    typedef int32 C\n    #pragma version C 1.10\n"
         "#pragma prefix \"\"\n"},
        {"struct A {\n#pragma version A 2.0\nlong x; };\n",
         "struct A\n  int32 x\n#pragma version A 2.0\n"},
        {"typeid ::A \"x\"; typeprefix A::B \"y\"; interface C { typeid D \"z\"; };",
         "typeid ::A \"x\"\ntypeprefix A::B \"y\"\ninterface C\n  typeid D \"z\"\n"},
    });
    expect_messages({
        {"#pragma prefix x\n", "1:16 this #pragma is written #pragma prefix \"example.com\"\n"},
        {"#pragma prefix \"x\" y\n", "1:20 expected the end of the #pragma, not 'y'\n"},
        {"#pragma ID A\n", "1:13 this #pragma is written #pragma ID Name \"IDL:Name:1.0\"\n"},
        {"#pragma version A 2\n", "1:19 this #pragma is written #pragma version Name 1.0\n"},
        {"#pragma version A .2\n", "1:19 this #pragma is written #pragma version Name 1.0\n"},
        {"#pragma version A 1e3\n", "1:19 this #pragma is written #pragma version Name 1.0\n"},
        {"#pragma version A 1.2.3\n", "1:22 expected the end of the #pragma, not '.3'\n"},
        {"typeid A;", "1:1 'typeid' is followed by a name and a string\n"},
    });
}

TEST(ParserTest, LeavesTheWordsOfLaterVersionsFree) {
    expect_trees({
        {"interface Map {}; typedef octet uint8; struct bitset { uint8 port; int16 x; };",
         "interface Map\ntypedef octet uint8\nstruct bitset\n  uint8 port\n  int16 x\n"},
        {"typedef long map; interface A { map map(in bitmask bitmask); };",
         "typedef int32 map\ninterface A\n  map map(in bitmask bitmask)\n"},
        {"interface A { typeid f(in typeid typeid); attribute component home; };",
         "interface A\n  typeid f(in typeid typeid)\n  attribute component home\n"},
        {"typedef Object _Factory; typedef Factory A; const long b = Factory;",
         "typedef Object Factory\ntypedef Factory A\nconst int32 b = Factory\n"},
        // Of a valuetype no more than its name.
        {"valuetype A : supports B { public long x; factory f(in long a); }; typedef long Z;",
         "valuetype A\ntypedef int32 Z\n"},
        {"valuetype A; valuetype A sequence<long>;", "valuetype A\nvaluetype A\n"},
        {"abstract valuetype A { void f(); }; custom valuetype B { public long x; };",
         "valuetype A\nvaluetype B\n"},
        {"typedef long int; struct S { int x; };", "typedef int32 int\nstruct S\n  int x\n"},
    });
}

TEST(ParserTest, NamesWhatIsNotSupportedOnce) {
    const char* const constructs[][2] = {
        {"eventtype A { public long x; };", "'eventtype'"},
        {"abstract eventtype A { };", "'eventtype'"},
        {"component A : B { provides C c; uses multiple D d; };", "'component'"},
        {"component A;", "'component'"},
        {"home A manages B { factory f(); };", "'home'"},
        {"porttype A { uses B b; };", "'porttype'"},
        {"connector A { port B b; };", "'connector'"},
        {"import ::A;", "'import'"},
        {"import \"A\";", "'import'"},
        {"bitset A { bitfield<3> x; bitfield<1> y; };", "'bitset'"},
        {"module A<typename T> { typedef T B; };", "a template module"},
        {"module A<long> B;", "a template module"},
    };
    for (const auto& [text, feature] : constructs) {
        const std::string message =
            std::string{feature} + " is not supported (see doc/idl-support.md)\n";
        const std::string said = messages(std::string{text} + " typedef long Z;");
        EXPECT_EQ(said.substr(said.find(' ') + 1), message) << text;
        EXPECT_TRUE(parsed(std::string{text} + " typedef long Z;").starts_with("typedef int32 Z\n"))
            << text;
    }
    EXPECT_EQ(messages("typedef ValueBase A;"),
              "1:9 'ValueBase' is not supported (see doc/idl-support.md)\n");
}

TEST(ParserTest, RefusesWhatIsNoDeclaration) {
    expect_messages({
        {"module A {};", "1:8 a module has at least one declaration\n"},
        {"module A::B { native C; };",
         "1:9 a module's name has one part: nest modules to name inner ones\n"},
        {"struct A { long x; };;", "1:22 there is no declaration here: leave this ';' out\n"},
        {"interface A { ; void f();; };",
         "1:15 there is no declaration here: leave this ';' out\n"
         "1:26 there is no declaration here: leave this ';' out\n"},
        {"struct A { long x;; };", "1:19 there is no member here: leave this ';' out\n"},
        {"};", "1:1 this '}' closes nothing\n"},
        {"long x;", "1:1 expected a declaration, not 'long'\n"},
        {"attribute long x;", "1:1 'attribute' belongs inside an interface\n"},
        {"native A, B;", "1:9 expected ';' after the declaration\n"},
        {"abstract struct A {};", "1:10 expected 'interface' after 'abstract', not 'struct'\n"},
        {"interface A { module B {}; interface C; };",
         "1:15 'module' cannot be declared inside an interface\n"
         "1:28 'interface' cannot be declared inside an interface\n"},
        {"interface A : {};", "1:15 expected the name of a base interface, not '{'\n"},
        {"interface A : B, {};", "1:18 expected the name of a base interface, not '{'\n"},
        {"@a", "1:3 expected a declaration, not the end of the file\n"},
        {"@1 typedef long A;", "1:2 expected the annotation's name, not '1'\n"},
        {"interface A", "1:12 expected '{' after the interface's name, not the end of the file\n"},
    });
}

TEST(ParserTest, RefusesTypes) {
    expect_messages({
        {"typedef struct S T;", "1:16 write 'S' without 'struct': only its declaration has it\n"},
        {"struct A { struct B; };", "1:20 expected '{' after the struct's name, not ';'\n"},
        {"struct A : B, C {};", "1:13 a struct has one base at most\n"},
        {"exception A : B {};", "1:13 exceptions do not inherit\n"},
        {"struct A { typedef long x; const long y = 1; void z; };",
         "1:12 'typedef' cannot stand among members\n1:28 'const' cannot stand among members\n"
         "1:46 only an operation's result can be void\n"},
        {"enum A {};", "1:9 expected the name of an enumerator, not '}'\n"},
        {"enum A { B, };", "1:11 no ',' stands behind the last one\n"},
        {"enum A { B C };", "1:12 expected ',' or '}' after an enumerator, not 'C'\n"},
        {"union A switch (long) {};", "1:24 a union has at least one case\n"},
        {"union A { long x; };",
         "1:9 a union says first what selects its member: 'switch (long)'\n"},
        {"union A switch (long) { long x; };", "1:25 expected 'case' or 'default', not 'long'\n"},
        {"union A switch (long) { case 1: long x, y; };", "1:39 a case has one member\n"},
        {"union A switch (long) { case 1, 2: long x; };",
         "1:31 each label of a case is written for itself: 'case 1: case 2:'\n"},
        {"struct A { long[3] x; };", "1:16 the size of an array stands behind its name\n"},
        {"union A switch (long) { case 1: };", "1:33 a case has one member\n"},
        {"typedef fixed A;", "1:15 expected '<' after 'fixed', not 'A'\n"},
        {"const fixed<3, 1> a = 1d;",
         "1:7 a constant has its digits from its value: write 'fixed' only\n"},
        {"typedef string<> A;", "1:16 expected a constant value, not '>'\n"},
        {"typedef sequence<struct A {}> B;",
         "1:18 declare the struct before, and write its name alone here\n"},
        {"interface A { sequence<long> f(in fixed<3, 2> x); attribute sequence<long> y; };",
         "1:15 the type of a result needs a name: declare it by 'typedef' before\n"
         "1:35 the type of a parameter needs a name: declare it by 'typedef' before\n"
         "1:61 the type of an attribute needs a name: declare it by 'typedef' before\n"},
        {"typedef long A[];",
         "1:16 an array has a size: write a number here, or 'sequence<...>' instead\n"},
    });
}

TEST(ParserTest, RefusesConstants) {
    expect_messages({
        {"const string a = \"a\" L\"b\";", "1:22 a string and a wide string do not make one\n"},
        {"const wstring a = L\"a\" \"b\";", "1:24 a string and a wide string do not make one\n"},
        {"const long a = 08;",
         "1:16 a number that begins with 0 is octal, and has digits 0 to 7 only\n"},
        {"const long a = 0x;", "1:16 this is no number\n"},
        {"const long a = 0x1FFFFFFFFFFFFFFFF;",
         "1:16 this number is larger than any type of IDL holds\n"},
        {"const double a = 1e99999;", "1:18 this number is out of the range of long double\n"},
        {"const fixed a = 0001234567890123456789012345678901.000d;", ""},
        {"const fixed a = 12345678901234567890123456789012d;",
         "1:17 a fixed-point number has at most 31 digits\n"},
        {"const long a[2] = 1;", "1:13 a constant is no array\n"},
        {"const boolean a = true;", "1:19 'true' differs only in case from the keyword 'TRUE'\n"},
    });
}

TEST(ParserTest, RefusesOperationsAndAttributes) {
    expect_messages({
        {"interface A { void f() raises (); };",
         "1:32 expected the name of an exception, not ')'\n"},
        {"interface A { void f() context (); };",
         "1:33 expected a context's name in quotes, not ')'\n"},
        {"interface A { void f() context (\"*a\", \"\", \"a-b\"); };",
         "1:33 a context's name is letters, digits, '.' and '_' after a letter, and may end in "
         "'*'\n"
         "1:39 a context's name is letters, digits, '.' and '_' after a letter, and may end in "
         "'*'\n"
         "1:43 a context's name is letters, digits, '.' and '_' after a letter, and may end in "
         "'*'\n"},
        {"interface A { attribute long x raises (B); };",
         "1:32 an attribute that can be set has 'getraises' and 'setraises'\n"},
        {"interface A { readonly attribute long x setraises (B); };",
         "1:41 a readonly attribute is never set\n"},
        {"interface A { attribute long x, y getraises (B); };",
         "1:35 'getraises' belongs to one attribute: declare each by itself\n"},
        {"interface A { attribute readonly long x; };", "1:25 write 'readonly attribute'\n"},
        {"interface A { readonly long x; };",
         "1:24 expected 'attribute' after 'readonly', not 'long'\n"},
        {"interface A { attribute void x; };",
         "1:25 an attribute cannot be void: only an operation returns it\n"},
        {"interface A { void f(in void x); };",
         "1:25 a parameter cannot be void: only an operation returns it\n"},
        {"interface A { long x; };",
         "1:21 expected '(' after the operation's name; an attribute is written 'attribute' before "
         "its type\n"},
        {"interface A { void f(in long x in long y); };",
         "1:32 expected ',' or ')' after the parameter, not 'in'\n"},
        {"interface A { void f(in long x; out long y); };",
         "1:31 between parameters there is ',', not ';'\n"},
    });
}

TEST(ParserTest, HelpsWithWordsOfOtherLanguages) {
    expect_messages({
        {"struct A { int x; bool y; byte z; uint8_t u; String s; };",
         "1:12 IDL has no 'int': write 'long' or 'int32'\n"
         "1:19 IDL has no 'bool': write 'boolean'\n"
         "1:27 IDL has no 'byte': write 'octet' or 'uint8'\n"
         "1:35 IDL has no 'uint8_t': write 'octet' or 'uint8'\n"
         "1:46 'String' differs only in case from the keyword 'string'\n"},
        {"struct A { unsigned int x; unsigned char y; unsigned z; };",
         "1:21 IDL has no 'int': write 'unsigned long' or 'uint32'\n"
         "1:37 IDL has no 'unsigned char': write 'octet' or 'uint8'\n"
         "1:54 expected 'short' or 'long' after 'unsigned', not 'z'\n"},
        {"struct A { long long long x; long int y; signed char z; long unsigned u; };",
         "1:22 no type is longer than 'long long'\n"
         "1:35 IDL has no 'int': leave it out here\n"
         "1:42 IDL has no 'signed': leave it out, and write 'int8' for a 'signed char'\n"
         "1:62 write 'unsigned' before 'long'\n"},
        {"struct A { std::string x; vector<long> y; unsigned long double z; };",
         "1:12 IDL has no 'std::': leave it out\n"
         "1:33 'vector' takes no arguments: a list is 'sequence<...>'\n"
         "1:52 'long double' has a sign always\n"},
        {"struct A { long* x; long y = 1; long f(); };",
         "1:16 IDL has no pointers and no references: leave the '*' out\n"
         "1:28 members have no default values: write @default(value) before the member\n"
         "1:39 an operation cannot stand among members, only in an interface\n"},
        {"enum class A { B = 1, C };",
         "1:6 an enum of IDL is no class: leave 'class' out\n"
         "1:18 the value of an enumerator is written @value(n) before its name\n"},
        {"class A { long x; void f(); };", "1:1 IDL has no 'class': write 'interface'\n"},
        {"namespace A { native B; };", "1:1 IDL has no 'namespace': write 'module'\n"},
        {"interface A : public B { public: void f(); };",
         "1:15 an interface inherits without 'public'\n"
         "1:26 all of an interface is public: leave 'public:' out\n"},
        {"interface A { void f(long x, const long& y); void g(void); };",
         "1:22 expected 'in', 'out' or 'inout' before the parameter's type, not 'long'\n"
         "1:30 IDL has no 'const' parameters: 'in' says it\n"
         "1:40 IDL has no pointers and no references: leave the '&' out\n"
         "1:53 an operation without parameters has nothing in its parentheses\n"},
        {"interface A { void f(in long x = 5, in long y[3]) const; };",
         "1:32 parameters have no default values\n"
         "1:46 the type of a parameter needs a name: declare the array by 'typedef' before\n"
         "1:51 operations of IDL are never 'const'\n"},
        {"interface A { void f() { if (x) { y; } } void g(); };",
         "1:24 IDL declares operations and has no code for them: write ';' here\n"},
        {"typedef long union;",
         "1:14 expected the new type's name, but 'union' is a keyword (write '_union' to use it as "
         "a name)\n"},
        {"typedef long Union;",
         "1:14 'Union' differs only in case from the keyword 'union' (write '_Union')\n"},
    });
}

TEST(ParserTest, GoesOnBehindAnError) {
    EXPECT_EQ(parsed("struct A { long; octet x; }; typedef long B;"),
              "struct A\n  octet x\n"
              "typedef int32 B\n"
              "test.idl:1:16: error: expected the member's name, not ';'\n"
              "struct A { long; octet x; }; typedef long B;\n"
              "               ^\n");
    expect_messages({
        {"struct A { long x\n octet y; }\nenum B { C }\ninterface D { void f()\n void g(); };",
         "1:18 expected ';' after the member\n2:12 expected ';' after the declaration\n"
         "3:13 expected ';' after the declaration\n4:23 expected ';' after the operation\n"},
        {"typedef long A typedef long B; typedef long C D; typedef E;",
         "1:15 expected ';' after the declaration\n1:46 expected ';' after the declaration\n"
         "1:59 expected the new type's name, not ';'\n"},
        {"class A { long x; }\ntypedef B;",
         "1:1 IDL has no 'class': write 'interface'\n2:10 expected the new type's name, not ';'\n"},
        {"enum A { 1, 2 }; union B switch (long) { case: long x; case 2: y; }; typedef C;",
         "1:10 expected the name of an enumerator, not '1'\n1:46 expected a constant value, not "
         "':'\n1:65 expected the member's name, not ';'\n1:79 expected the new type's name, not "
         "';'\n"},
    });
}

TEST(ParserTest, SaysWhereAnUnclosedBraceIs) {
    expect_messages({
        {"module A {\n  interface B {\n    void f();\n};\n",
         "5:1 expected '}' before the end of the file\n1:10 to close this '{'\n"},
        {"struct A {\n  long x;\n\ninterface B {};\nmodule C { native D; };\n",
         "4:1 expected '}' before 'interface'\n1:10 to close this '{'\n"},
        {"module M {\n  interface A {\n    void f();\n  interface B {};\n};\n",
         "4:3 expected '}' before 'interface'\n2:15 to close this '{'\n"},
        {"enum A {\n  B, C\nstruct D {};\n",
         "3:1 expected '}' before 'struct'\n1:8 to close this '{'\n"},
        {"union A switch (long) {\n  case 1: long x;\nstruct D {};\n",
         "3:1 expected '}' before 'struct'\n1:23 to close this '{'\n"},
        {"interface A { void f() { ",
         "1:24 IDL declares operations and has no code for them: write ';' here\n"
         "1:26 expected '}' before the end of the file\n1:24 to close this '{'\n"},
    });
}

TEST(ParserTest, ReadsDeepNestingWithinReason) {
    EXPECT_EQ(messages("const long a = " + std::string(50, '(') + '1' + std::string(50, ')') + ';'),
              "");
}

TEST(ParserTest, SurvivesDeepNesting) {
    const auto repeated = [](const std::string& text) {
        std::string all;
        for (int i = 0; i < 10000; ++i) all += text;
        return all;
    };
    const std::string texts[] = {
        repeated("module A { "),
        repeated("struct A { "),
        repeated("union A switch (long) { case 1: "),
        repeated("union A switch ("),
        "typedef " + repeated("sequence<"),
        "typedef " + repeated("map<long,"),
        "const long a = " + repeated("-(") + "1;",
        "const long a = " + repeated("("),
        "const long a = 1" + repeated(" + 1") + ";",
        "typedef long A" + repeated("[1]") + ";",
    };
    for (const std::string& text : texts) {
        const std::string said = messages(text);
        EXPECT_TRUE(said.find("nested too deeply") != std::string::npos ||
                    said.find("too long an expression") != std::string::npos)
            << text.substr(0, 40);
    }
}

// What is cut off, or has a token too few or too many, is refused or read: it never crashes.
TEST(ParserTest, SurvivesWhatIsCutOff) {
    const std::string text =
        "#pragma prefix \"x\"\n@annotation N { long a default 1; };\n@a(b = 1) module M { typedef "
        "struct S : T { map<long, string<2>> x[2], y; } U; enum E { @value(1) A, B }; bitmask F { "
        "G }; union V switch (enum W { X }) { case X: default: long y; }; const wstring c = "
        "L\"a\" L\"b\"; const fixed d = -(1.5d + 'c'); local interface I : J { readonly attribute "
        "long a raises (O); attribute long b getraises (O) setraises (O); oneway void f(in "
        "unsigned long long x, inout O::P y) raises (O) context (\"z\"); typeid I \"i\"; }; native "
        "Q; valuetype R { public long x; }; };";
    const Source source{"test.idl", text};
    Diagnostics none;
    const std::vector<Token> tokens = tokenize(source, none);
    EXPECT_FALSE(none.failed());
    for (std::size_t i = 0; i + 1 < tokens.size(); ++i) {
        std::vector<Token> cut = tokens;
        cut.erase(cut.begin() + static_cast<std::ptrdiff_t>(i));
        Diagnostics diagnostics;
        ast::dump(parse::parse_file(cut, diagnostics));
        cut.insert(cut.begin() + static_cast<std::ptrdiff_t>(i), 2, tokens[i]);
        ast::dump(parse::parse_file(cut, diagnostics));
        cut.erase(cut.begin() + static_cast<std::ptrdiff_t>(i), cut.end() - 1);
        Diagnostics cut_off;
        ast::dump(parse::parse_file(cut, cut_off));
    }
}

}  // namespace
}  // namespace canorb::idlc
