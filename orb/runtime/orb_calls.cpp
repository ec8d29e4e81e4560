// OrbImpl: two-way calls, waited for at once or later.

#include <algorithm>
#include <utility>

#include "orb/base/minor_codes.hpp"
#include "orb/runtime/orb_impl.hpp"

namespace canorb::runtime {

Result<core::CallHandle, SystemError> OrbImpl::begin_call(Lock&, ObjectKey target,
                                                          OperationId operation,
                                                          MutableBytes message, Duration timeout,
                                                          const SentCallback& sent) {
    require_open();
    require_node();
    if (engine_.tracer().on()) engine_.tracer().set_time(now());
    const auto call = engine_.call(target, operation, message, deadline(timeout));
    if (!call) return call;
    const bool refused = engine_.ended(*call);
    after_queueing(engine_.message_of(*call), refused ? SentCallback{} : sent);
    return call;
}

core::CallResult OrbImpl::finish_call(Lock& lock, core::CallHandle call) {
    const auto until = engine_.deadline_of(call);
    // Not for one that has ended: other user code could run meanwhile.
    if (until && !engine_.ended(call) && !closed_) {
        wait(lock, Role::caller, *until, [&] { return engine_.ended(call); });
    }
    if (!engine_.deadline_of(call)) {
        throw_system_exception(cause::call_cancelled);
    }
    if (auto result = engine_.take_result(call)) return std::move(*result);
    if (closed_) throw_system_exception(cause::orb_went_during_call);
    return cause::call_lost;
}

core::CallResult OrbImpl::call(ObjectKey target, OperationId operation, MutableBytes message,
                               Duration timeout, const SentCallback& sent) {
    Lock lock{mutex_};
    const auto call = begin_call(lock, target, operation, message, timeout, sent);
    if (!call) return call.error();
    return finish_call(lock, *call);
}

Result<core::CallHandle, SystemError> OrbImpl::begin_call(ObjectKey target, OperationId operation,
                                                          MutableBytes message, Duration timeout,
                                                          const SentCallback& sent) {
    Lock lock{mutex_};
    return begin_call(lock, target, operation, message, timeout, sent);
}

core::CallResult OrbImpl::finish_call(core::CallHandle call) {
    Lock lock{mutex_};
    return finish_call(lock, call);
}

bool OrbImpl::has_ended(core::CallHandle call) {
    const Lock lock{mutex_};
    return closed_ || engine_.ended(call);
}

bool OrbImpl::wait_for_end(core::CallHandle call, Duration duration) {
    Lock lock{mutex_};
    if (const auto latest = engine_.deadline_of(call); latest && !engine_.ended(call) && !closed_) {
        const TimePoint until = after(std::max(duration, Duration::zero()));
        wait(lock, Role::caller, std::min(until, *latest), [&] { return engine_.ended(call); });
    }
    return closed_ || engine_.ended(call);
}

void OrbImpl::cancel_call(core::CallHandle call) {
    const Lock lock{mutex_};
    if (closed_) return;
    if (engine_.tracer().on()) engine_.tracer().set_time(now());
    engine_.cancel(call);
    collect_notices();
    wake();  // with a message less close() may have waited long enough
}

CallbackId OrbImpl::when_ended(core::CallHandle call, Callback callback) {
    const Lock lock{mutex_};
    require_open();
    const bool ended = engine_.ended(call);
    const CallbackId id = call_callbacks_.add(call, ended, std::move(callback));
    if (ended) {
        wake();
    } else {
        engine_.watch(call);
    }
    return id;
}

void OrbImpl::cancel_callback(CallbackId id) {
    Lock lock{mutex_};
    const Callback callback = call_callbacks_.cancel(id);
    lock.unlock();  // what it holds may call this ORB when it goes, and cancels the call
}

bool OrbImpl::run_call_callback(Lock& lock) {
    if (!call_callbacks_.has_due() || !user_code_.may_call_back()) return false;
    report_failure("the callback of a call", run_callback(lock, call_callbacks_.next()));
    return true;
}

}  // namespace canorb::runtime
