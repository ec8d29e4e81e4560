#include "idlc/lexer.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace canorb::idlc {

namespace {

// The words of the building blocks that make up plain CORBA interfaces. Those of the component
// model (port, home, provides, ...) stay free for users.
constexpr std::array keywords = {
    "FALSE",    "Object",      "TRUE",      "ValueBase", "abstract",   "any",       "attribute",
    "bitfield", "bitmask",     "bitset",    "boolean",   "case",       "char",      "const",
    "context",  "custom",      "default",   "double",    "enum",       "exception", "factory",
    "fixed",    "float",       "getraises", "in",        "inout",      "int16",     "int32",
    "int64",    "int8",        "interface", "local",     "long",       "map",       "module",
    "native",   "octet",       "oneway",    "out",       "private",    "public",    "raises",
    "readonly", "sequence",    "setraises", "short",     "string",     "struct",    "supports",
    "switch",   "truncatable", "typedef",   "typeid",    "typeprefix", "uint16",    "uint32",
    "uint64",   "uint8",       "union",     "unsigned",  "valuetype",  "void",      "wchar",
    "wstring"};

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_word(char c) {
    return is_letter(c) || is_digit(c) || c == '_';
}
bool is_hex(char c) {
    return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}
bool is_octal(char c) {
    return c >= '0' && c <= '7';
}
char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

unsigned hex_value(char c) {
    return static_cast<unsigned>(is_digit(c) ? c - '0' : lower(c) - 'a' + 10);
}

std::string_view trim(std::string_view text) {
    constexpr std::string_view spaces = " \t\r\f\v";
    const std::size_t first = text.find_first_not_of(spaces);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(spaces) - first + 1);
}

std::string comment_line(std::string_view mark, std::string_view text) {
    std::string line{mark};
    if (!text.empty()) line += ' ';
    line += text;
    // A backslash at its end would make the next line of C++ part of the comment.
    while (line.back() == '\\') line.pop_back();
    return line;
}

/// A /* */ comment as "//" lines, or "///" lines where it was a documentation comment.
std::vector<std::string> block_comment_lines(std::string_view text) {
    const bool documentation = text.size() > 4 && (text[2] == '*' || text[2] == '!');
    text.remove_prefix(documentation ? 3 : 2);
    if (text.ends_with("*/")) text.remove_suffix(2);
    std::vector<std::string> lines;
    bool first = true;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = trim(text.substr(0, end));
        if (!first && line.starts_with('*')) line = trim(line.substr(1));
        lines.push_back(comment_line(documentation ? "///" : "//", line));
        text.remove_prefix(std::min(end + 1, text.size()));
        first = false;
    }
    const auto is_blank = [](const std::string& line) { return line == "//" || line == "///"; };
    while (!lines.empty() && is_blank(lines.back())) lines.pop_back();
    while (!lines.empty() && is_blank(lines.front())) lines.erase(lines.begin());
    return lines;
}

class Lexer {
  public:
    Lexer(const Source& source, Diagnostics& diagnostics)
        : text_(source.text()), diagnostics_(diagnostics) {}

    std::vector<Token> run() {
        while (!diagnostics_.full()) {
            skip_blanks_and_comments();
            if (at_ == text_.size()) break;
            lex_token();
        }
        at_ = text_.size();
        add(TokenKind::end, at_);
        return std::move(tokens_);
    }

  private:
    char peek(std::size_t ahead = 0) const {
        return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
    }
    Location here() const { return {static_cast<std::uint32_t>(at_)}; }
    static Location location(std::size_t offset) { return {static_cast<std::uint32_t>(offset)}; }

    void add(TokenKind kind, std::size_t begin, std::string value = {}) {
        tokens_.push_back({kind, text_.substr(begin, at_ - begin), location(begin),
                           std::move(value), std::exchange(comment_, {})});
        token_on_this_line_ = true;
    }

    void skip_blanks_and_comments() {
        // A comment belongs to the token on the next line; one behind other tokens of its own line
        // belongs to those.
        while (at_ < text_.size()) {
            const char c = peek();
            if (c == '\n') {
                if (line_is_blank_ && !token_on_this_line_) comment_.clear();
                line_is_blank_ = true;
                token_on_this_line_ = false;
                ++at_;
            } else if (c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v') {
                ++at_;
            } else if (c == '/' && peek(1) == '/') {
                take_line_comment();
            } else if (c == '/' && peek(1) == '*') {
                take_block_comment();
            } else if (c == '#' && line_is_blank_ && !token_on_this_line_) {
                take_directive();
            } else {
                line_is_blank_ = false;
                return;
            }
        }
    }

    void take_line_comment() {
        const std::size_t end = std::min(text_.find('\n', at_), text_.size());
        std::string_view text = text_.substr(at_ + 2, end - at_ - 2);
        at_ = end;
        line_is_blank_ = false;
        if (token_on_this_line_) return;
        const bool documentation = text.starts_with('/') && !text.starts_with("//");
        if (documentation) text.remove_prefix(1);
        comment_.push_back(comment_line(documentation ? "///" : "//", trim(text)));
    }

    void take_block_comment() {
        const std::size_t begin = at_;
        const std::size_t close = text_.find("*/", at_ + 2);
        if (close == std::string_view::npos) {
            diagnostics_.error(here(), "this comment has no end");
            at_ = text_.size();
            return;
        }
        at_ = close + 2;
        line_is_blank_ = false;
        if (token_on_this_line_) return;
        for (std::string& line : block_comment_lines(text_.substr(begin, at_ - begin))) {
            comment_.push_back(std::move(line));
        }
    }

    void take_directive() {
        const std::size_t end = std::min(text_.find('\n', at_), text_.size());
        const std::string line{trim(text_.substr(at_, end - at_))};
        if (line.starts_with("#pragma")) {
            const std::string_view rest = trim(std::string_view{line}.substr(7));
            const std::string word{rest.substr(0, rest.find_first_of(" \t"))};
            if (word == "prefix" || word == "version" || word == "ID") {
                diagnostics_.error(here(), "#pragma " + word + " is not supported yet");
            } else {
                diagnostics_.warning(here(), "unknown #pragma, ignored");
            }
        } else {
            diagnostics_.error(here(), "not a preprocessor directive that IDL knows");
        }
        at_ = end;
        line_is_blank_ = false;
    }

    void lex_token() {
        const char c = peek();
        if (c == 'L' && (peek(1) == '"' || peek(1) == '\'')) {
            diagnostics_.error(here(), "wide character and string literals are not supported yet");
            ++at_;
            return lex_quoted();
        }
        const bool foreign_name = c == '\\' && (peek(1) == 'u' || peek(1) == 'U');
        if (is_letter(c) || c == '_' || foreign_name || static_cast<unsigned char>(c) >= 0x80) {
            return lex_word();
        }
        if (is_digit(c) || (c == '.' && is_digit(peek(1)))) return lex_number();
        if (c == '"' || c == '\'') return lex_quoted();
        lex_punctuation();
    }

    /// Goes behind a letter that is not ASCII, as it is or as the preprocessor writes it,
    /// \U000000f6; false where there is none.
    bool skip_foreign_letter() {
        if (static_cast<unsigned char>(peek()) >= 0x80) {
            ++at_;
            return true;
        }
        if (peek() != '\\' || (peek(1) != 'u' && peek(1) != 'U')) return false;
        at_ += 2;
        while (is_hex(peek())) ++at_;
        return true;
    }

    void lex_word() {
        const std::size_t begin = at_;
        bool foreign = false;
        while (true) {
            if (is_word(peek())) {
                ++at_;
            } else if (skip_foreign_letter()) {
                foreign = true;
            } else {
                break;
            }
        }
        if (foreign) {
            diagnostics_.error(location(begin),
                               "names have letters of English, digits and underscores only");
        }
        const std::string_view word = text_.substr(begin, at_ - begin);
        if (word.starts_with('_')) {
            add(TokenKind::identifier, begin);
            Token& token = tokens_.back();
            token.text.remove_prefix(1);
            if (token.text.empty() || !is_letter(token.text.front())) {
                diagnostics_.error(token.where, "an identifier begins with a letter");
                token.text = "unnamed";
            }
            return;
        }
        add(is_keyword(word) ? TokenKind::keyword : TokenKind::identifier, begin);
        const std::string_view keyword = collides_with_keyword(word);
        if (keyword.empty()) return;
        diagnostics_.error(location(begin), "'" + std::string{word} +
                                                "' differs only in case from the keyword '" +
                                                std::string{keyword} + "'");
    }

    void lex_number() {
        const std::size_t begin = at_;
        TokenKind kind = TokenKind::integer;
        if (peek() == '0' && (peek(1) == 'x' || peek(1) == 'X')) {
            at_ += 2;
            while (is_hex(peek())) ++at_;
        } else {
            while (is_digit(peek())) ++at_;
            if (peek() == '.') {
                kind = TokenKind::floating;
                ++at_;
                while (is_digit(peek())) ++at_;
            }
            const std::size_t sign = peek(1) == '+' || peek(1) == '-' ? 1 : 0;
            if ((peek() == 'e' || peek() == 'E') && is_digit(peek(1 + sign))) {
                kind = TokenKind::floating;
                at_ += 1 + sign;
                while (is_digit(peek())) ++at_;
            }
        }
        if (lower(peek()) == 'd' && !is_word(peek(1))) {
            diagnostics_.error(location(begin), "fixed-point literals are not supported yet");
            ++at_;
        }
        add(kind, begin);
        if (!is_word(peek())) return;
        diagnostics_.error(here(), "a number ends here, and this does not belong to it");
        while (is_word(peek())) ++at_;
    }

    void lex_quoted() {
        const std::size_t begin = at_;
        const char quote = peek();
        ++at_;
        std::string value;
        while (peek() != quote) {
            if (at_ == text_.size() || peek() == '\n') {
                diagnostics_.error(location(begin), "this literal has no closing quote");
                break;
            }
            value.push_back(peek() == '\\' ? escape() : text_[at_++]);
        }
        if (peek() == quote) ++at_;
        if (quote == '\'' && value.size() != 1) {
            diagnostics_.error(location(begin), "a character literal is one character");
            value = "?";
        }
        if (quote == '"' && value.find('\0') != std::string::npos) {
            diagnostics_.error(location(begin), "a string cannot contain a NUL");
            std::erase(value, '\0');
        }
        add(quote == '"' ? TokenKind::string : TokenKind::character, begin, std::move(value));
    }

    char escape() {
        const Location where = here();
        ++at_;  // the backslash
        constexpr std::string_view letters = "ntvbrfa\\?'\"";
        constexpr std::string_view values = "\n\t\v\b\r\f\a\\?'\"";
        const char c = peek();
        const std::size_t simple = letters.find(c);
        if (c != '\0' && simple != std::string_view::npos) {
            ++at_;
            return values[simple];
        }
        unsigned value = 0;
        if (c == 'x' && is_hex(peek(1))) {
            ++at_;
            for (int digits = 0; digits < 2 && is_hex(peek()); ++digits) {
                value = value * 16 + hex_value(text_[at_++]);
            }
            return static_cast<char>(value);
        }
        if (is_octal(c)) {
            for (int digits = 0; digits < 3 && is_octal(peek()); ++digits) {
                value = value * 8 + hex_value(text_[at_++]);
            }
            if (value > 0xFF) diagnostics_.error(where, "this escape is no octet");
            return static_cast<char>(value);
        }
        diagnostics_.error(where, "unknown escape in a literal");
        return '\\';
    }

    void lex_punctuation() {
        constexpr std::string_view single = "{}()[]<>;:,=+-*/%~|^&@";
        const std::size_t begin = at_;
        const std::string_view two = text_.substr(at_, 2);
        if (two == "::" || two == "<<" || two == ">>") {
            at_ += 2;
            return add(TokenKind::punctuation, begin);
        }
        const char c = text_[at_++];
        if (single.find(c) != std::string_view::npos) return add(TokenKind::punctuation, begin);
        const bool printable = c > ' ' && c < 127;
        diagnostics_.error(location(begin),
                           printable ? "'" + std::string(1, c) + "' has no meaning in IDL"
                                     : std::string{"this octet has no meaning in IDL"});
    }

    std::string_view text_;
    Diagnostics& diagnostics_;
    std::size_t at_ = 0;
    std::vector<Token> tokens_;
    std::vector<std::string> comment_;
    bool line_is_blank_ = true;
    bool token_on_this_line_ = false;
};

}  // namespace

bool is_keyword(std::string_view word) {
    return std::find(keywords.begin(), keywords.end(), word) != keywords.end();
}

std::string_view collides_with_keyword(std::string_view word) {
    for (const std::string_view keyword : keywords) {
        if (keyword != word && std::equal(keyword.begin(), keyword.end(), word.begin(), word.end(),
                                          [](char a, char b) { return lower(a) == lower(b); })) {
            return keyword;
        }
    }
    return {};
}

std::vector<Token> tokenize(const Source& source, Diagnostics& diagnostics) {
    return Lexer{source, diagnostics}.run();
}

}  // namespace canorb::idlc
