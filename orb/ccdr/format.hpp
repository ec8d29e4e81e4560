#pragma once

#include <cstddef>
#include <cstdint>

/// The constants of CCDR; the page is doc/wire/ccdr.md.
namespace canorb::ccdr {

/// One length of the variable integers: `octets` long, begins with `lead`, and the bits of the
/// first octet below `lead_mask` and all that follow are the value.
struct VariableForm {
    std::size_t octets;
    std::uint8_t lead;
    std::uint8_t lead_mask;
    unsigned payload_bits;
};

// The longest form has 8 zero-or-fixed bits before 32 bits of value: 11110 and three zeros.
inline constexpr VariableForm variable_forms[] = {
    {1, 0x00, 0x80, 7},  {2, 0x80, 0xC0, 14}, {3, 0xC0, 0xE0, 21},
    {4, 0xE0, 0xF0, 28}, {5, 0xF0, 0xFF, 32},
};

/// The most levels of values within values: of recursive types, and of any within any.
inline constexpr unsigned highest_levels = 64;

/// The octets of the largest message.
inline constexpr std::size_t largest_message = 65538;

/// The most elements without octets in one message.
inline constexpr std::size_t highest_octetless = largest_message;

/// The most levels of a type code.
inline constexpr unsigned highest_type_code_levels = 16;

}  // namespace canorb::ccdr
