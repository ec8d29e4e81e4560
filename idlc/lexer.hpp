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
    fixed,  ///< 12.5d
    character,
    wide_character,
    string,
    wide_string,
    punctuation,
    end,  ///< the last token of every file
};

struct Directive;

struct Token {
    TokenKind kind = TokenKind::end;
    /// As in the source; the underscore of an escaped identifier is left out.
    std::string_view text;
    Location where;
    /// Of a character or string literal: its octets, escapes resolved.
    std::string value;
    /// Of a wide character or string literal: its UTF-16 code units, escapes resolved.
    std::u16string wide_value;
    bool escaped = false;        ///< an identifier with an underscore before it
    bool first_on_line = false;  ///< nothing but white space and comments is before it
    /// The comment lines directly before, one "// text" or "/// text" each.
    std::vector<std::string> comment;
    /// The #pragma prefix, ID and version between the token before and this one.
    std::vector<Directive> directives;
};

/// A #pragma that names repository ids.
struct Directive {
    Location where;             ///< of its #
    std::vector<Token> tokens;  ///< behind the word pragma, ended by one of kind `end`
};

/// The tokens of the whole source, ended by one of kind `end`. Octets that begin no token are
/// reported and left out. The tokens point into the source.
std::vector<Token> tokenize(const Source& source, Diagnostics& diagnostics);

/// Whether CORBA reserves this word. Keywords are case-sensitive, but see collides_with_keyword().
/// The words that CORBA 3 and IDL 4 added (typeid, component, map, int8, ...) are names: they mean
/// something only in the places where these versions use them.
bool is_keyword(std::string_view word);

/// The keyword from which `word` differs only in case; empty when there is none. IDL allows no such
/// name but an escaped one, which may then be used without its underscore.
std::string_view collides_with_keyword(std::string_view word);

}  // namespace canorb::idlc
