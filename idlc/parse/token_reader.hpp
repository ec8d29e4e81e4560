#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "idlc/ast.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/lexer.hpp"

namespace canorb::idlc::parse {

/// Thrown inside the parser only, once the error is reported: the declaration cannot be read on.
struct GiveUp {};

inline std::string quote(std::string_view text) {
    return '\'' + std::string{text} + '\'';
}

/// A place in the list of tokens, and how to get on from it.
class TokenReader {
  public:
    TokenReader(const std::vector<Token>& tokens, Diagnostics& diagnostics)
        : tokens_(tokens), diagnostics_(diagnostics) {}

  protected:
    static constexpr int deepest = 64;

    /// Counts nesting, against input that would exhaust the stack.
    class Level {
      public:
        explicit Level(TokenReader& reader) : reader_(reader) {
            if (++reader_.depth_ > deepest) {
                --reader_.depth_;
                reader_.fail("nested too deeply");
            }
        }
        ~Level() { --reader_.depth_; }
        Level(const Level&) = delete;
        Level& operator=(const Level&) = delete;

      private:
        TokenReader& reader_;
    };

    const Token& current() const { return tokens_[at_]; }
    const Token& next() const { return tokens_[at_ + 1 < tokens_.size() ? at_ + 1 : at_]; }
    void advance() {
        if (at_ + 1 < tokens_.size()) ++at_;
        half_taken_ = false;
    }
    bool is(std::string_view text) const {
        const Token& token = current();
        return (token.kind == TokenKind::keyword || token.kind == TokenKind::punctuation) &&
               token.text == text;
    }
    bool take(std::string_view text) {
        if (!is(text)) return false;
        advance();
        return true;
    }
    [[noreturn]] void fail(std::string text) {
        diagnostics_.error(current().where, std::move(text));
        throw GiveUp{};
    }
    [[noreturn]] void fail_expected(const std::string& what) {
        const Token& token = current();
        fail("expected " + what + ", not " +
             (token.kind == TokenKind::end ? "the end of the file" : quote(token.text)));
    }
    [[noreturn]] void fail_unsupported(const std::string& what) {
        fail(what + " is not supported yet");
    }
    void expect(std::string_view text, std::string_view behind) {
        if (take(text)) return;
        if (text == ";" && at_ > 0) {
            // The place to mend is behind the token before.
            const Token& before = tokens_[at_ - 1];
            diagnostics_.error(
                {before.where.offset + static_cast<std::uint32_t>(before.text.size())},
                "expected ';' after " + std::string{behind});
            if (begins_declaration()) return;
            throw GiveUp{};
        }
        fail_expected(quote(text) + " after " + std::string{behind});
    }
    /// Whether it looks as if only a semicolon was forgotten.
    bool begins_declaration() const {
        for (const std::string_view word :
             {"}", "module", "interface", "struct", "enum", "typedef", "const", "exception",
              "attribute", "readonly", "oneway", "void"}) {
            if (is(word)) return true;
        }
        return false;
    }
    /// The > of a template, also when two of them were read as one >>.
    void expect_closing_angle() {
        if (is(">>")) {
            if (std::exchange(half_taken_, true)) advance();
            return;
        }
        expect(">", "the type's arguments");
    }

    ast::Identifier identifier(const std::string& what) {
        if (current().kind != TokenKind::identifier) {
            if (current().kind == TokenKind::keyword) {
                fail("expected " + what + ", but " + quote(current().text) +
                     " is a keyword (write '_" + std::string{current().text} +
                     "' to use it as a name)");
            }
            fail_expected(what);
        }
        ast::Identifier name{std::string{current().text}, current().where};
        advance();
        return name;
    }

    ast::ScopedName scoped_name(const std::string& what) {
        ast::ScopedName name;
        name.global = take("::");
        do {
            name.parts.push_back(identifier(what));
        } while (take("::"));
        return name;
    }

    std::vector<ast::ScopedName> scoped_names(const std::string& what) {
        std::vector<ast::ScopedName> names;
        do {
            names.push_back(scoped_name(what));
        } while (take(","));
        return names;
    }

    const std::vector<Token>& tokens_;
    Diagnostics& diagnostics_;
    std::size_t at_ = 0;
    int depth_ = 0;
    bool half_taken_ = false;  ///< the first > of the current >> is used
};

}  // namespace canorb::idlc::parse
