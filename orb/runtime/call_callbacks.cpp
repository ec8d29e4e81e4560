#include "orb/runtime/call_callbacks.hpp"

#include <algorithm>
#include <utility>

namespace canorb::runtime {

CallbackId CallCallbacks::add(core::CallHandle call, bool ended, Callback callback) {
    const CallbackId id{++last_id_};
    if (ended) {
        due_.push_back({id, call, std::move(callback)});
    } else {
        waiting_.push_back({id, call, std::move(callback)});
    }
    return id;
}

void CallCallbacks::ended(core::CallHandle call) {
    const auto found = std::find_if(waiting_.begin(), waiting_.end(),
                                    [&](const Entry& entry) { return entry.call == call; });
    if (found == waiting_.end()) return;
    due_.push_back(std::move(*found));
    waiting_.erase(found);
}

Callback CallCallbacks::next() {
    Callback callback = std::move(due_.front().callback);
    due_.pop_front();
    return callback;
}

Callback CallCallbacks::cancel(CallbackId id) {
    const auto take = [&](auto& entries) -> Callback {
        const auto found = std::find_if(entries.begin(), entries.end(),
                                        [&](const Entry& entry) { return entry.id == id; });
        if (found == entries.end()) return nullptr;
        Callback callback = std::move(found->callback);
        entries.erase(found);
        return callback;
    };
    if (Callback callback = take(waiting_)) return callback;
    return take(due_);
}

}  // namespace canorb::runtime
