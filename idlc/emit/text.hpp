#pragma once

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

std::string join(const std::vector<std::string>& parts, std::string_view separator);

}  // namespace canorb::idlc::emit
