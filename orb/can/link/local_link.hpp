#pragma once

#include <memory>
#include <string>

#include "orb/base/result.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/link.hpp"

namespace canorb::can {

/// A bus inside this process: a Bus on the machine's clock, moved by a thread of its own, and by
/// each call of a controller, which takes a few milliseconds at most for that. Where the machine is
/// too slow for what is on the bus, its clock slips behind as PacedClock has it.
///
/// Not paced it is as fast as the machine: each call of a controller does what is on the bus, and
/// an event has the time at which poll() gave it. The thread goes on where a reader was waited for.
///
/// Everyone who opens the same name while somebody still uses it shares the bus. A bit rate that
/// differs from that of a running bus is an error, and so is another pace.
Result<std::unique_ptr<Link>, std::string> open_local_link(const LocalAddress& address);

}  // namespace canorb::can
