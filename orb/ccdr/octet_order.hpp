#pragma once

#include <cstdint>

/// Values of 4 and 8 octets in CCDR's octet order. The compiler makes one access and one swap of
/// each.
namespace canorb::ccdr {

constexpr void write_be32(std::uint8_t* octets, std::uint32_t value) {
    octets[0] = static_cast<std::uint8_t>(value >> 24);
    octets[1] = static_cast<std::uint8_t>(value >> 16);
    octets[2] = static_cast<std::uint8_t>(value >> 8);
    octets[3] = static_cast<std::uint8_t>(value);
}

constexpr std::uint32_t read_be32(const std::uint8_t* octets) {
    return std::uint32_t{octets[0]} << 24 | std::uint32_t{octets[1]} << 16 |
           std::uint32_t{octets[2]} << 8 | std::uint32_t{octets[3]};
}

constexpr void write_be64(std::uint8_t* octets, std::uint64_t value) {
    write_be32(octets, static_cast<std::uint32_t>(value >> 32));
    write_be32(octets + 4, static_cast<std::uint32_t>(value));
}

constexpr std::uint64_t read_be64(const std::uint8_t* octets) {
    return std::uint64_t{read_be32(octets)} << 32 | read_be32(octets + 4);
}

}  // namespace canorb::ccdr
