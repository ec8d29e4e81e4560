#pragma once

#include <optional>

#include "orb/base/time.hpp"

namespace canorb::can {

/// Brings the kernel's and the hardware's receive time stamps onto the clock of the ORB.
///
/// The kernel stamps with the time of day, which is set now and then; a CAN interface that stamps
/// by itself counts on a clock of its own, whose start is anything and whose rate is nearly right.
/// Its stamps are better, because no interrupt or bus to the processor is in them.
///
/// Invariant: times are never later than the present, and do not go back.
class ReceiveClock {
  public:
    /// One moment on two clocks.
    struct Present {
        TimePoint now;
        Duration time_of_day;
    };

    /// `software`: by the time of day, on the frame's arrival in the kernel; `hardware`: on the
    /// interface's clock. Without either it is the present.
    TimePoint time_of(std::optional<Duration> software, std::optional<Duration> hardware,
                      const Present& present);

  private:
    TimePoint of_hardware(Duration hardware, TimePoint arrival);

    TimePoint last_{};
    /// From the interface's clock to ours, as the frame that came through fastest has shown it.
    std::optional<Duration> offset_;
    Duration last_hardware_{};
};

}  // namespace canorb::can
