#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace canorb::ccdr {

/// The bits of an IEEE 754 binary128: sign, 15 of the exponent, 112 of the fraction.
struct Binary128 {
    std::uint64_t high;
    std::uint64_t low;

    friend constexpr bool operator==(const Binary128&, const Binary128&) = default;
};

inline constexpr std::uint64_t binary128_sign = std::uint64_t{1} << 63;
/// The bit above the fraction: 1 in every normal number, and not stored.
inline constexpr std::uint64_t binary128_hidden_bit = std::uint64_t{1} << 48;
inline constexpr int binary128_fraction_bits = 112;
inline constexpr int binary128_exponent_bias = 16383;
inline constexpr int binary128_special_exponent = 0x7FFF;

/// `value` shifted right by `bits`, rounded to nearest, ties to even.
constexpr Binary128 shifted_right(Binary128 value, int bits) {
    if (bits > 127) return {0, 0};
    bool half = false;
    bool more_than_half = false;
    for (int i = 0; i < bits; ++i) {
        more_than_half = more_than_half || half;
        half = (value.low & 1) != 0;
        value.low = (value.low >> 1) | (value.high << 63);
        value.high >>= 1;
    }
    if (half && (more_than_half || (value.low & 1) != 0)) {
        if (++value.low == 0) ++value.high;
    }
    return value;
}

/// Exact for floats of up to 113 binary digits. A NaN keeps its sign only: C++ has no portable way
/// to its other bits.
template <typename Float>
Binary128 to_binary128(Float value) {
    static_assert(std::numeric_limits<Float>::radix == 2);
    const std::uint64_t sign = std::signbit(value) ? binary128_sign : 0;
    constexpr std::uint64_t special = std::uint64_t{binary128_special_exponent} << 48;
    if (std::isnan(value)) return {sign | special | binary128_hidden_bit >> 1, 0};
    if (std::isinf(value)) return {sign | special, 0};
    if (value == Float{0}) return {sign, 0};

    int exponent = 0;
    const Float upper = std::ldexp(std::frexp(std::abs(value), &exponent), 49);
    Binary128 bits{};
    bits.high = static_cast<std::uint64_t>(upper);
    bits.low = static_cast<std::uint64_t>(std::ldexp(upper - static_cast<Float>(bits.high), 64));
    // frexp's fraction is from 0.5 to 1, IEEE 754's from 1 to 2.
    const int biased = exponent - 1 + binary128_exponent_bias;
    if (biased <= 0) {
        bits = shifted_right(bits, 1 - biased);
    } else {
        bits.high ^= binary128_hidden_bit;
        bits.high |= static_cast<std::uint64_t>(biased) << 48;
    }
    bits.high |= sign;
    return bits;
}

/// Rounded to nearest, ties to even, where the host's type is smaller.
template <typename Float>
Float from_binary128(Binary128 bits) {
    using Limits = std::numeric_limits<Float>;
    const bool is_negative = (bits.high & binary128_sign) != 0;
    const int stored = static_cast<int>(bits.high >> 48) & binary128_special_exponent;
    bits.high &= binary128_hidden_bit - 1;

    Float magnitude{};
    if (stored == binary128_special_exponent) {
        magnitude = bits == Binary128{0, 0} ? Limits::infinity() : Limits::quiet_NaN();
    } else {
        if (stored != 0) bits.high |= binary128_hidden_bit;
        // The value is bits * 2^scale.
        int scale = std::max(stored, 1) - binary128_exponent_bias - binary128_fraction_bits;
        // Rounded here, once, so that nothing below has to round: to as many digits as the host
        // has, and in its subnormals to its smallest step.
        const int smallest_scale = Limits::min_exponent - Limits::digits;
        const int excess = std::max(binary128_fraction_bits + 1 - Limits::digits,
                                    std::min(smallest_scale - scale, 128));
        if (excess > 0) {
            bits = shifted_right(bits, excess);
            scale += excess;
        }
        const Float upper = std::ldexp(static_cast<Float>(bits.high), 64);
        magnitude = std::ldexp(upper + static_cast<Float>(bits.low), scale);
    }
    return std::copysign(magnitude, is_negative ? Float{-1} : Float{1});
}

}  // namespace canorb::ccdr
