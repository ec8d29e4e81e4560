#pragma once

#include <chrono>
#include <cstdint>

namespace canorb {

/// A span of time, in nanoseconds. `20ms` from std::chrono_literals converts to it.
using Duration = std::chrono::nanoseconds;

/// The clock of an ORB or a bus. It has no now(): in base to core time is always an argument, so
/// the same code runs on the machine's clock, on a virtual one and on a microcontroller's.
struct Clock {
    using duration = Duration;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::time_point<Clock, Duration>;
    static constexpr bool is_steady = true;
};

/// A moment on a Clock, in nanoseconds since that clock's start.
using TimePoint = Clock::time_point;

inline constexpr TimePoint never = TimePoint::max();

}  // namespace canorb
