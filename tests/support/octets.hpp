#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/bytes.hpp"

namespace canorb::test {

/// Golden octets written as hex, blanks anywhere between them: octets("10 0005 FFFE").
inline std::vector<std::uint8_t> octets(std::string_view hex) {
    std::vector<std::uint8_t> result;
    int high = -1;
    for (const char c : hex) {
        if (c == ' ' || c == '\n') continue;
        constexpr std::string_view digits = "0123456789abcdefABCDEF";
        const std::size_t found = digits.find(c);
        if (found == std::string_view::npos)
            throw std::invalid_argument("not hex: " + std::string(hex));
        const int digit = static_cast<int>(found < 16 ? found : found - 6);
        if (high < 0) {
            high = digit;
        } else {
            result.push_back(static_cast<std::uint8_t>(high * 16 + digit));
            high = -1;
        }
    }
    if (high >= 0) throw std::invalid_argument("half an octet: " + std::string(hex));
    return result;
}

/// The octets as hex, upper case, without blanks: what golden strings are compared with.
inline std::string hex(Bytes octets) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string result;
    result.reserve(octets.size() * 2);
    for (const std::uint8_t octet : octets) {
        result += digits[octet >> 4];
        result += digits[octet & 0x0F];
    }
    return result;
}

}  // namespace canorb::test
