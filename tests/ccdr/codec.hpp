#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orb/ccdr/bounded.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
#include "tests/support/octets.hpp"

namespace canorb::test {

/// The value's octets in hex, or what the encoder says: "bad_value", "buffer_full".
template <typename T>
std::string encoded(const T& value) {
    std::vector<std::uint8_t> buffer(70'000);
    ccdr::Encoder out{buffer};
    encode(out, value);
    switch (out.error()) {
        case ccdr::EncodeError::none:
            return hex(out.octets());
        case ccdr::EncodeError::buffer_full:
            return "buffer_full";
        case ccdr::EncodeError::bad_value:
            break;
    }
    return "bad_value";
}

/// The value that all of these octets are, or nothing where they are refused.
template <typename T>
std::optional<T> decoded(Bytes octets) {
    ccdr::Decoder in{octets};
    T value{};
    decode(in, value);
    if (!in.finished()) return std::nullopt;
    return value;
}

template <typename T>
std::optional<T> decoded(std::string_view hex) {
    return decoded<T>(Bytes{octets(hex)});
}

/// How many of the octet strings that begin these octets, themselves left out, decode as a T. Each
/// is in memory of its own size, so that reading beyond its end is seen by AddressSanitizer.
template <typename T>
std::size_t prefixes_accepted(std::string_view hex) {
    const std::vector<std::uint8_t> all = octets(hex);
    std::size_t accepted = 0;
    for (std::size_t size = 0; size < all.size(); ++size) {
        const std::vector<std::uint8_t> prefix{all.data(), all.data() + size};
        if (decoded<T>(Bytes{prefix})) ++accepted;
    }
    return accepted;
}

/// Decodes these octets with each of their bits inverted in turn, and also with each octet set to 0
/// and to 0xFF. How many of the results do not encode to the octets that they were decoded from.
template <typename T>
std::size_t forgeries_changed(std::string_view golden) {
    const std::vector<std::uint8_t> all = octets(golden);
    std::size_t changed = 0;
    const auto count = [&changed](const std::vector<std::uint8_t>& forged) {
        const std::optional<T> value = decoded<T>(Bytes{forged});
        if (value && encoded(*value) != hex(forged)) ++changed;
    };
    for (std::size_t i = 0; i < all.size(); ++i) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            std::vector<std::uint8_t> forged = all;
            forged[i] ^= static_cast<std::uint8_t>(1U << bit);
            count(forged);
        }
        for (const std::uint8_t octet : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
            std::vector<std::uint8_t> forged = all;
            forged[i] = octet;
            count(forged);
        }
    }
    return changed;
}

}  // namespace canorb::test
