// OrbImpl: messages shown to the log and to the application.

#include <memory>
#include <string>
#include <utility>

#include "orb/runtime/orb_impl.hpp"

namespace canorb::runtime {

void OrbImpl::on_message(std::function<void(const MessageTrace&)> callback) {
    const bool wanted = options_.trace || callback;
    auto shared =
        std::make_shared<const std::function<void(const MessageTrace&)>>(std::move(callback));
    Lock lock{mutex_};
    message_callback_.swap(shared);
    engine_.tracer().turn(wanted);
    lock.unlock();  // what the old one holds may call this ORB when it goes
}

void OrbImpl::log_trace(const MessageTrace& trace) const {
    options_.log(options_.name + ": " + to_string(trace));
}

bool OrbImpl::run_trace(Lock& lock) {
    if (!user_code_.may_call_back()) return false;
    const auto trace = engine_.tracer().next();
    if (!trace) return false;
    // Held by the code alone: it may be replaced meanwhile, and must not go with the mutex held.
    const std::string failure = run_callback(lock, [this, callback = message_callback_, &trace] {
        if (options_.trace) log_trace(*trace);
        if (callback && *callback) (*callback)(*trace);
    });
    report_failure("the on_message callback", failure);
    return true;
}

void OrbImpl::log_last_traces(Lock& lock) {
    while (options_.trace) {
        const auto trace = engine_.tracer().next();
        if (!trace) return;
        run_callback(lock, [this, &trace] { log_trace(*trace); });
    }
}

}  // namespace canorb::runtime
