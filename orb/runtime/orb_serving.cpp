// OrbImpl: servants and callbacks, one at a time.

#include <algorithm>
#include <string>
#include <utility>

#include "orb/giop/message.hpp"
#include "orb/poa/servant.hpp"
#include "orb/runtime/orb_impl.hpp"

namespace canorb::runtime {

bool OrbImpl::run_one(Lock& lock) {
    const bool may_call_back = user_code_.may_call_back();
    if (may_call_back && !unsent_.empty()) {
        // What a callback holds may call this ORB when it goes.
        auto unsent = std::exchange(unsent_, {});
        run_callback(lock, [&] { unsent.clear(); });
        return true;
    }
    if (may_call_back && !events_.empty()) {
        Event event = std::move(events_.front());
        events_.pop_front();
        report(lock, std::move(event));
        return true;
    }
    if (run_trace(lock)) return true;
    if (run_sent(lock) || run_call_callback(lock) || run_restart(lock)) return true;
    // A simulation runs timers itself, in its order.
    const bool runs_timers = bus_.simulation() == nullptr;
    // They take turns, so that neither a flood of requests nor a slow timer keeps the other out.
    if (runs_timers && served_last_ && run_timer(lock)) {
        served_last_ = false;
        return true;
    }
    if (engine_.has_request()) {
        if (auto request = engine_.next_request(now())) {
            served_last_ = true;
            serve(lock, std::move(*request));
        } else {  // all were held, or are answered
            transmit(now());
            wake();
        }
        return true;
    }
    return runs_timers && run_timer(lock);
}

bool OrbImpl::run_sent(Lock& lock) {
    if (sent_.empty() || !user_code_.may_call_back()) return false;
    SentCallback callback = std::move(sent_.front());
    sent_.pop_front();
    report_failure("a with_sent callback", run_callback(lock, std::move(callback)));
    return true;
}

bool OrbImpl::run_restart(Lock& lock) {
    if (restart_due_ == never || !user_code_.may_call_back()) return false;
    // Who asked for it is to get the answer, which another thread may not even have queued.
    const bool answered = engine_.queued_messages() == 0 &&
                          std::ranges::find(servant_calls_, management_object_index,
                                            &ServantCall::object) == servant_calls_.end();
    if (!answered && now() < restart_due_) return false;
    restart_due_ = never;
    const std::string failure =
        run_callback(lock, [callback = restart_callback_] { (*callback)(); });
    report_failure("the restart callback", failure);
    return true;
}

bool OrbImpl::run_timer(Lock& lock) {
    if (!user_code_.may_call_back()) return false;
    auto callback = timers_.take_due(now());
    if (!callback) return false;
    report_failure("a timer", run_callback(lock, [timer = std::move(callback)] { (*timer)(); }));
    return true;
}

std::string OrbImpl::run_callback(Lock& lock, std::function<void()> code) {
    const auto before = user_code_.begin_callback();
    std::string failure = run_user_code(lock, std::move(code));
    user_code_.end_callback(before);
    return failure;
}

std::string OrbImpl::run_user_code(Lock& lock, std::function<void()> code) {
    user_code_.begin();
    lock.unlock();
    std::string failure;
    try {
        code();
    } catch (const std::exception& exception) {
        failure = exception.what();
    } catch (...) {
        failure = "an exception that is no std::exception";
    }
    code = nullptr;  // here, because what it holds may call this ORB when it goes
    lock.lock();
    user_code_.end();
    // Other threads may run user code and callbacks once the mutex is released, and may have a
    // deadline that was not there before.
    wake();
    return failure;
}

void OrbImpl::report_failure(std::string_view what, const std::string& failure) {
    if (failure.empty()) return;
    add_event({Event::Kind::servant_exception, now(), std::string{what} + " raised " + failure});
}

void OrbImpl::serve(Lock& lock, core::IncomingRequest request) {
    if (request.group) {
        serve_group(lock, request);
    } else {
        serve_object(lock, request);
    }
    engine_.buffers().release(std::move(request.parameters));
    transmit(now());
    wake();  // the caller may be a thread of this program
}

void OrbImpl::call_servant(Lock& lock, ObjectIndex object, Servant& servant, ServerCall& call) {
    engine_.count(Counter::requests_dispatched);
    servant_calls_.push_back({&servant, object, engine_.adapter().poa_of(object)});
    const ServantCall this_call = servant_calls_.back();
    const std::string failure = run_user_code(lock, [&servant, &call] {
        try {
            poa::dispatch(servant, call);
        } catch (const SystemException& exception) {
            call.fail(exception.error());
        } catch (...) {
            call.fail(cause::undeclared_exception);
            throw;  // for the log: the caller learns no more than UNKNOWN
        }
    });
    // The servant may be gone. Of equal calls any one will do.
    servant_calls_.erase(std::ranges::find(servant_calls_, this_call));
    if (!failure.empty()) {
        report_failure("operation " + std::to_string(call.operation()) + " of object " +
                           std::to_string(object),
                       failure);
    }
    const bool failed = call.outcome() == ServerCall::Outcome::system_exception ||
                        call.outcome() == ServerCall::Outcome::user_exception;
    if (failed && call.is_oneway()) engine_.count(Counter::group_requests_failed);
}

void OrbImpl::serve_object(Lock& lock, const core::IncomingRequest& request) {
    Servant* servant = engine_.adapter().find(request.object);
    if (servant == nullptr) {
        engine_.count(Counter::requests_refused);
        engine_.refuse(request.answer_to, cause::no_such_object, now());
        return;
    }
    core::Buffer buffer = message_buffers_.take();
    const MutableBytes message{buffer};
    ServerCall call{request.operation, ccdr::Decoder{request.parameters, &owner_},
                    message.subspan(giop::reply_header_size)};
    call_servant(lock, request.object, *servant, call);
    if (!call.is_oneway()) {
        if (call.outcome() == ServerCall::Outcome::system_exception) {
            engine_.refuse(request.answer_to, call.system_error(), now());
        } else {
            const auto status = call.outcome() == ServerCall::Outcome::user_exception
                                    ? giop::ReplyStatus::user_exception
                                    : giop::ReplyStatus::no_exception;
            engine_.answer(request.answer_to, status,
                           message.first(giop::reply_header_size + call.body().size()), now());
        }
    }
    message_buffers_.give_back(std::move(buffer));
}

void OrbImpl::serve_group(Lock& lock, const core::IncomingRequest& request) {
    // A copy, in octets: a servant may leave, or make another one leave, while this runs.
    core::Buffer members = engine_.buffers().acquire();
    for (const mca::Member& member : engine_.agent().members(*request.group)) {
        if (request.one_member && member.index != request.object) continue;
        members.resize(members.size() + 2);
        write_be16(&members[members.size() - 2], member.index);
    }
    core::Buffer buffer = message_buffers_.take();
    for (std::size_t at = 0; at < members.size(); at += 2) {
        serve_member(lock, request, read_be16(members.data() + at), buffer);
    }
    message_buffers_.give_back(std::move(buffer));
    engine_.buffers().release(std::move(members));
}

void OrbImpl::serve_member(Lock& lock, const core::IncomingRequest& request, ObjectIndex member,
                           MutableBytes buffer) {
    Servant* servant = engine_.adapter().find(member);
    if (servant == nullptr || !engine_.agent().is_member(*request.group, member)) return;
    if (request.interface_key != 0 &&
        !servant->_interface_info().has_group_key(request.interface_key)) {
        engine_.count(Counter::group_interface_mismatches);
        return;
    }
    if (!engine_.admit(request, member)) return;
    ServerCall call{request.operation, ccdr::Decoder{request.parameters, &owner_}, buffer};
    call.oneway();
    call_servant(lock, member, *servant, call);
}

Event OrbImpl::describe(const core::Notice& notice) const {
    if (const auto* changed = std::get_if<core::ControllerChanged>(&notice)) {
        const can::ErrorStatus& status = changed->change.status;
        std::string text = "the CAN controller is " + std::string{can::name(status.state)} +
                           " (TEC " + std::to_string(status.tec) + ", REC " +
                           std::to_string(status.rec) + ")";
        if (const std::string more = controller_->explanation(); !more.empty()) text += ": " + more;
        return {Event::Kind::controller_state, changed->change.time, std::move(text)};
    }
    if (const auto* lost = std::get_if<core::LinkLostFrames>(&notice)) {
        return {Event::Kind::frames_lost, lost->loss.time,
                "the link lost " + std::to_string(lost->loss.count) +
                    " received frames; partial messages were dropped"};
    }
    const TimePoint seen = std::get<core::DuplicateNodeSeen>(notice).time;
    const std::string number =
        engine_.node() ? std::to_string(engine_.node()->value()) : std::string{"?"};
    return {Event::Kind::duplicate_node, seen,
            "another node on this bus uses node id " + number +
                ", as this one does; its frames are ignored: give one of them another id"};
}

void OrbImpl::report(Lock& lock, Event event) {
    event.text = options_.name + ": " + event.text;
    // Held by the code alone: it may be replaced meanwhile, and must not go with the mutex held.
    const std::string failure = run_callback(lock, [this, callback = event_callback_, &event] {
        options_.log(event.text);
        if (callback && *callback) (*callback)(event);
    });
    if (failure.empty()) return;
    // No event, which would raise the same again.
    run_callback(lock, [this, &failure] {
        options_.log(options_.name + ": the event callback raised " + failure);
    });
}

}  // namespace canorb::runtime
