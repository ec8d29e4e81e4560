#include "orb/core/outstanding_calls.hpp"

#include <algorithm>

namespace canorb::core {

OutstandingCalls::Call* OutstandingCalls::open(TimePoint deadline) {
    const auto free = std::find_if(calls_.begin(), calls_.end(), [](const Call& call) {
        return call.state == Call::State::free;
    });
    if (free == calls_.end()) return nullptr;
    *free = Call{};
    free->handle = CallHandle{++last_handle_};
    free->state = Call::State::waiting;
    free->deadline = deadline;
    return &*free;
}

bool OutstandingCalls::has_request_id(RequestId id) const {
    return std::any_of(calls_.begin(), calls_.end(), [&](const Call& call) {
        return call.state == Call::State::waiting && call.peer && call.request_id == id;
    });
}

OutstandingCalls::Call* OutstandingCalls::find(CallHandle handle) {
    for (Call& call : calls_) {
        if (call.state != Call::State::free && call.handle == handle) return &call;
    }
    return nullptr;
}

OutstandingCalls::Call* OutstandingCalls::find_waiting(CallHandle handle) {
    Call* call = find(handle);
    return call != nullptr && call->state == Call::State::waiting ? call : nullptr;
}

OutstandingCalls::Call* OutstandingCalls::find_waiting(NodeId peer, RequestId id) {
    for (Call& call : calls_) {
        if (call.state == Call::State::waiting && call.peer == peer && call.request_id == id) {
            return &call;
        }
    }
    return nullptr;
}

OutstandingCalls::Call* OutstandingCalls::find_waiting(caniop::MessageHandle message) {
    for (Call& call : calls_) {
        if (call.state == Call::State::waiting && call.message == message) return &call;
    }
    return nullptr;
}

void OutstandingCalls::end(Call& call, CallResult result) {
    call.state = Call::State::ended;
    call.result = std::move(result);
}

std::optional<CallResult> OutstandingCalls::take(CallHandle handle) {
    Call* call = find(handle);
    if (call == nullptr) return CallResult{SystemError{SystemErrorKind::internal}};
    if (call->state == Call::State::waiting) return std::nullopt;
    call->state = Call::State::free;
    return std::move(call->result);
}

TimePoint OutstandingCalls::next_deadline() const {
    TimePoint earliest = never;
    for (const Call& call : calls_) {
        if (call.state == Call::State::waiting) earliest = std::min(earliest, call.deadline);
    }
    return earliest;
}

}  // namespace canorb::core
