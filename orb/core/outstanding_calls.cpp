#include "orb/core/outstanding_calls.hpp"

#include <algorithm>

#include "orb/base/minor_codes.hpp"

namespace canorb::core {

OutstandingCalls::Call* OutstandingCalls::open(TimePoint deadline) {
    const auto free = std::find_if(calls_.begin(), calls_.end(), [](const Call& call) {
        return call.state == Call::State::free;
    });
    if (free == calls_.end()) return nullptr;
    used_ = std::max(used_, static_cast<std::size_t>(free - calls_.begin()) + 1);
    *free = Call{};
    free->handle = CallHandle{++last_handle_};
    free->state = Call::State::waiting;
    free->deadline = deadline;
    return &*free;
}

bool OutstandingCalls::has_request_id(RequestId id) const {
    return std::ranges::any_of(used(), [&](const Call& call) {
        const bool kept =
            call.state == Call::State::waiting || call.state == Call::State::cancelled;
        return kept && call.peer && call.request_id == id;
    });
}

OutstandingCalls::Call* OutstandingCalls::find(CallHandle handle) {
    for (Call& call : used()) {
        const bool visible = call.state == Call::State::waiting || call.state == Call::State::ended;
        if (visible && call.handle == handle) return &call;
    }
    return nullptr;
}

OutstandingCalls::Call* OutstandingCalls::find_waiting(CallHandle handle) {
    Call* call = find(handle);
    return call != nullptr && call->state == Call::State::waiting ? call : nullptr;
}

OutstandingCalls::Call* OutstandingCalls::find_waiting(NodeId peer, RequestId id) {
    for (Call& call : used()) {
        if (call.state == Call::State::waiting && call.peer == peer && call.request_id == id) {
            return &call;
        }
    }
    return nullptr;
}

OutstandingCalls::Call* OutstandingCalls::find_waiting(caniop::MessageHandle message) {
    for (Call& call : used()) {
        if (call.state == Call::State::waiting && call.message == message) return &call;
    }
    return nullptr;
}

void OutstandingCalls::end(Call& call, CallResult result) {
    call.state = Call::State::ended;
    call.end_number = ++ends_;
    call.result = std::move(result);
}

template <typename Belongs>
bool OutstandingCalls::drop_cancelled_if(Belongs belongs) {
    for (Call& call : used()) {
        if (call.state == Call::State::cancelled && belongs(call)) {
            discard(call);
            return true;
        }
    }
    return false;
}

bool OutstandingCalls::drop_cancelled(NodeId peer, RequestId id) {
    return drop_cancelled_if(
        [&](const Call& call) { return call.peer == peer && call.request_id == id; });
}

bool OutstandingCalls::drop_cancelled(CallHandle handle) {
    return drop_cancelled_if([&](const Call& call) { return call.handle == handle; });
}

void OutstandingCalls::expire_cancelled(TimePoint now) {
    while (drop_cancelled_if([&](const Call& call) { return call.deadline <= now; })) {
    }
}

std::optional<CallHandle> OutstandingCalls::next_watched() {
    Call* first = nullptr;
    for (Call& call : used()) {
        if (call.state != Call::State::ended || !call.watched) continue;
        if (first == nullptr || call.end_number < first->end_number) first = &call;
    }
    if (first == nullptr) return std::nullopt;
    first->watched = false;
    return first->handle;
}

void OutstandingCalls::discard(Call& call) {
    call.state = Call::State::free;
    while (used_ > 0 && calls_[used_ - 1].state == Call::State::free) --used_;
}

std::optional<CallResult> OutstandingCalls::take(CallHandle handle) {
    Call* call = find(handle);
    if (call == nullptr) return CallResult{cause::call_lost};
    if (call->state == Call::State::waiting) return std::nullopt;
    CallResult result = std::move(call->result);
    discard(*call);
    return result;
}

bool OutstandingCalls::any_waiting() const {
    return std::ranges::any_of(used(),
                               [](const Call& call) { return call.state == Call::State::waiting; });
}

TimePoint OutstandingCalls::next_deadline() const {
    TimePoint earliest = never;
    for (const Call& call : used()) {
        const bool has_deadline =
            call.state == Call::State::waiting || call.state == Call::State::cancelled;
        if (has_deadline) earliest = std::min(earliest, call.deadline);
    }
    return earliest;
}

}  // namespace canorb::core
