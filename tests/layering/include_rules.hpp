#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace canorb::layering {

/// What a source file does that its place in the house does not allow, one line for each
/// offence: "orb/giop/x.cpp:12: giop may not include can". `path` is relative to the top of the
/// source tree; files of no known folder have no rules.
std::vector<std::string> violations(std::string_view path, std::string_view text);

}  // namespace canorb::layering
