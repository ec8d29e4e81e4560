#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace canorb::idlc {

/// What the C preprocessor wrote to standard error, as diagnostics are printed: place, text, the
/// source line and a caret. Of a file that was not found it says where it was looked for. Warnings
/// that mean nothing in IDL are left out, and those that the lexer gives too.
std::string preprocessor_messages(std::string_view written,
                                  const std::vector<std::string>& include_directories);

}  // namespace canorb::idlc
