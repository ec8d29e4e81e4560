#pragma once

#include <cstdint>

#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/type_code.hpp"

/// Parts of type codes, for the sources of this layer.
namespace canorb::ccdr {

/// A type code that is being read, and those around it.
struct Level {
    Level(const Level* around, const Decoder& at)
        : up(around), start(at), depth(around == nullptr ? 1 : around->depth + 1) {}

    const Level* up;
    Decoder start;  ///< at its kind
    unsigned depth;
    TCKind kind = TCKind::tk_null;
};

/// What a recursion found inside of `inner` stands for; null where it stands for nothing.
const Level* levels_up(const Level* inner, std::uint32_t levels);

/// A type without other types in it.
struct Leaf {
    TCKind kind = TCKind::tk_null;
    std::uint32_t size = 0;  ///< bound of a text, number of enumerators, digits of a fixed
};

std::uint32_t read_unsigned(Decoder& in);
TCKind read_kind(Decoder& in);
void skip_id_and_name(Decoder& in);
bool is_leaf(TCKind kind);
/// What follows the kind of a leaf. An unknown kind fails.
Leaf read_leaf(Decoder& in, TCKind kind);
/// A value of a type that a union's discriminator can have; other types fail.
std::uint64_t read_discriminator(Decoder& in, const Leaf& leaf);
/// The type of a union's discriminator, its aliases resolved.
Leaf read_discriminator_type(Decoder in);

}  // namespace canorb::ccdr
