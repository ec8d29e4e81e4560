#pragma once

/// Calls whose end is fetched later, or told to a callback. A generated stub has both for each
/// two-way operation and attribute, under the names of CORBA's asynchronous messaging:
///
///     canorb::Future<float> left = motor.sendp_speed(1);         // begins the call
///     canorb::Future<float> right = motor.sendp_speed(2);
///     show(left.get(), right.get());                             // waits for their ends
///
///     canorb::PendingCall call = motor.sendc_speed([](canorb::Future<float> speed) {
///         try {
///             show(speed.get());                                 // has ended: does not wait
///         } catch (const canorb::SystemException& e) {
///             log(e.what());
///         }
///     }, 1);
///     call.cancel();
///
/// doc/asynchronous-calls.md has the rest.

#include <functional>
#include <memory>
#include <tuple>
#include <utility>

#include "canorb/pending_reply.hpp"

namespace canorb {

/// What a call begun will give: R is its return value, or its only inout or out parameter; of
/// several a std::tuple, the return value first, then inout and out parameters in their order.
///
/// For one thread at a time; futures of one Orb may be in different threads. It may outlive its
/// Orb. Destroyed before the call has ended, it cancels it.
template <typename R>
class [[nodiscard]] Future {
  public:
    /// Gets the ready Future. Runs from the event loop, as servants and timers do.
    using Callback = std::function<void(Future)>;

    /// Of no call.
    Future() = default;
    /// For stubs.
    Future(PendingReply reply, R (*read)(CallReply&)) : reply_(std::move(reply)), read_(read) {}

    /// Whether it is of a call; not after get(), then() and cancel(), nor when it was moved from.
    bool valid() const { return reply_.valid(); }

    /// Whether get() would return at once. It does none of the ORB's work: see wait_for().
    bool ready() const { return reply_.ready(); }

    /// Waits as get() does, for `duration` or until the call has ended. True: it has. With 0 the
    /// ORB does what is due now.
    bool wait_for(Duration duration) const { return reply_.wait_for(duration); }

    /// Waits for the end of the call, at its deadline at the latest; the thread does the ORB's work
    /// meanwhile. Throws the exceptions that the operation declares and every system exception;
    /// BAD_INV_ORDER when it is of no call, when the call is cancelled meanwhile, and when the Orb
    /// goes before the call has ended.
    R get() { return reply_.get(read_); }

    /// Nobody wants the answer: the Future is of no call then. A message of which no frame has gone
    /// to the controller is withdrawn; else the operation may be executed, and its Reply is dropped
    /// and counted (replies_to_cancelled_calls). Until then, or the deadline, the call is one of
    /// OrbOptions::max_outstanding_calls.
    void cancel() { reply_.cancel(); }

    /// Calls `callback` once the call has ended, by TIMEOUT too: from the event loop, never from
    /// within then(). The Future is of no call then. Throws BAD_INV_ORDER when it is of none, or
    /// when the Orb is gone.
    PendingCall then(Callback callback) {
        struct Waiting {
            Future future;
            Callback callback;
        };
        const auto waiting =
            std::make_shared<Waiting>(Waiting{std::move(*this), std::move(callback)});
        return waiting->future.reply_.when_ended(
            [waiting] { waiting->callback(std::move(waiting->future)); });
    }

  private:
    PendingReply reply_;
    R (*read_)(CallReply&) = nullptr;
};

}  // namespace canorb
