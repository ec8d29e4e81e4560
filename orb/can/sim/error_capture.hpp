#pragma once

#include <cstdint>
#include <string_view>

#include "orb/can/frame_field.hpp"

namespace canorb::can::sim {

/// The five kinds of error of ISO 11898-1.
enum class ErrorKind : std::uint8_t { bit, stuff, crc, form, acknowledgment };

/// As people write it, for example "stuff error".
std::string_view name(ErrorKind kind);

/// What a controller saw when it detected an error.
struct ErrorCapture {
    ErrorKind kind = ErrorKind::bit;
    FramePosition position;  ///< of the bit at which it was detected
    bool transmitting = false;
    friend bool operator==(const ErrorCapture&, const ErrorCapture&) = default;
};

/// The value that an SJA1000 has in its error code capture register: bits 7..6 kind (0 bit, 1 form,
/// 2 stuff, 3 other), bit 5 receiving, bits 4..0 segment.
std::uint8_t sja1000_error_code(const ErrorCapture& capture);

}  // namespace canorb::can::sim
