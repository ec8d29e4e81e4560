#include "orb/runtime/timers.hpp"

#include <algorithm>

namespace canorb::runtime {

Timers::Id Timers::add(TimePoint time, Duration period, Callback callback) {
    const Id id = ++last_id_;
    timers_.emplace(std::pair{time, id},
                    Timer{period, std::make_shared<const Callback>(std::move(callback))});
    return id;
}

std::shared_ptr<const Callback> Timers::cancel(Id id) {
    const auto found = std::find_if(timers_.begin(), timers_.end(),
                                    [&](const auto& timer) { return timer.first.second == id; });
    if (found == timers_.end()) return nullptr;
    std::shared_ptr<const Callback> callback = std::move(found->second.callback);
    timers_.erase(found);
    return callback;
}

std::shared_ptr<const Callback> Timers::take_due(TimePoint now) {
    if (next() > now) return nullptr;
    auto due = timers_.extract(timers_.begin());
    std::shared_ptr<const Callback> callback = due.mapped().callback;
    const Duration period = due.mapped().period;
    if (period > Duration::zero()) {
        TimePoint& time = due.key().first;
        time += period * ((now - time) / period + 1);
        timers_.insert(std::move(due));
    }
    return callback;
}

}  // namespace canorb::runtime
