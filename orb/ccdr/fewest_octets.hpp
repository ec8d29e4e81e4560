#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace canorb::ccdr {

/// The fewest octets that a value of type T can take; generated code need not specialize it. 0 for
/// types that never take any: those that have a member type _takes_no_octets.
template <typename T>
inline constexpr std::size_t fewest_octets = [] {
    if constexpr (requires { typename T::_takes_no_octets; }) {
        return 0;
    } else {
        return 1;
    }
}();
template <>
inline constexpr std::size_t fewest_octets<float> = 4;
template <>
inline constexpr std::size_t fewest_octets<double> = 8;
template <>
inline constexpr std::size_t fewest_octets<std::int64_t> = 8;
template <>
inline constexpr std::size_t fewest_octets<std::uint64_t> = 8;
template <>
inline constexpr std::size_t fewest_octets<long double> = 16;
template <>
inline constexpr std::size_t fewest_octets<char16_t> = 2;
template <>
inline constexpr std::size_t fewest_octets<std::string> = 2;
template <>
inline constexpr std::size_t fewest_octets<std::u16string> = 3;
template <typename T, std::size_t N>
inline constexpr std::size_t fewest_octets<std::array<T, N>> = N * fewest_octets<T>;

}  // namespace canorb::ccdr
