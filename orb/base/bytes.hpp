#pragma once

#include <cstdint>
#include <span>

namespace canorb {

/// Octets that someone else owns, to read.
using Bytes = std::span<const std::uint8_t>;

/// Octets that someone else owns, to write.
using MutableBytes = std::span<std::uint8_t>;

constexpr std::uint16_t read_be16(const std::uint8_t* octets) {
    return static_cast<std::uint16_t>((octets[0] << 8) | octets[1]);
}

constexpr void write_be16(std::uint8_t* octets, std::uint16_t value) {
    octets[0] = static_cast<std::uint8_t>(value >> 8);
    octets[1] = static_cast<std::uint8_t>(value);
}

}  // namespace canorb
