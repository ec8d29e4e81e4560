#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace canorb::idlc::emit {

using Slot = std::pair<std::string_view, std::string_view>;

/// `piece` with each $name$ replaced by its value. A value of several lines keeps the indentation
/// of its place; where an empty value was alone on a line, the line is left out. A newline at the
/// front of the piece is dropped, so that raw strings may begin on a line of their own.
std::string fill(std::string_view piece, std::initializer_list<Slot> slots);

/// Each line that is not empty with four spaces per level before it.
std::string indent(std::string_view text, std::size_t levels = 1);

/// How long a generated line should be at most, indentation by one level included.
inline constexpr std::size_t line_width = 96;

/// `begin` and `end` on one line where it is short enough, else `end` on a line of its own.
std::string wrap(std::string_view begin, std::string_view end);

/// The declaration with the remark behind it as a comment, or above it where it is too long.
std::string remarked(std::string_view declaration, std::string_view remark);

/// "0x0012ABCD".
std::string hexadecimal(std::uint32_t value);

std::string join(const std::vector<std::string>& parts, std::string_view separator);

}  // namespace canorb::idlc::emit
