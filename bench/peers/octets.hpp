// Octets of the wire, as text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace peers {

using Octets = std::vector<std::uint8_t>;

inline std::string to_hex(std::span<const std::uint8_t> octets) {
    constexpr char digits[] = "0123456789abcdef";
    std::string text;
    text.reserve(2 * octets.size());
    for (const std::uint8_t octet : octets) {
        text += digits[octet >> 4];
        text += digits[octet & 0xF];
    }
    return text;
}

inline nlohmann::ordered_json to_json(std::span<const std::uint8_t> octets) {
    return {{"octets", octets.size()}, {"hex", to_hex(octets)}};
}

/// The unsigned integer of SIZE octets at OFFSET, which must be there.
inline std::uint32_t read_unsigned(std::span<const std::uint8_t> octets, std::size_t offset,
                                   std::size_t size, bool little_endian) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
        value = value << 8 | octets[offset + (little_endian ? size - 1 - i : i)];
    }
    return value;
}

}  // namespace peers
