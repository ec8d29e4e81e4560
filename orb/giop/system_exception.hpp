#pragma once

#include "orb/base/system_error.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"

namespace canorb::giop {

/// The body of a Reply with status system_exception: doc/wire/giop.md, "Reply". Call it with its
/// namespace: a SystemError is a plain value of canorb and has no encoding of its own.
void encode(ccdr::Encoder& out, const SystemError& error);

/// An exception that canorb does not know becomes `unknown`, with its minor and completion kept. A
/// completion above 2 is malformed.
void decode(ccdr::Decoder& in, SystemError& error);

/// The octets that an encoded SystemError takes at most: the longest id, a minor of 5 octets, a
/// completion of 1.
inline constexpr std::size_t max_system_exception_octets = 1 + 46 + 5 + 1;

}  // namespace canorb::giop
