#include "idlc/lexer.hpp"

#include <gtest/gtest.h>

#include <string>

namespace canorb::idlc {
namespace {

/// The tokens on one line, each as its kind's first letter and its text.
std::string dump(const std::string& text) {
    const Source source{"test.idl", text};
    Diagnostics diagnostics;
    std::string line;
    for (const Token& token : tokenize(source, diagnostics)) {
        constexpr std::string_view kinds = "iknfcsp.";
        if (!line.empty()) line += ' ';
        line += kinds[static_cast<std::size_t>(token.kind)];
        if (token.kind != TokenKind::end) line += ':' + std::string{token.text};
        for (const std::string& comment : token.comment) line += '[' + comment + ']';
    }
    return line + (diagnostics.failed() ? " failed" : "");
}

TEST(LexerTest, FindsTokens) {
    struct Case {
        const char* text;
        const char* tokens;
    };
    const Case cases[] = {
        {"", "."},
        {"module A {};", "k:module i:A p:{ p:} p:; ."},
        {"a::b", "i:a p::: i:b ."},
        {"_module __x", "i:module i:unnamed . failed"},
        {"port home provides", "i:port i:home i:provides ."},
        {"0 17 0x1F 007", "n:0 n:17 n:0x1F n:007 ."},
        {"1.5 .5 1. 1e3 1.5E-3 1e", "f:1.5 f:.5 f:1. f:1e3 f:1.5E-3 n:1 . failed"},
        {"'a' '\\n' \"text\" \"a\\\"b\"", "c:'a' c:'\\n' s:\"text\" s:\"a\\\"b\" ."},
        {"1<<2>>3", "n:1 p:<< n:2 p:>> n:3 ."},
        {"@first_operation(16)", "p:@ i:first_operation p:( n:16 p:) ."},
        {"a ? b", "i:a i:b . failed"},
        {"a /* never ends", "i:a . failed"},
        {"gr\xc3\xb6\xc3\x9f"
         "e x",
         "i:gr\xc3\xb6\xc3\x9f"
         "e i:x . failed"},
        {"TRUE true", "k:TRUE i:true . failed"},
    };
    for (const Case& one : cases) EXPECT_EQ(dump(one.text), one.tokens) << one.text;
}

TEST(LexerTest, GivesCommentsToWhatIsBehindThem) {
    struct Case {
        const char* text;
        const char* tokens;
    };
    const Case cases[] = {
        {"// one\n/// two\nx", "i:x[// one][/// two] ."},
        {"/** A line.\n *  Another.\n */\nx", "i:x[/// A line.][/// Another.] ."},
        {"/* plain */ x", "i:x[// plain] ."},
        {"// far away\n\nx", "i:x ."},
        {"x // behind\ny", "i:x i:y ."},
        {"x /* behind */\n// before\ny", "i:x i:y[// before] ."},
        {"// ends in \\\\\nx", "i:x[// ends in ] ."},
    };
    for (const Case& one : cases) EXPECT_EQ(dump(one.text), one.tokens) << one.text;
}

TEST(LexerTest, ResolvesEscapes) {
    const Source source{"test.idl", R"("a\tb\x41\101\\\"")"};
    Diagnostics diagnostics;
    const auto tokens = tokenize(source, diagnostics);
    EXPECT_FALSE(diagnostics.failed());
    EXPECT_EQ(tokens.front().value, "a\tbAA\\\"");
}

TEST(LexerTest, KnowsWhereTokensAre) {
    const Source source{"test.idl", "a\n  b\n"};
    Diagnostics diagnostics;
    const auto tokens = tokenize(source, diagnostics);
    EXPECT_EQ(tokens[1].where, Location{4});
    EXPECT_EQ(source.position(tokens[1].where).line, 2U);
}

}  // namespace
}  // namespace canorb::idlc
