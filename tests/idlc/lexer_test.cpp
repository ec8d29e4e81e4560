#include "idlc/lexer.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace canorb::idlc {
namespace {

struct Tokens {
    explicit Tokens(const std::string& text)
        : source("test.idl", text), list(tokenize(source, diagnostics)) {}

    Source source;
    Diagnostics diagnostics;
    std::vector<Token> list;
};

/// The tokens on one line, each as a sign of its kind and its text.
std::string dump(const std::vector<Token>& tokens) {
    std::string line;
    for (const Token& token : tokens) {
        constexpr std::string_view kinds = "iknfdcCsSp.";
        if (!line.empty()) line += ' ';
        for (const Directive& directive : token.directives) {
            line += "#(" + dump(directive.tokens) + ") ";
        }
        line += kinds[static_cast<std::size_t>(token.kind)];
        if (token.kind != TokenKind::end) line += ':' + std::string{token.text};
        for (const std::string& comment : token.comment) line += '[' + comment + ']';
    }
    return line;
}

std::string dump(const std::string& text) {
    const Tokens tokens{text};
    return dump(tokens.list) + (tokens.diagnostics.failed() ? " failed" : "");
}

/// What is said about a text, without the places.
std::string messages(const std::string& text) {
    const Tokens tokens{text};
    std::string all;
    for (const Diagnostic& one : tokens.diagnostics.all()) all += one.text + '\n';
    return all;
}

struct Case {
    const char* text;
    const char* tokens;
};

TEST(LexerTest, FindsTokens) {
    const Case cases[] = {
        {"", "."},
        {"module A {};", "k:module i:A p:{ p:} p:; ."},
        {"a::b", "i:a p::: i:b ."},
        {"_module __x", "i:module i:unnamed . failed"},
        {"component home getraises typeid", "i:component i:home i:getraises i:typeid ."},
        {"map bitmask bitset int8 uint64", "i:map i:bitmask i:bitset i:int8 i:uint64 ."},
        {"0 17 0x1F 007", "n:0 n:17 n:0x1F n:007 ."},
        {"1.5 .5 1. 1e3 1.5E-3 1e", "f:1.5 f:.5 f:1. f:1e3 f:1.5E-3 n:1 . failed"},
        {"12.5d 1D .5d 5.d 1e3d 0x1d", "d:12.5d d:1D d:.5d d:5.d f:1e3 n:0x1d . failed"},
        {"10L 1.5f", "n:10 f:1.5 . failed"},
        {"'a' '\\n' \"text\" \"a\\\"b\"", "c:'a' c:'\\n' s:\"text\" s:\"a\\\"b\" ."},
        {"L'a' L\"text\" L L2", "C:L'a' S:L\"text\" i:L i:L2 ."},
        {"1<<2>>3", "n:1 p:<< n:2 p:>> n:3 ."},
        {"@first_operation(16)", "p:@ i:first_operation p:( n:16 p:) ."},
        {"@default @Default", "p:@ k:default p:@ i:Default ."},
        {"a ? b", "i:a i:b . failed"},
        {"a /* never ends", "i:a . failed"},
        {"gr\xc3\xb6\xc3\x9f"
         "e x",
         "i:gr\xc3\xb6\xc3\x9f"
         "e i:x . failed"},
        {"a\fb\vc\r\nd", "i:a i:b i:c i:d ."},
    };
    for (const Case& one : cases) EXPECT_EQ(dump(one.text), one.tokens) << one.text;
}

TEST(LexerTest, KnowsWordsThatDifferFromKeywordsInCaseOnly) {
    EXPECT_EQ(collides_with_keyword("Interface"), "interface");
    EXPECT_EQ(collides_with_keyword("true"), "TRUE");
    EXPECT_EQ(collides_with_keyword("interface"), "");
    EXPECT_EQ(collides_with_keyword("Map"), "");
    EXPECT_EQ(collides_with_keyword("Component"), "");
}

TEST(LexerTest, GivesCommentsToWhatIsBehindThem) {
    const Case cases[] = {
        {"// one\n/// two\nx", "i:x[// one][/// two] ."},
        {"/** A line.\n *  Another.\n */\nx", "i:x[/// A line.][/// Another.] ."},
        {"/* plain */ x", "i:x[// plain] ."},
        {"// far away\n\nx", "i:x ."},
        {"x // behind\ny", "i:x i:y ."},
        {"x /* behind */\n// before\ny", "i:x i:y[// before] ."},
        {"// ends in \\\\\nx", "i:x[// ends in ] ."},
        {"// gr\xfc\xdf\nx", "i:x[// gr\xfc\xdf] ."},
    };
    for (const Case& one : cases) EXPECT_EQ(dump(one.text), one.tokens) << one.text;
}

TEST(LexerTest, GivesPragmasToWhatIsBehindThem) {
    const Case cases[] = {
        {"#pragma prefix \"x\"\na", "#(i:prefix s:\"x\" .) i:a ."},
        {"a\n #  pragma ID A::B \"x\" // why\n#pragma version A 1.10\n",
         "i:a #(i:ID i:A p::: i:B s:\"x\" .) #(i:version i:A f:1.10 .) ."},
        {"#pragma hh don't\n#ident \"x\"\n#warning it's fine\n# 12\n#line 3\na", "i:a ."},
        {"#define A\na", "i:a . failed"},
        {"a #pragma prefix \"x\"", "i:a i:pragma i:prefix s:\"x\" . failed"},
        {"#pragma prefix #pragma prefix \"x\"\na",
         "#(i:prefix i:pragma i:prefix s:\"x\" .) i:a . failed"},
    };
    for (const Case& one : cases) EXPECT_EQ(dump(one.text), one.tokens) << one.text;
}

TEST(LexerTest, WarnsOfAnUnknownPragmaOnce) {
    EXPECT_EQ(messages("#pragma hh a\n#pragma hh b\n#pragma keylist X\n"),
              "unknown #pragma 'hh', ignored\nunknown #pragma 'keylist', ignored\n");
}

TEST(LexerTest, ResolvesEscapes) {
    const Tokens tokens{R"("a\tb\x41\101\\\"\?\'\a\b\f\v\r\n\x4g\1018" '\0' '\377')"};
    EXPECT_FALSE(tokens.diagnostics.failed());
    EXPECT_EQ(tokens.list[0].value, "a\tbAA\\\"?'\a\b\f\v\r\n\x04gA8");
    EXPECT_EQ(tokens.list[1].value, std::string(1, '\0'));
    EXPECT_EQ(tokens.list[2].value, "\xff");
}

TEST(LexerTest, ResolvesWideEscapes) {
    const Tokens tokens{R"(L"\u1\u12345\x414\777\n" L'\u20aC' L'\0')"};
    EXPECT_FALSE(tokens.diagnostics.failed());
    EXPECT_EQ(tokens.list[0].wide_value, u"\u0001\u12345A4\u01ff\n");
    EXPECT_EQ(tokens.list[1].wide_value, u"\u20ac");
    EXPECT_EQ(tokens.list[2].wide_value, std::u16string(1, u'\0'));
}

TEST(LexerTest, TakesOctetsOfNarrowLiteralsAsTheyAre) {
    const Tokens tokens{"\"\xc3\xb6\xf6\" '\xf6'"};
    EXPECT_FALSE(tokens.diagnostics.failed());
    EXPECT_EQ(tokens.list[0].value, "\xc3\xb6\xf6");
    EXPECT_EQ(tokens.list[1].value, "\xf6");
}

TEST(LexerTest, DecodesWideLiterals) {
    struct WideCase {
        const char* text;
        std::u16string value;
    };
    const WideCase cases[] = {
        {"L\"gr\xc3\xbc\xc3\x9f\"", u"gr\u00fc\u00df"},
        {"L\"\xe2\x82\xac\"", u"\u20ac"},
        {"L\"\xf0\x9f\x98\x80\"", u"\xd83d\xde00"},
        {"L\"\xf4\x8f\xbf\xbf\"", u"\xdbff\xdfff"},
        // No UTF-8: a lone octet, one cut off, overlong forms, a surrogate, beyond the last.
        {"L\"\xf6\"", u"\u00f6"},
        {"L\"\xe2\x82\"", u"\u00e2\u0082"},
        {"L\"\xc0\x80\"", u"\u00c0\u0080"},
        {"L\"\xe0\x80\x80\"", u"\u00e0\u0080\u0080"},
        {"L\"\xed\xa0\x80\"", u"\u00ed\u00a0\u0080"},
        {"L\"\xf4\x90\x80\x80\"", u"\u00f4\u0090\u0080\u0080"},
    };
    for (const WideCase& one : cases) {
        const Tokens tokens{one.text};
        EXPECT_FALSE(tokens.diagnostics.failed()) << one.text;
        EXPECT_EQ(tokens.list[0].wide_value, one.value) << one.text;
    }
}

TEST(LexerTest, RefusesLiterals) {
    constexpr const char* one_character = "a character literal is one character\n";
    constexpr const char* no_end = "this literal has no closing quote\n";
    const Case cases[] = {
        {"''", one_character},
        {"'ab'", one_character},
        {"L'ab'", one_character},
        {"'\\x123'", one_character},
        {"'\xc3\xb6'",
         "this character has several octets: write L before the quote, for a wchar\n"},
        {"L'\xf0\x9f\x98\x80'", "this character is beyond what a wchar holds\n"},
        {"'a", no_end},
        {"\"a\nb", no_end},
        {"L\"a\\", no_end},
        {"\"a\\0b\"", "a string cannot contain a NUL\n"},
        {"L\"a\\u0b\" L\"\\u0000\"", "a string cannot contain a NUL\n"},
        {"'\\400'", "this escape is no octet\n"},
        {"\"\\u0041\"", "\\u is for wide literals: write L before the quote\n"},
        {"\"\\x\"", "this escape has no digits\n"},
        {"\"\\q\"", "IDL does not define the escape '\\q', it is taken for 'q'\n"},
        {"L\"\\u\"", "IDL does not define the escape '\\u', it is taken for 'u'\n"},
        {"\"\\%\"", "IDL does not define this escape, its backslash is left out\n"},
    };
    for (const Case& one : cases) EXPECT_EQ(messages(one.text), one.tokens) << one.text;
}

TEST(LexerTest, KnowsWhereTokensAre) {
    const Tokens tokens{"a\n  b _c\n"};
    EXPECT_EQ(tokens.list[1].where, Location{4});
    EXPECT_EQ(tokens.source.position(tokens.list[1].where).line, 2U);
    EXPECT_TRUE(tokens.list[1].first_on_line);
    EXPECT_FALSE(tokens.list[2].first_on_line);
    EXPECT_TRUE(tokens.list[2].escaped);
    EXPECT_EQ(tokens.list[2].where, Location{6});
}

}  // namespace
}  // namespace canorb::idlc
