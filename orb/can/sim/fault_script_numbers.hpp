#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// The numbers of a fault script. Nothing where the text, all of it, is no such number.
namespace canorb::can::sim {

/// Digits of a base up to 16, at most `highest`.
std::optional<std::uint64_t> parse_number(std::string_view text, int base, std::uint64_t highest);

/// A number with or without a fraction, of units of so many nanoseconds: a power of ten. Whole in
/// nanoseconds, and at most FaultTime::highest_nanoseconds.
std::optional<std::uint64_t> parse_nanoseconds(std::string_view text, std::uint64_t unit);

/// 0.001, 1e-3 and 2.5e-4, above 0 and up to 1: times 2 to the 64, where 1 is UINT64_MAX.
std::optional<std::uint64_t> parse_probability(std::string_view text);

}  // namespace canorb::can::sim
