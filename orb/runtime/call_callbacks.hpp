#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "orb/core/outstanding_calls.hpp"
#include "orb/runtime/timers.hpp"

namespace canorb::runtime {

/// Names a callback of one ORB that waits for the end of a call; never used twice.
enum class CallbackId : std::uint64_t {};

/// The callbacks that wait for the end of a call, and those that are to be called.
///
/// Invariant: each is given once, by next() or by cancel(), and called by whoever has it from
/// next().
class CallCallbacks {
  public:
    /// `ended`: it is to be called now.
    CallbackId add(core::CallHandle call, bool ended, Callback callback);
    /// The call has ended.
    void ended(core::CallHandle call);
    /// Whether next() has something to give.
    bool has_due() const { return !due_.empty(); }
    /// The next to be called, in the order of the ends of their calls. Precondition: has_due().
    Callback next();
    /// The callback, for the caller to destroy where that may run code of its own.
    Callback cancel(CallbackId id);

  private:
    struct Entry {
        CallbackId id;
        core::CallHandle call;
        Callback callback;
    };

    std::vector<Entry> waiting_;
    std::deque<Entry> due_;
    std::uint64_t last_id_ = 0;
};

}  // namespace canorb::runtime
