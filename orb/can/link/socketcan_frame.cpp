#include "orb/can/link/socketcan_frame.hpp"

#include <linux/can/error.h>

#include <algorithm>

namespace canorb::can {
namespace {

/// data[6] and data[7] are TEC and REC (linux/can/error.h since Linux 6.0).
constexpr std::uint32_t has_counters = 0x00000200U;

}  // namespace

static_assert(wanted_errors == (CAN_ERR_TX_TIMEOUT | CAN_ERR_CRTL | CAN_ERR_PROT | CAN_ERR_BUSOFF |
                                CAN_ERR_RESTARTED));

can_frame to_socketcan(const Frame& frame) {
    can_frame out{};
    out.can_id =
        frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.remote ? CAN_RTR_FLAG : 0U);
    out.can_dlc = frame.length;
    std::copy(frame.payload().begin(), frame.payload().end(), out.data);
    return out;
}

Frame from_socketcan(const can_frame& frame) {
    Frame out;
    out.extended = (frame.can_id & CAN_EFF_FLAG) != 0;
    out.remote = (frame.can_id & CAN_RTR_FLAG) != 0;
    out.id = frame.can_id & (out.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
    out.length = std::min<std::uint8_t>(frame.can_dlc, CAN_MAX_DLEN);
    if (!out.remote) std::copy_n(frame.data, out.length, out.data.begin());
    return out;
}

can_filter to_socketcan(const Filter& filter) {
    can_filter out{};
    out.can_id = (filter.value & CAN_EFF_MASK) | (filter.extended ? CAN_EFF_FLAG : 0U);
    out.can_mask =
        (filter.mask & CAN_EFF_MASK) | CAN_EFF_FLAG | (filter.data_only ? CAN_RTR_FLAG : 0U);
    return out;
}

ErrorReport parse_error(const can_frame& frame) {
    ErrorReport report;
    report.transmit_timeout = (frame.can_id & CAN_ERR_TX_TIMEOUT) != 0;
    // An overload frame loses nothing, and neither does an error flag that was sent.
    constexpr std::uint8_t not_received =
        CAN_ERR_PROT_TX | CAN_ERR_PROT_ACTIVE | CAN_ERR_PROT_OVERLOAD;
    report.receive_error =
        (frame.can_id & CAN_ERR_PROT) != 0 && (frame.data[2] & not_received) == 0;
    if ((frame.can_id & CAN_ERR_CRTL) != 0) {
        const std::uint8_t what = frame.data[1];
        report.receive_overflow = (what & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
        if ((what & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
            report.state = ControllerState::error_passive;
        } else if ((what & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING |
                            CAN_ERR_CRTL_ACTIVE)) != 0) {
            report.state = ControllerState::error_active;
        }
    }
    if ((frame.can_id & CAN_ERR_RESTARTED) != 0) report.state = ControllerState::error_active;
    if ((frame.can_id & CAN_ERR_BUSOFF) != 0) report.state = ControllerState::bus_off;
    // Older kernels give the counters with changes of state, and have no flag that says so.
    const bool counters_in_state = report.state && (frame.can_id & CAN_ERR_CRTL) != 0;
    if ((frame.can_id & has_counters) != 0 || counters_in_state) {
        report.tec = frame.data[6];
        report.rec = frame.data[7];
    }
    return report;
}

}  // namespace canorb::can
