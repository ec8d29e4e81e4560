#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iosfwd>
#include <string_view>
#include <type_traits>
#include <utility>

#include "orb/ccdr/bitmask.hpp"

namespace canorb {

/// What values are printed to: std::ostream and what derives from it. All of this is templates, so
/// that a program that prints nothing contains nothing of it, and needs no <ostream>.
///
///     template <canorb::OutputStream Stream>
///     Stream& operator<<(Stream& out, const Status& value) {
///         return canorb::print_members(out, "speed", value.speed, "names", value.names);
///     }
template <typename Stream>
concept OutputStream = std::derived_from<Stream, std::ios_base>;

/// Within quotes; what does not print as itself as \n, \x1F or, of wide characters, \u00E4.
template <OutputStream Stream, typename Char>
void print_characters(Stream& out, std::basic_string_view<Char> text, char quote) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    out << quote;
    for (const Char c : text) {
        const auto code = static_cast<std::uint32_t>(static_cast<std::make_unsigned_t<Char>>(c));
        if (code == static_cast<unsigned char>(quote) || code == '\\') {
            out << '\\' << static_cast<char>(code);
        } else if (code == '\n') {
            out << "\\n";
        } else if (code >= ' ' && code <= '~') {
            out << static_cast<char>(code);
        } else {
            out << (sizeof(Char) == 1 ? "\\x" : "\\u");
            for (int shift = 8 * int{sizeof(Char)} - 4; shift >= 0; shift -= 4) {
                out << digits[code >> shift & 0xF];
            }
        }
    }
    out << quote;
}

/// In hex, without blanks.
template <OutputStream Stream>
Stream& print_octets(Stream& out, Bytes octets) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    for (const std::uint8_t octet : octets) out << digits[octet >> 4] << digits[octet & 0xF];
    return out;
}

/// Prints a value of any type of an IDL: texts "quoted", characters 'quoted', true and false,
/// octets as numbers, sequences and arrays [1, 2], maps {1: "one"}, pointers as what they point at,
/// all else by its operator<<.
template <OutputStream Stream, typename T>
Stream& print(Stream& out, const T& value) {
    if constexpr (std::same_as<T, bool>) {
        out << (value ? "true" : "false");
    } else if constexpr (std::same_as<T, char> || std::same_as<T, char16_t>) {
        print_characters(out, std::basic_string_view<T>{&value, 1}, '\'');
    } else if constexpr (std::same_as<T, std::uint8_t> || std::same_as<T, std::int8_t>) {
        out << int{value};
    } else if constexpr (std::convertible_to<const T&, std::string_view>) {
        print_characters(out, std::string_view{value}, '"');
    } else if constexpr (std::convertible_to<const T&, std::u16string_view>) {
        print_characters(out, std::u16string_view{value}, '"');
    } else if constexpr (requires { value.use_count(); }) {
        if (value) {
            print(out, *value);
        } else {
            out << "nil";
        }
    } else if constexpr (requires { typename T::mapped_type; }) {
        std::string_view separator;
        out << '{';
        for (const auto& [key, mapped] : value) {
            out << separator;
            print(out, key) << ": ";
            print(out, mapped);
            separator = ", ";
        }
        out << '}';
    } else if constexpr (requires {
                             typename T::value_type;
                             value.begin();
                         }) {
        std::string_view separator;
        out << '[';
        for (const auto& element : value) {
            out << separator;
            // The cast is for std::vector<bool>, whose elements are proxies.
            print(out, static_cast<const typename T::value_type&>(element));
            separator = ", ";
        }
        out << ']';
    } else {
        out << value;
    }
    return out;
}

template <OutputStream Stream>
void print_more_members(Stream&, std::string_view) {}

template <OutputStream Stream, typename T, typename... More>
void print_more_members(Stream& out, std::string_view separator, std::string_view name,
                        const T& value, const More&... more) {
    print(out << separator << name << ": ", value);
    print_more_members(out, ", ", more...);
}

/// A struct, union or exception: {speed: 3, name: "left"}, from a name and a value for each member.
template <OutputStream Stream, typename... NamesAndValues>
Stream& print_members(Stream& out, const NamesAndValues&... names_and_values) {
    out << '{';
    print_more_members(out, "", names_and_values...);
    out << '}';
    return out;
}

/// An enum: the name, of an unknown value its number.
template <OutputStream Stream, typename T>
Stream& print_enumerator(Stream& out, T value,
                         std::initializer_list<std::pair<T, std::string_view>> names) {
    for (const auto& [enumerator, name] : names) {
        if (enumerator == value) {
            out << name;
            return out;
        }
    }
    out << static_cast<std::uint32_t>(value);
    return out;
}

/// A bitmask: hot|stalled, bits without a name as a number behind, 0 for none.
template <OutputStream Stream, Bitmask T>
Stream& print_flags(Stream& out, T flags,
                    std::initializer_list<std::pair<T, std::string_view>> names) {
    std::string_view separator;
    auto bits = static_cast<std::uint64_t>(flags);
    for (const auto& [flag, name] : names) {
        const auto bit = static_cast<std::uint64_t>(flag);
        if ((bits & bit) == 0) continue;
        out << separator << name;
        separator = "|";
        bits &= ~bit;
    }
    if (bits != 0 || separator.empty()) out << separator << bits;
    return out;
}

}  // namespace canorb
