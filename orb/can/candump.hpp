#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "orb/base/result.hpp"
#include "orb/base/time.hpp"
#include "orb/can/frame.hpp"

namespace canorb::can {

/// One line of a log as `candump -l` of can-utils writes it and canplayer, log2asc and Wireshark
/// read it:
///
///     (1436509053.650713) can0 123#DEADBEEF      data
///     (1436509053.650713) can0 12345678#R4       remote, extended, DLC 4
///     (1436509053.650713) can0 123##0DEADBEEF    CAN FD, the digit is its flags
///     (1436509053.650713) can0 20000004#...      error frame
struct CandumpLine {
    TimePoint time;         ///< whole microseconds
    std::string interface;  ///< "can0"; 1 to 15 characters
    Frame frame;
};

enum class CandumpError : std::uint8_t {
    time,        ///< not "(seconds.microseconds)"
    interface,   ///< missing, or longer than 15 characters
    identifier,  ///< not 3 or 8 hexadecimal digits, or out of range
    data,        ///< after the '#': odd or bad digits, or too many
    trailing,    ///< something after the frame
};

/// "bad time stamp" and so on.
std::string_view name(CandumpError error);

/// Without a line end. Times before the clock's start are written as 0. A CAN FD frame's flags
/// are written as 0.
std::string format_candump(TimePoint time, std::string_view interface, const Frame& frame);

/// One line, without its line end. CAN FD flags, a raw DLC ("_9") and the direction that
/// `candump -x` adds are checked and forgotten.
Result<CandumpLine, CandumpError> parse_candump(std::string_view line);

}  // namespace canorb::can
