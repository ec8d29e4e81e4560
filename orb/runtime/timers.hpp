#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "orb/base/time.hpp"

namespace canorb::runtime {

using Callback = std::function<void()>;

/// Callbacks by the time at which they are due; at equal times in the order of their making.
class Timers {
  public:
    using Id = std::uint64_t;

    /// `period` 0: once.
    Id add(TimePoint time, Duration period, Callback callback);
    /// The callback, for the caller to destroy where that may run code of its own.
    std::shared_ptr<const Callback> cancel(Id id);

    /// The time of the first; never: there is none.
    TimePoint next() const { return timers_.empty() ? never : timers_.begin()->first.first; }

    /// Takes the first that is due, or null. A periodic one stays, for the next time on its grid
    /// after `now`.
    std::shared_ptr<const Callback> take_due(TimePoint now);

  private:
    struct Timer {
        Duration period;
        // Shared, so that a callback may cancel its own timer.
        std::shared_ptr<const Callback> callback;
    };

    std::map<std::pair<TimePoint, Id>, Timer> timers_;
    Id last_id_ = 0;
};

}  // namespace canorb::runtime
