#pragma once

#include <cstdint>
#include <string_view>

namespace canorb::can {

/// What a bit on the bus belongs to (ISO 11898-1).
enum class FrameField : std::uint8_t {
    start_of_frame,
    identifier,               ///< 11 bits: all of a standard, the upper ones of an extended one
    remote_request,           ///< RTR; where an extended frame has SRR as long as IDE is unknown
    identifier_extension,     ///< IDE
    extended_identifier,      ///< the lower 18 bits
    extended_remote_request,  ///< RTR of an extended frame
    reserved_1,               ///< of extended frames
    reserved_0,
    data_length_code,  ///< 4 bits
    data,              ///< 0 to 64 bits
    crc,               ///< 15 bits
    crc_delimiter,
    ack_slot,
    ack_delimiter,
    end_of_frame,          ///< 7 bits
    intermission,          ///< 3 bits
    suspend_transmission,  ///< 8 bits
    active_error_flag,     ///< 6 bits
    passive_error_flag,    ///< 6 bits or more
    error_superposition,   ///< after an error or overload flag, until the bus is recessive
    error_delimiter,       ///< 8 bits
    overload_flag,         ///< 6 bits
    overload_delimiter,    ///< 8 bits
    idle,
};

/// As people write it, for example "CRC delimiter".
std::string_view name(FrameField field);

/// A bit's place in a frame.
struct FramePosition {
    FrameField field = FrameField::idle;
    std::uint8_t index = 0;  ///< within the field, from 0; of a stuff bit: of the bit before it
    bool stuff = false;      ///< inserted after five equal bits
    friend bool operator==(const FramePosition&, const FramePosition&) = default;
};

}  // namespace canorb::can
