#pragma once

#include <memory>
#include <string>

#include "orb/base/result.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/link.hpp"

namespace canorb::can {

/// A bus inside this process. Not paced: as fast as the machine, without a thread; each call of a
/// controller does what is on the bus meanwhile, and its time moves by frames only. Else a Bus on
/// the machine's clock, moved by a thread of its own, and by
/// each call of a controller, which takes a few milliseconds at most for that. Where the machine is
/// too slow for what is on the bus, its clock slips behind as PacedClock has it.
/// Everyone who opens the same name while somebody still uses it shares the bus. A bit rate that
/// differs from that of a running bus is an error, and so is another pace.
Result<std::unique_ptr<Link>, std::string> open_local_link(const LocalAddress& address);

}  // namespace canorb::can
