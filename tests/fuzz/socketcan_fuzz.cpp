// Any octets as a datagram from netlink, and as an error message frame.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "orb/can/link/can_interface.hpp"
#include "orb/can/link/socketcan_frame.hpp"

using namespace canorb::can;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    for (const NetlinkMessage& message : parse_netlink(canorb::Bytes{data, size})) {
        if (const auto* status = std::get_if<InterfaceStatus>(&message)) {
            if (status->removed && status->up) std::abort();
            if (status->name.find('\0') != std::string::npos) std::abort();
        } else if (const int error = std::get<NetlinkAnswer>(message).error;
                   error < 0 || error > 4095) {
            std::abort();
        }
    }
    can_frame frame{};
    if (size > 0) std::memcpy(&frame, data, std::min(size, sizeof frame));
    const ErrorReport report = parse_error(frame);
    if (report.state == ControllerState::stopped) std::abort();
    const Frame received = from_socketcan(frame);
    if (received.length > Frame::max_classic_payload) std::abort();
    if (!(from_socketcan(to_socketcan(received)) == received)) std::abort();
    return 0;
}
