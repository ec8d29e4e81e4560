#pragma once

#include <linux/can.h>

#include <cstdint>
#include <optional>

#include "orb/can/controller.hpp"
#include "orb/can/frame.hpp"

namespace canorb::can {

/// A classical CAN frame as SocketCAN has it (linux/can.h), and back. A DLC above 8 is 8 octets.
can_frame to_socketcan(const Frame& frame);
Frame from_socketcan(const can_frame& frame);

/// The filter's kind is always in the mask, so that standard and extended frames keep apart.
can_filter to_socketcan(const Filter& filter);

/// What an error message frame (linux/can/error.h) means to a controller's user.
struct ErrorReport {
    std::optional<ControllerState> state;  ///< the new one
    bool transmit_timeout = false;         ///< the driver gave up what it had to send
    bool receive_overflow = false;         ///< the controller lost received frames
    bool receive_error = false;            ///< it could not read a frame
    std::optional<std::uint8_t> tec;
    std::optional<std::uint8_t> rec;
};
ErrorReport parse_error(const can_frame& frame);

/// The classes of error message frames that parse_error() makes something of.
inline constexpr can_err_mask_t wanted_errors = 0x00000001U     // CAN_ERR_TX_TIMEOUT
                                                | 0x00000004U   // CAN_ERR_CRTL
                                                | 0x00000008U   // CAN_ERR_PROT
                                                | 0x00000040U   // CAN_ERR_BUSOFF
                                                | 0x00000100U;  // CAN_ERR_RESTARTED

}  // namespace canorb::can
