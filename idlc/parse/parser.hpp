#pragma once

#include <vector>

#include "idlc/ast.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/lexer.hpp"

namespace canorb::idlc::parse {

/// The declarations of a whole file. What does not parse is reported and left out; the parser goes
/// on behind it. `tokens` end with TokenKind::end.
ast::File parse_file(const std::vector<Token>& tokens, Diagnostics& diagnostics);

}  // namespace canorb::idlc::parse
