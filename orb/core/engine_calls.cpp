// Engine: what its owner asks about a two-way call, and cancels.

#include "orb/core/engine.hpp"

namespace canorb::core {

std::optional<caniop::MessageHandle> Engine::message_of(CallHandle handle) {
    const OutstandingCalls::Call* call = calls_.find(handle);
    return call == nullptr ? std::nullopt : call->message;
}

bool Engine::ended(CallHandle handle) {
    const OutstandingCalls::Call* call = calls_.find(handle);
    return call == nullptr || call->state == OutstandingCalls::Call::State::ended;
}

std::optional<TimePoint> Engine::deadline_of(CallHandle handle) {
    const OutstandingCalls::Call* call = calls_.find(handle);
    if (call == nullptr) return std::nullopt;
    return call->deadline;
}

void Engine::watch(CallHandle handle) {
    if (OutstandingCalls::Call* call = calls_.find(handle)) call->watched = true;
}

void Engine::cancel(CallHandle handle) {
    OutstandingCalls::Call* call = calls_.find(handle);
    if (call == nullptr) return;
    if (call->state == OutstandingCalls::Call::State::ended) {
        if (auto* answer = std::get_if<CallAnswer>(&call->result)) {
            buffers_.release(std::move(answer->body));
        }
        calls_.discard(*call);
    } else if (!call->peer && !call->begun) {
        calls_.discard(*call);  // next_request() passes it over
    } else if (call->message && queue_.withdraw(*call->message)) {
        if (tracer_.on()) tracer_.withdrawn(*call->message);
        notify(MessageDropped{*call->message});
        calls_.discard(*call);
    } else {
        calls_.cancel(*call);
    }
}

void Engine::drop_reply(bool to_cancelled_call) {
    counters_.add(to_cancelled_call ? Counter::replies_to_cancelled_calls
                                    : Counter::unmatched_replies);
}

}  // namespace canorb::core
