#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace canorb::console {

/// Nothing where the text is no UTF-8.
std::optional<std::u16string> to_utf16(std::string_view utf8);

/// A surrogate that is not one of a pair becomes U+FFFD.
std::string to_utf8(std::u16string_view units);

}  // namespace canorb::console
