#pragma once

#include <cstdint>

#include "orb/base/time.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::can {

/// When the thread of a paced bus has to wake up. Bus::next_event() may be the next bit for as long
/// as something is wrong on the bus, and a thread that woke for each bit would do nothing else. So
/// one that wakes in vain sleeps longer each time, up to 100 microseconds, until a frame or an
/// error frame came to its end. Frames that nothing disturbs are told sharply at the end of their
/// EOF.
class Pacer {
  public:
    /// After an advance(): when to advance next, unless somebody does something on the bus before.
    TimePoint wake_at(const sim::Bus& bus);

  private:
    std::uint64_t progress_ = 0;  ///< frames and error frames so far
    TimePoint wake_at_ = never;
    Duration patience_{0};
};

}  // namespace canorb::can
