// Engine: Requests on their way to servants.

#include <algorithm>
#include <utility>

#include "orb/base/minor_codes.hpp"
#include "orb/core/engine.hpp"

namespace canorb::core {
namespace {

// That there is no object is for its owner to tell, who looks for the servant anyway.
bool goes_on(poa::Admission admission) {
    return admission == poa::Admission::dispatch || admission == poa::Admission::not_active;
}

}  // namespace

void Engine::begin(const IncomingRequest& request) {
    const auto* local = std::get_if<LocalCaller>(&request.answer_to);
    if (local == nullptr) return;
    if (OutstandingCalls::Call* call = calls_.find_waiting(local->call)) call->begun = true;
}

// A caller in this node that has its TIMEOUT, completion NO: its call must not run after that.
bool Engine::is_wanted(const IncomingRequest& request) {
    const auto* local = std::get_if<LocalCaller>(&request.answer_to);
    return local == nullptr || calls_.find_waiting(local->call) != nullptr;
}

void Engine::give_up(IncomingRequest request) {
    buffers_.release(std::move(request.parameters));
}

void Engine::turn_away(IncomingRequest request, poa::Admission why, TimePoint now) {
    if (request.group) {
        counters_.add(Counter::group_requests_dropped);
    } else {
        const SystemError& error = why == poa::Admission::inactive ? cause::manager_inactive
                                   : why == poa::Admission::hold   ? cause::hold_queue_full
                                                                   : cause::manager_discards;
        counters_.add(Counter::requests_refused);
        refuse(request.answer_to, error, now);
    }
    give_up(std::move(request));
}

bool Engine::has_room_to_hold(ObjectIndex object) {
    const auto manager_of = [&](ObjectIndex index) {
        const auto poa = adapter_.poa_of(index);
        return poa ? std::optional{adapter_.manager(*poa)} : std::nullopt;
    };
    const auto manager = manager_of(object);
    const auto held = std::ranges::count_if(held_, [&](const IncomingRequest& request) {
        return manager_of(request.object) == manager;
    });
    return static_cast<std::size_t>(held) < options_.max_held_requests;
}

std::optional<IncomingRequest> Engine::next_held(TimePoint now) {
    if (!held_may_go_) return std::nullopt;
    for (auto at = held_.begin(); at != held_.end();) {
        const poa::Admission admission = adapter_.admission(at->object);
        if (admission == poa::Admission::hold) {
            ++at;
            continue;
        }
        IncomingRequest request = std::move(*at);
        at = held_.erase(at);
        if (!is_wanted(request)) {
            give_up(std::move(request));
        } else if (goes_on(admission)) {
            begin(request);
            return request;
        } else {
            turn_away(std::move(request), admission, now);
        }
    }
    held_may_go_ = false;
    return std::nullopt;
}

std::optional<IncomingRequest> Engine::next_request(TimePoint now) {
    if (auto held = next_held(now)) return held;
    while (auto request = incoming_.pop()) {
        if (request->group) return request;
        if (!is_wanted(*request)) {
            give_up(std::move(*request));
            continue;
        }
        const poa::Admission admission = adapter_.admission(request->object);
        if (goes_on(admission)) {
            begin(*request);
            return request;
        }
        if (admission == poa::Admission::hold && has_room_to_hold(request->object)) {
            held_.push_back(std::move(*request));
        } else {
            turn_away(std::move(*request), admission, now);
        }
    }
    return std::nullopt;
}

bool Engine::admit(const IncomingRequest& request, ObjectIndex member) {
    const poa::Admission admission = adapter_.admission(member);
    if (admission == poa::Admission::dispatch) return true;
    if (admission == poa::Admission::hold && has_room_to_hold(member)) {
        IncomingRequest held;
        held.group = request.group;
        held.object = member;
        held.one_member = true;
        held.interface_key = request.interface_key;
        held.operation = request.operation;
        held.parameters = buffers_.copy_of(request.parameters);
        held_.push_back(std::move(held));
    } else {
        counters_.add(Counter::group_requests_dropped);
    }
    return false;
}

}  // namespace canorb::core
