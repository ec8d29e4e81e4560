#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "idlc/diagnostics.hpp"
#include "idlc/source.hpp"

namespace canorb::idlc {

enum class TokenKind : std::uint8_t {
    identifier,
    keyword,
    integer,
    floating,
    character,
    string,
    punctuation,
    end,  ///< the last token of every file
};

struct Token {
    TokenKind kind = TokenKind::end;
    /// As in the source; the underscore of an escaped identifier is left out.
    std::string_view text;
    Location where;
    /// Of a character or string literal: its octets, escapes resolved.
    std::string value;
    /// The comment lines directly before, one "// text" or "/// text" each.
    std::vector<std::string> comment;
};

/// The tokens of the whole source, ended by one of kind `end`. Octets that begin no token are
/// reported and left out. The tokens point into the source.
std::vector<Token> tokenize(const Source& source, Diagnostics& diagnostics);

/// Whether IDL reserves this word. Keywords are case-sensitive, but see collides_with_keyword().
bool is_keyword(std::string_view word);

/// The keyword from which `word` differs only in case, which IDL forbids; empty when there is none.
std::string_view collides_with_keyword(std::string_view word);

}  // namespace canorb::idlc
