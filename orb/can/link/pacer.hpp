#pragma once

#include <cstdint>

#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"
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

/// The clock of a paced bus: the machine's, but a bus that cannot keep up with it slips behind, so
/// that what it has not done yet does not grow without bound.
class PacedClock {
  public:
    /// Moves the bus up to `to` on the machine's clock, in small steps, and gives up at `deadline`,
    /// though not before the first step. Whether the bus is there.
    [[nodiscard]] bool advance(sim::Bus& bus, TimePoint to, TimePoint deadline) const;

    /// To be called after an advance() to `now`. A bus that is more than a second behind lets that
    /// time go: it is `now` for it at once. Whether it has slipped.
    bool slip(const sim::Bus& bus, TimePoint now);

    /// So much of the machine's time was let go. It never becomes less.
    Duration slipped() const { return slipped_; }

    /// From the bus's time to the machine's.
    TimePoint machine_time(TimePoint bus_time) const {
        return bus_time == never ? never : bus_time + slipped_;
    }
    ControllerEvent machine_time(ControllerEvent event) const;

  private:
    Duration slipped_{0};
};

}  // namespace canorb::can
