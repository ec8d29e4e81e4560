#include "orb/can/link/receive_clock.hpp"

#include <algorithm>
#include <chrono>

namespace canorb::can {
namespace {

/// How far two crystals may drift apart: 200 parts per million.
constexpr Duration::rep drift_divisor = 5000;

/// A frame that seems to have waited longer has its stamp from a clock that was started anew.
constexpr Duration longest_delay = std::chrono::seconds{1};

}  // namespace

TimePoint ReceiveClock::time_of(std::optional<Duration> software, std::optional<Duration> hardware,
                                const Present& present) {
    TimePoint time = present.now;
    if (software) time = std::min(time, present.now - (present.time_of_day - *software));
    if (hardware) time = of_hardware(*hardware, time);
    // Not before the frame before it: the time of day was set, or its clock runs behind.
    last_ = std::max(last_, time);
    return last_;
}

TimePoint ReceiveClock::of_hardware(Duration hardware, TimePoint arrival) {
    const Duration seen = arrival.time_since_epoch() - hardware;
    // What is seen is the offset and the way through the kernel; the least seen is nearest.
    const Duration elapsed = std::max(hardware - last_hardware_, Duration::zero());
    const bool anew =
        !offset_ || seen - *offset_ > longest_delay || *offset_ - seen > longest_delay;
    offset_ = anew ? seen : std::min(seen, *offset_ + elapsed / drift_divisor);
    last_hardware_ = hardware;
    return TimePoint{hardware + *offset_};
}

}  // namespace canorb::can
