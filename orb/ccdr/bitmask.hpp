#pragma once

#include <cstdint>
#include <type_traits>

#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"

namespace canorb {

/// What says that an enum class is an IDL bitmask of N bits, 1 to 64: the result of a function that
/// is found by its argument, and only declared. The operators come by using-declarations, through
/// which they too are found by their arguments.
///
///     enum class Alarms : std::uint16_t { hot = 1 << 0, stalled = 1 << 1 };
///     canorb::BitmaskBits<12> bitmask_bits(const Alarms*);
///     using canorb::operator|, canorb::operator&, canorb::operator^, canorb::operator~,
///         canorb::operator|=, canorb::operator&=, canorb::operator^=, canorb::has;
template <unsigned N>
struct BitmaskBits {
    static_assert(N >= 1 && N <= 64, "a bitmask has 1 to 64 bits");
    static constexpr unsigned value = N;
};

template <typename T>
concept Bitmask = std::is_enum_v<T> && requires(const T* flags) { bitmask_bits(flags).value; };

/// All bits that a bitmask has, named or not.
template <Bitmask T>
inline constexpr std::uint64_t bitmask_all =
    ~std::uint64_t{0} >> (64 - decltype(bitmask_bits(static_cast<const T*>(nullptr)))::value);

template <Bitmask T>
constexpr T operator|(T a, T b) {
    return static_cast<T>(static_cast<std::uint64_t>(a) | static_cast<std::uint64_t>(b));
}
template <Bitmask T>
constexpr T operator&(T a, T b) {
    return static_cast<T>(static_cast<std::uint64_t>(a) & static_cast<std::uint64_t>(b));
}
template <Bitmask T>
constexpr T operator^(T a, T b) {
    return static_cast<T>(static_cast<std::uint64_t>(a) ^ static_cast<std::uint64_t>(b));
}
/// Within the bits that the bitmask has.
template <Bitmask T>
constexpr T operator~(T a) {
    return static_cast<T>(~static_cast<std::uint64_t>(a) & bitmask_all<T>);
}
template <Bitmask T>
constexpr T& operator|=(T& a, T b) {
    return a = a | b;
}
template <Bitmask T>
constexpr T& operator&=(T& a, T b) {
    return a = a & b;
}
template <Bitmask T>
constexpr T& operator^=(T& a, T b) {
    return a = a ^ b;
}
/// Whether all bits of `wanted` are set in `flags`.
template <Bitmask T>
constexpr bool has(T flags, T wanted) {
    return (flags & wanted) == wanted;
}

}  // namespace canorb

namespace canorb::ccdr {

/// The smallest unsigned type that holds a bitmask: what its enum class is based on.
template <unsigned N>
using BitmaskNumber = std::conditional_t<
    N <= 8, std::uint8_t,
    std::conditional_t<N <= 16, std::uint16_t,
                       std::conditional_t<N <= 32, std::uint32_t, std::uint64_t>>>;

template <Bitmask T>
using NumberOf = BitmaskNumber<decltype(bitmask_bits(static_cast<const T*>(nullptr)))::value>;

template <Bitmask T>
inline constexpr std::size_t fewest_octets<T> = fewest_octets<NumberOf<T>>;

template <Bitmask T>
void encode(Encoder& out, T flags) {
    static_assert(sizeof(T) == sizeof(NumberOf<T>), "based on the smallest unsigned type");
    const auto bits = static_cast<NumberOf<T>>(flags);
    if ((bits & ~bitmask_all<T>) != 0) return out.fail();
    encode(out, bits);
}

template <Bitmask T>
void decode(Decoder& in, T& flags) {
    NumberOf<T> bits{};
    decode(in, bits);
    if ((bits & ~bitmask_all<T>) != 0) {
        in.fail();
        bits = 0;
    }
    flags = static_cast<T>(bits);
}

}  // namespace canorb::ccdr
