#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
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

    const Token& peek(std::size_t ahead) const {
        return tokens_[std::min(at_ + ahead, tokens_.size() - 1)];
    }
    const Token& current() const { return tokens_[at_]; }
    const Token& next() const { return peek(1); }
    void advance() {
        if (at_ + 1 < tokens_.size()) ++at_;
        half_taken_ = false;
    }
    /// Whether a keyword or a sign is here.
    bool is(std::string_view text) const { return is(current(), text); }
    static bool is(const Token& token, std::string_view text) {
        return (token.kind == TokenKind::keyword || token.kind == TokenKind::punctuation) &&
               token.text == text;
    }
    bool take(std::string_view text) {
        if (!is(text)) return false;
        advance();
        return true;
    }
    /// Whether a word is here that has a meaning in some places and is a name elsewhere.
    bool is_word(std::string_view text) const { return is_word(current(), text); }
    static bool is_word(const Token& token, std::string_view text) {
        return token.kind == TokenKind::identifier && !token.escaped && token.text == text;
    }
    static bool is_name(const Token& token) { return token.kind == TokenKind::identifier; }
    /// A name or a keyword.
    static bool is_any_word(const Token& token) {
        return token.kind == TokenKind::identifier || token.kind == TokenKind::keyword;
    }
    bool at_end() const { return current().kind == TokenKind::end; }

    void error(std::string text) { diagnostics_.error(current().where, std::move(text)); }
    [[noreturn]] void fail(std::string text) {
        error(std::move(text));
        throw GiveUp{};
    }
    [[noreturn]] void fail_expected(const std::string& what) {
        fail("expected " + what + ", not " +
             (at_end() ? "the end of the file" : quote(current().text)));
    }
    [[noreturn]] void fail_unsupported(const std::string& what) {
        fail(what + " is not supported (see doc/idl-support.md)");
    }
    void expect(std::string_view text, std::string_view behind) {
        if (!take(text)) fail_expected(quote(text) + " after " + std::string{behind});
    }
    void expect_semicolon(std::string_view behind) {
        if (take(";")) return;
        // The place to mend is behind the token before.
        const Token& before = tokens_[at_ - 1];
        diagnostics_.error({before.where.offset + static_cast<std::uint32_t>(before.text.size())},
                           "expected ';' after " + std::string{behind});
        // Only the semicolon is missing where something new begins.
        if (!current().first_on_line && !is("}") && !begins_declaration()) throw GiveUp{};
    }
    bool begins_declaration() const {
        for (const std::string_view word :
             {"module", "interface", "struct", "union", "enum", "typedef", "const", "exception",
              "native", "attribute", "readonly", "oneway", "void", "local", "abstract"}) {
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

    /// The name that a declaration gives.
    ast::Identifier identifier(const std::string& what) {
        const std::string collision = current().escaped ? "" : keyword_collision();
        if (!collision.empty()) {
            error(collision + " (write '_" + std::string{current().text} + "')");
        }
        declared_.insert(current().text);
        return name_part(what);
    }

    /// Reports the use of a name that nothing has and that differs only in case from a keyword.
    void check_used_name() {
        if (current().escaped || declared_.contains(current().text)) return;
        if (const std::string collision = keyword_collision(); !collision.empty()) error(collision);
    }

    ast::ScopedName scoped_name(const std::string& what) {
        ast::ScopedName name;
        name.global = take("::");
        name.parts.push_back(name_part(what));
        while (take("::")) {
            // CORBA::Object and CORBA::ValueBase are names, their last part is a keyword.
            if (is("Object") || is("ValueBase")) {
                name.parts.push_back(take_identifier());
                break;
            }
            name.parts.push_back(name_part(what));
        }
        return name;
    }

    std::vector<ast::ScopedName> scoped_names(const std::string& what) {
        std::vector<ast::ScopedName> names;
        do {
            names.push_back(scoped_name(what));
        } while (take(","));
        return names;
    }

    ast::Identifier take_identifier() {
        ast::Identifier name{std::string{current().text}, current().where};
        advance();
        return name;
    }

    const std::vector<Token>& tokens_;
    Diagnostics& diagnostics_;
    std::size_t at_ = 0;
    int depth_ = 0;
    bool half_taken_ = false;              ///< the first > of the current >> is used
    std::set<std::string_view> declared_;  ///< every name that was given so far

  private:
    std::string keyword_collision() const {
        if (!is_name(current())) return {};
        const std::string_view keyword = collides_with_keyword(current().text);
        if (keyword.empty()) return {};
        return quote(current().text) + " differs only in case from the keyword " + quote(keyword);
    }

    ast::Identifier name_part(const std::string& what) {
        if (current().kind == TokenKind::keyword) {
            const std::string word{current().text};
            fail("expected " + what + ", but '" + word + "' is a keyword (write '_" + word +
                 "' to use it as a name)");
        }
        if (!is_name(current())) fail_expected(what);
        return take_identifier();
    }
};

}  // namespace canorb::idlc::parse
