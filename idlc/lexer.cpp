#include "idlc/lexer.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

namespace canorb::idlc {

namespace {

// The words of CORBA 2.6.
constexpr std::array keywords = {
    "FALSE",   "Object",    "TRUE",      "ValueBase", "abstract", "any",         "attribute",
    "boolean", "case",      "char",      "const",     "context",  "custom",      "default",
    "double",  "enum",      "exception", "factory",   "fixed",    "float",       "in",
    "inout",   "interface", "local",     "long",      "module",   "native",      "octet",
    "oneway",  "out",       "private",   "public",    "raises",   "readonly",    "sequence",
    "short",   "string",    "struct",    "supports",  "switch",   "truncatable", "typedef",
    "union",   "unsigned",  "valuetype", "void",      "wchar",    "wstring"};

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

/// The character at the front of `text`, and how many octets it has. Octets that are no UTF-8 are
/// taken for Latin-1.
std::pair<char32_t, std::size_t> decode(std::string_view text) {
    const auto octet = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
    };
    const char32_t lead = octet(0);
    const std::size_t size = lead < 0xC2 ? 1 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
    if (size == 1 || lead > 0xF4) return {lead, 1};
    char32_t value = lead & (0x7FU >> size);
    for (std::size_t i = 1; i < size; ++i) {
        if ((octet(i) & 0xC0U) != 0x80U) return {lead, 1};
        value = value << 6 | (octet(i) & 0x3FU);
    }
    constexpr std::array<char32_t, 5> least = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = value >= 0xD800 && value < 0xE000;
    if (value < least[size] || surrogate || value > 0x10FFFF) return {lead, 1};
    return {value, size};
}

void append(std::u16string& text, char32_t character) {
    if (character > 0xFFFF) {
        text += static_cast<char16_t>(0xD7C0 + (character >> 10));
        character = 0xDC00 + (character & 0x3FF);
    }
    text += static_cast<char16_t>(character);
}

class Lexer {
  public:
    /// The tokens of `text` from `begin` on.
    Lexer(std::string_view text, std::size_t begin, Diagnostics& diagnostics)
        : text_(text), diagnostics_(diagnostics), at_(begin), token_on_this_line_(begin != 0) {}

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

    Token& add(TokenKind kind, std::size_t begin) {
        Token token;
        token.kind = kind;
        token.text = text_.substr(begin, at_ - begin);
        token.where = location(begin);
        token.first_on_line = !std::exchange(token_on_this_line_, true);
        token.comment = std::exchange(comment_, {});
        token.directives = std::exchange(directives_, {});
        tokens_.push_back(std::move(token));
        return tokens_.back();
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
        const std::size_t begin = at_;
        const std::size_t end = std::min(text_.find('\n', at_), text_.size());
        skip_spaces_behind(begin + 1);
        const std::string_view word = take_directive_word();
        if (word == "pragma") {
            take_pragma(begin, end);
        } else if (!is_without_meaning(word)) {
            diagnostics_.error(location(begin), "not a preprocessor directive that IDL knows");
        }
        at_ = end;
        line_is_blank_ = false;
    }

    /// Of a directive that says nothing to an IDL compiler, such as `# 12`.
    static bool is_without_meaning(std::string_view word) {
        return word == "line" || word == "ident" || word == "sccs" || word == "warning" ||
               (!word.empty() && is_digit(word.front()));
    }

    void skip_spaces_behind(std::size_t offset) {
        at_ = offset;
        while (peek() == ' ' || peek() == '\t') ++at_;
    }

    std::string_view take_directive_word() {
        const std::size_t begin = at_;
        while (is_word(peek())) ++at_;
        return text_.substr(begin, at_ - begin);
    }

    void take_pragma(std::size_t begin, std::size_t end) {
        skip_spaces_behind(at_);
        const std::size_t first = at_;
        const std::string_view word = take_directive_word();
        if (word == "prefix" || word == "ID" || word == "version") {
            Lexer line{text_.substr(0, end), first, diagnostics_};
            directives_.push_back({location(begin), line.run()});
        } else if (unknown_pragmas_.insert(word).second) {
            diagnostics_.warning(location(begin),
                                 word.empty()
                                     ? "unknown #pragma, ignored"
                                     : "unknown #pragma '" + std::string{word} + "', ignored");
        }
    }

    void lex_token() {
        const char c = peek();
        if (c == 'L' && (peek(1) == '"' || peek(1) == '\'')) return lex_wide_literal();
        const bool foreign_name = c == '\\' && (peek(1) == 'u' || peek(1) == 'U');
        if (is_letter(c) || c == '_' || foreign_name || static_cast<unsigned char>(c) >= 0x80) {
            return lex_word();
        }
        if (is_digit(c) || (c == '.' && is_digit(peek(1)))) return lex_number();
        if (c == '"' || c == '\'') return lex_literal();
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
            Token& token = add(TokenKind::identifier, begin);
            token.escaped = true;
            token.text.remove_prefix(1);
            if (token.text.empty() || !is_letter(token.text.front())) {
                diagnostics_.error(token.where, "an identifier begins with a letter");
                token.text = "unnamed";
            }
            return;
        }
        add(is_keyword(word) ? TokenKind::keyword : TokenKind::identifier, begin);
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
        const bool exponent =
            kind == TokenKind::floating &&
            text_.substr(begin, at_ - begin).find_first_of("eE") != std::string_view::npos;
        if (lower(peek()) == 'd' && !is_word(peek(1)) && !exponent) {
            kind = TokenKind::fixed;
            ++at_;
        }
        add(kind, begin);
        if (!is_word(peek())) return;
        const std::size_t rest = at_;
        while (is_word(peek())) ++at_;
        const bool suffix =
            text_.substr(rest, at_ - rest).find_first_not_of("uUlLfF") == std::string_view::npos;
        diagnostics_.error(location(rest),
                           suffix ? "numbers of IDL have no suffix: leave it out"
                                  : "a number ends here, and this does not belong to it");
    }

    /// Goes through a literal from its opening quote to behind its closing one: `take` takes one
    /// character each time. False when there is no closing one.
    template <typename Take>
    bool lex_quoted(std::size_t begin, Take take) {
        const char quote = text_[at_++];
        while (peek() != quote || at_ == text_.size()) {
            if (at_ == text_.size() || peek() == '\n') {
                diagnostics_.error(location(begin), "this literal has no closing quote");
                return false;
            }
            take();
        }
        ++at_;
        return true;
    }

    void lex_literal() {
        const std::size_t begin = at_;
        const bool is_string = peek() == '"';
        std::string value;
        const bool closed = lex_quoted(begin, [&] {
            value.push_back(peek() == '\\' ? static_cast<char>(escape(false)) : text_[at_++]);
        });
        if (closed) check_literal(value, is_string, begin);
        if (!is_string) value.resize(1);
        add(is_string ? TokenKind::string : TokenKind::character, begin).value = std::move(value);
    }

    void lex_wide_literal() {
        const std::size_t begin = at_++;
        const bool is_string = peek() == '"';
        std::u16string value;
        const bool closed = lex_quoted(begin, [&] {
            if (peek() == '\\') {
                value.push_back(static_cast<char16_t>(escape(true)));
                return;
            }
            const auto [character, size] = decode(text_.substr(at_));
            append(value, character);
            at_ += size;
        });
        if (closed) check_literal(value, is_string, begin);
        if (!is_string) value.resize(1);
        add(is_string ? TokenKind::wide_string : TokenKind::wide_character, begin).wide_value =
            std::move(value);
    }

    template <typename Text>
    void check_literal(Text& value, bool is_string, std::size_t begin) {
        if (is_string && std::erase(value, '\0') != 0) {
            diagnostics_.error(location(begin), "a string cannot contain a NUL");
        } else if (!is_string && value.size() != 1) {
            const char32_t first = decode(text_.substr(text_.find('\'', begin) + 1)).first;
            const bool one = value.size() == (first < 0x800 ? 2 : first < 0x10000 ? 3 : 4);
            diagnostics_.error(
                location(begin),
                sizeof(value[0]) == 1 && one && first > 0x7F
                    ? "this character has several octets: write L before the quote, for a wchar"
                : first > 0xFFFF && value.size() == 2
                    ? "this character is beyond what a wchar holds"
                    : "a character literal is one character");
        }
    }

    /// The number of up to `most` digits here.
    unsigned number(unsigned base, int most) {
        unsigned value = 0;
        const auto is_digit_here = [&] { return base == 8 ? is_octal(peek()) : is_hex(peek()); };
        for (int digits = 0; digits < most && is_digit_here(); ++digits) {
            value = value * base + hex_value(text_[at_++]);
        }
        return value;
    }

    /// What the escape stands for: an octet, or a UTF-16 code unit in a wide literal.
    unsigned escape(bool wide) {
        const Location where = here();
        ++at_;  // the backslash
        constexpr std::string_view letters = "ntvbrfa\\?'\"";
        constexpr std::string_view values = "\n\t\v\b\r\f\a\\?'\"";
        const char c = peek();
        if (const std::size_t simple = letters.find(c); c != '\0' && simple != letters.npos) {
            ++at_;
            return static_cast<unsigned char>(values[simple]);
        }
        if (is_octal(c)) {
            const unsigned value = number(8, 3);
            if (wide || value <= 0xFF) return value;
            diagnostics_.error(where, "this escape is no octet");
            return '?';
        }
        if ((c == 'x' || c == 'u') && is_hex(peek(1))) {
            if (c == 'u' && !wide) {
                diagnostics_.error(where, "\\u is for wide literals: write L before the quote");
            }
            ++at_;
            return number(16, c == 'x' ? 2 : 4);
        }
        if (c == 'x') {
            diagnostics_.error(where, "this escape has no digits");
            ++at_;
            return '?';
        }
        if (at_ == text_.size() || c == '\n') return '\\';  // there is no closing quote either
        diagnostics_.warning(
            where, is_word(c) ? std::string{"IDL does not define the escape '\\"} + c +
                                    "', it is taken for '" + c + "'"
                              : "IDL does not define this escape, its backslash is left out");
        return static_cast<unsigned char>(text_[at_++]);
    }

    void lex_punctuation() {
        constexpr std::string_view single = "{}()[]<>;:,=+-*/%~|^&@";
        const std::size_t begin = at_;
        const std::string_view two = text_.substr(at_, 2);
        if (two == "::" || two == "<<" || two == ">>") {
            at_ += 2;
            add(TokenKind::punctuation, begin);
            return;
        }
        const char c = text_[at_++];
        if (single.find(c) != std::string_view::npos) {
            add(TokenKind::punctuation, begin);
            return;
        }
        const bool printable = c > ' ' && c < 127;
        diagnostics_.error(location(begin),
                           printable ? "'" + std::string(1, c) + "' has no meaning in IDL"
                                     : std::string{"this octet has no meaning in IDL"});
    }

    std::string_view text_;
    Diagnostics& diagnostics_;
    std::size_t at_;
    std::vector<Token> tokens_;
    std::vector<std::string> comment_;
    std::vector<Directive> directives_;
    std::set<std::string_view> unknown_pragmas_;
    bool line_is_blank_ = true;
    bool token_on_this_line_;
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
    return Lexer{source.text(), 0, diagnostics}.run();
}

}  // namespace canorb::idlc
