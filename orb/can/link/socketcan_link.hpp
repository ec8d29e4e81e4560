#pragma once

#include <memory>
#include <string>

#include "orb/base/result.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/link.hpp"

namespace canorb::can {

/// A CAN interface of Linux. No kernel support, no such interface, or one that is none for CAN is
/// an error here and now; one that is down is not: its controllers are `stopped` until it comes up.
///
/// Each controller is a CAN_RAW socket of its own, so that controllers on one interface hear each
/// other. An interface that goes down, or is removed, fails all transmissions; the controller is
/// `stopped` and works again as soon as there is an interface of that name that is up.
Result<std::unique_ptr<Link>, std::string> open_socketcan_link(const SocketCanAddress& address);

}  // namespace canorb::can
