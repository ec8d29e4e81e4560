#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
#include "tools/console/model.hpp"

/// What is a number on the bus, whatever it is in IDL.
namespace canorb::console {

struct IntegerRange {
    std::int64_t lowest;
    std::uint64_t highest;
    /// "0 to 65535".
    std::string text() const;
};

/// Of an integer type, octet among them.
IntegerRange integer_range(Kind kind);

/// A number in decimal, or behind 0x in hex, within the range: negative ones in two's complement.
std::optional<std::uint64_t> parse_integer(std::string_view text, const IntegerRange& range);

/// `bits` as a value of an integer or character type or boolean. It must be within the type.
void encode_integer(ccdr::Encoder& out, Kind kind, std::uint64_t bits);

/// An integer type; the bits are those of a 64-bit integer.
std::uint64_t decode_integer(ccdr::Decoder& in, Kind kind);

/// The value of a union's discriminator, as Member::labels has it.
std::int64_t decode_label(ccdr::Decoder& in, Kind kind);

/// What the discriminator selects; null: nothing.
const Member* selected_member(const Definition& choice, std::int64_t label);

/// The smallest unsigned type that holds it.
Kind kind_of_bitmask(const Definition& bitmask);

/// Whether all values of the type take no octets: structs without members, and what has only such.
bool takes_no_octets(const Type& type);

}  // namespace canorb::console
