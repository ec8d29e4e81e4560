// OrbImpl: the event loop, and how threads wait in it.

#include <algorithm>

#include "orb/poa/servant.hpp"
#include "orb/runtime/orb_impl.hpp"

namespace canorb::runtime {
namespace {

/// Events from the controller between two looks at the clock.
constexpr int max_events_in_a_row = 256;

/// Events that wait for the event loop; more are only counted.
constexpr std::size_t max_waiting_events = 256;

/// Frames that a link takes at once and that are sent before it is asked what has come.
constexpr int max_frames_in_a_row = 16;

/// Servant calls and callbacks that one poll() runs at most.
constexpr std::size_t max_polled = 256;

}  // namespace

// ---- waiting

bool OrbImpl::wait(Lock& lock, Role role, TimePoint deadline, const Condition& done) {
    if (Simulation* simulation = bus_.simulation()) {
        lock.unlock();
        const bool ok = simulation->run_until(
            [&] {
                const Lock again{mutex_};
                return done();
            },
            deadline);
        lock.lock();
        return ok;
    }
    ++waiting_;
    if (role == Role::loop) ++loops_;
    bool is_done = false;
    for (;;) {
        const TimePoint time = now();
        // What came may be another thread's, who cannot see it any more where it sleeps.
        if (exchange(time, may_run(role))) wake();
        is_done = done();
        // A caller that runs no event loop learns that its call was sent before it returns.
        if (is_done && role == Role::caller && may_run(role) && run_sent(lock)) continue;
        if (is_done && role == Role::caller && may_run(role) && run_trace(lock)) continue;
        if (is_done || closed_ || time >= deadline) break;
        if (user_code_.is_too_deep() && refuse_nested(time)) continue;
        if (may_run(role) && run_one(lock)) continue;
        if (may_have_events_) continue;
        const TimePoint until = std::min(deadline, wakeup(role));
        if (!leading_) {
            lead(lock, until);
            continue;
        }
        ++sleeping_;
        if (until == never) {
            changed_.wait(lock);
        } else {
            changed_.wait_for(lock, until - time);
        }
        --sleeping_;
    }
    --waiting_;
    if (role == Role::loop) --loops_;
    // Somebody else must lead now, and what this thread left is perhaps theirs to run.
    wake();
    return is_done;
}

void OrbImpl::lead(Lock& lock, TimePoint until) {
    const Duration longest = until == never ? Duration::max() : until - now();
    const int fd = wakes_leader_ ? -1 : controller_->event_fd();
    bool came = true;  // where nothing tells, it is to be asked
    leading_ = true;
    lock.unlock();
    if (wakes_leader_) {
        sleeper_->sleep(longest);
    } else {
        came = sleeper_->sleep_for(fd, longest);
    }
    lock.lock();
    leading_ = false;
    may_have_events_ = may_have_events_ || came;
    wake_sleepers();
}

void OrbImpl::wake() {
    if (leading_) sleeper_->wake();
    if (watch_) watch_->raise();
    wake_sleepers();
}

void OrbImpl::wake_sleepers() {
    if (sleeping_ > 0) changed_.notify_all();
}

bool OrbImpl::may_run(Role role) const {
    if (role == Role::closing || !user_code_.may_begin()) return false;
    return role == Role::loop || loops_ == 0 || user_code_.is_here();
}

TimePoint OrbImpl::wakeup(Role role) const {
    const TimePoint engine = engine_.next_deadline();
    return may_run(role) && user_code_.may_call_back()
               ? std::min({engine, timers_.next(), restart_due_})
               : engine;
}

bool OrbImpl::exchange(TimePoint now, bool serving) {
    bool any = false;
    for (int i = 0; may_have_events_ && i < max_events_in_a_row; ++i) {
        // Requests are served as they come, so that a burst of them waits in the controller's
        // receive queue and not in ours.
        if (serving && engine_.has_request()) break;
        if (const auto event = controller_->poll()) {
            engine_.on_event(*event, now);
            any = true;
        } else {
            may_have_events_ = false;
        }
    }
    engine_.on_time(now);
    collect_notices();
    transmit(now);
    return any;
}

void OrbImpl::collect_notices() {
    while (const auto notice = engine_.next_notice()) {
        if (const auto* sent = std::get_if<core::MessageSent>(&*notice)) {
            if (auto callback = take_sent_callback(sent->message)) {
                sent_.push_back(std::move(*callback));
            }
        } else if (const auto* dropped = std::get_if<core::MessageDropped>(&*notice)) {
            if (auto callback = take_sent_callback(dropped->message)) {
                unsent_.push_back(std::move(*callback));
            }
        } else {
            add_event(describe(*notice));
        }
    }
    while (const auto call = engine_.next_ended()) call_callbacks_.ended(*call);
}

void OrbImpl::add_event(Event event) {
    if (events_.size() < max_waiting_events) {
        events_.push_back(std::move(event));
    } else {
        engine_.count(Counter::notices_lost);
    }
}

void OrbImpl::transmit(TimePoint now) {
    if (engine_.filters_changed()) {
        const auto filters = engine_.take_filters(controller_->capabilities());
        if (filters && !controller_->set_filters(filters->span())) {
            add_event({Event::Kind::controller_state, now,
                       "the CAN controller has no room for " + std::to_string(filters->size()) +
                           " acceptance filters: this node may not hear all of its groups"});
        }
    }
    while (const auto frame = engine_.next_abort()) controller_->abort(*frame);
    int frames = 0;
    while (const auto frame = engine_.next_frame(now)) {
        if (++frames > max_frames_in_a_row) {
            may_have_events_ = true;
            break;
        }
        const can::SendResult result = controller_->send(*frame);
        if (const auto* handle = std::get_if<can::TransmitHandle>(&result)) {
            engine_.handed_over(*handle);
        } else if (const auto* sent = std::get_if<can::TransmitResult>(&result)) {
            engine_.handed_over(sent->handle);
            engine_.on_event(*sent, now);
        } else {
            break;  // full, or an event about the link's state is on its way
        }
    }
    collect_notices();
}

bool OrbImpl::refuse_nested(TimePoint now) {
    bool any = false;
    while (auto request = engine_.next_request(now)) {
        engine_.count(request->group ? Counter::group_requests_dropped : Counter::requests_refused);
        engine_.refuse(request->answer_to, cause::nested_too_deep, now);
        engine_.buffers().release(std::move(request->parameters));
        any = true;
    }
    if (any) wake();  // a caller of an object of this node has its answer
    return any;
}

// ---- the event loop

bool OrbImpl::run_until(TimePoint deadline) {
    Lock lock{mutex_};
    require_open();
    wait(lock, Role::loop, deadline, [&] { return shut_down_.load(); });
    return !shut_down_;
}

void OrbImpl::poll() {
    Lock lock{mutex_};
    require_open();
    if (bus_.simulation() != nullptr) {
        wait(lock, Role::loop, now(), [] { return false; });
        return;
    }
    ++waiting_;
    may_have_events_ = true;  // nobody has waited for the controller
    exchange(now(), may_run(Role::loop));
    // Not for ever: who polls has other things to do.
    bool any_left = true;
    for (std::size_t i = 0; i < max_polled && !closed_; ++i) {
        any_left = may_run(Role::loop) && run_one(lock);
        if (!any_left) break;
        exchange(now(), true);
    }
    --waiting_;
    wake();
    if (watch_) watch_->rearm(any_left || may_have_events_ ? now() : wakeup(Role::loop));
}

int OrbImpl::event_fd() {
    const Lock lock{mutex_};
    require_open();
    if (bus_.simulation() != nullptr) {
        throw_system_exception(
            cause::not_in_a_simulation,
            "the time of a simulation does not pass by itself: there is no event_fd()");
    }
    if (!watch_) {
        watch_.emplace(controller_->event_fd());
        watch_->raise();  // what is due already
    }
    return watch_->fd();
}

bool OrbImpl::drain(Duration limit) {
    Lock lock{mutex_};
    require_open();
    require_no_user_code("drain()");
    return wait(lock, Role::loop, after(limit), [&] {
        return engine_.is_idle() && servant_calls_.empty() && sent_.empty() &&
               !call_callbacks_.has_due() && events_.empty();
    });
}

void OrbImpl::run_worker() {
    Lock lock{mutex_};
    wait(lock, Role::loop, never, [&] { return stop_workers_ || shut_down_; });
}

void OrbImpl::stop_workers() {
    Lock lock{mutex_};
    stop_workers_ = true;
    wake();
    lock.unlock();
    for (std::thread& worker : workers_) worker.join();
    workers_.clear();
}

void OrbImpl::shutdown() noexcept {
    shut_down_ = true;
    sleeper_->wake();
}

TimerId OrbImpl::add_timer(TimePoint time, Duration period, Callback callback) {
    const Lock lock{mutex_};
    require_open();
    const auto id = timers_.add(time, period, std::move(callback));
    wake();
    return TimerId{id};
}

void OrbImpl::cancel_timer(TimerId timer) {
    Lock lock{mutex_};
    const auto cancelled = timers_.cancel(static_cast<Timers::Id>(timer));
    lock.unlock();  // what the callback holds may call this ORB when it goes
}

bool OrbImpl::work() {
    Lock lock{mutex_};
    const TimePoint time = now();
    may_have_events_ = true;  // a virtual bus wakes nobody
    // What came may have ended a call: its caller must know before time goes on.
    const bool came = exchange(time, may_run(Role::loop));
    if (user_code_.is_too_deep()) return refuse_nested(time) || came;
    return (may_run(Role::loop) && run_one(lock)) || came;
}

bool OrbImpl::run_due_timer() {
    Lock lock{mutex_};
    return may_run(Role::loop) && run_timer(lock);
}

TimePoint OrbImpl::next_wakeup() const {
    const Lock lock{mutex_};
    return wakeup(Role::loop);
}

}  // namespace canorb::runtime
