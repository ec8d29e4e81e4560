#pragma once

#include <cstdint>

#include "orb/base/time.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::can {

/// When the thread of a paced bus has to wake up. Bus::next_event() may be the next bit for as long
/// as something is wrong on the bus, and a thread that woke for each bit would do nothing else. So
/// one that has woken 64 times in vain sleeps 100 microseconds or more each time, until a frame or
/// an error frame has come to its end. Frames that nothing disturbs are told at the end of their
/// EOF.
class Pacer {
  public:
    /// After an advance(): when to advance next, unless somebody does something on the bus before.
    TimePoint wake_at(const sim::Bus& bus);

  private:
    std::uint64_t progress_ = 0;  ///< frames and error frames so far
    TimePoint wake_at_ = never;
    int vain_wakes_ = 0;  ///< in a row
};

}  // namespace canorb::can
