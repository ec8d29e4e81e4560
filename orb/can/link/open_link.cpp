#include <chrono>
#include <utility>

#include "orb/can/link/address.hpp"
#include "orb/can/link/link.hpp"
#include "orb/can/link/local_link.hpp"
#include "orb/can/link/sim_link.hpp"
#include "orb/can/link/slcan_link.hpp"
#include "orb/can/link/socketcan_link.hpp"

namespace canorb::can {
namespace {

using Opened = Result<std::unique_ptr<Link>, std::string>;

Opened open(const LocalAddress& address) {
    return open_local_link(address);
}

Opened open(const SimAddress& address) {
    return open_sim_link(address);
}

Opened open(const SocketCanAddress& address) {
    return open_socketcan_link(address);
}

Opened open(const SlcanAddress& address) {
    return open_slcan_link(address);
}

}  // namespace

TimePoint monotonic_now() {
    return TimePoint{
        std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch())};
}

std::string_view default_bus_address() {
    return "sim:/tmp/canorb-bus0";
}

Result<std::unique_ptr<Link>, std::string> open_link(std::string_view address) {
    const auto parsed = parse_bus_address(address);
    if (!parsed) return Failure{parsed.error()};
    return std::visit([](const auto& form) { return open(form); }, *parsed);
}

}  // namespace canorb::can
