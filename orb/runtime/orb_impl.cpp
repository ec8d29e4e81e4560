#include "orb/runtime/orb_impl.hpp"

#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "orb/giop/message.hpp"
#include "orb/poa/servant.hpp"

namespace canorb::runtime {
namespace {

constexpr std::size_t max_name = 16;

/// Events from the controller between two looks at the clock.
constexpr int max_events_in_a_row = 256;

/// Events that wait for the event loop; more are only counted.
constexpr std::size_t max_waiting_events = 256;

/// Frames that a link takes at once and that are sent before it is asked what has come.
constexpr int max_frames_in_a_row = 16;

/// Servant calls and callbacks that one poll() runs at most.
constexpr std::size_t max_polled = 256;

std::string in_words(Duration duration) {
    return std::to_string(duration.count()) + " ns";
}

OrbOptions checked(OrbOptions options) {
    if (options.node && !NodeId::from(*options.node)) {
        throw BAD_PARAM("node " + std::to_string(*options.node) + " is not 0 to 30");
    }
    if (options.name.size() > max_name) {
        throw BAD_PARAM("the node's name '" + options.name + "' is longer than 16 characters");
    }
    if (options.name.empty()) {
        options.name = options.node ? "node-" + std::to_string(*options.node) : "node";
    }
    if (options.default_timeout <= Duration::zero()) {
        throw BAD_PARAM("default_timeout " + in_words(options.default_timeout) +
                        " is not greater than 0");
    }
    if (options.max_message < giop::request_header_size ||
        options.max_message > giop::max_message) {
        throw BAD_PARAM("max_message " + std::to_string(options.max_message) +
                        " is not 8 to 65538 octets");
    }
    if (options.max_queued_messages == 0 || options.max_outstanding_calls == 0 ||
        options.frames_in_controller == 0) {
        throw BAD_PARAM(
            "max_queued_messages, max_outstanding_calls and frames_in_controller must not be 0");
    }
    if (options.inter_frame_timeout <= Duration::zero()) {
        throw BAD_PARAM("inter_frame_timeout " + in_words(options.inter_frame_timeout) +
                        " is not greater than 0");
    }
    if (options.continuation_gap < Duration::zero() ||
        options.continuation_gap >= options.inter_frame_timeout / 2) {
        throw BAD_PARAM("continuation_gap " + in_words(options.continuation_gap) +
                        " is not from 0 to less than half of inter_frame_timeout " +
                        in_words(options.inter_frame_timeout));
    }
    if (!options.log) {
        options.log = [](std::string_view line) {
            std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
        };
    }
    return options;
}

core::EngineOptions engine_options(const OrbOptions& options, Simulation* simulation) {
    core::EngineOptions engine;
    if (options.node) engine.node = NodeId::from(*options.node);
    engine.answer_lifetime = options.default_timeout;
    engine.max_outstanding_calls = options.max_outstanding_calls;
    engine.receive.max_message = options.max_message;
    engine.receive.inter_frame_timeout = options.inter_frame_timeout;
    engine.transmit.max_messages = options.max_queued_messages;
    engine.transmit.frames_in_controller = options.frames_in_controller;
    engine.transmit.inter_frame_timeout = options.inter_frame_timeout;
    engine.transmit.continuation_gap = options.continuation_gap;
    engine.first_request_id = simulation != nullptr
                                  ? simulation->impl().first_request_id()
                                  : static_cast<RequestId>(std::random_device{}());
    return engine;
}

}  // namespace

OrbImpl::OrbImpl(Bus& bus, OrbOptions options)
    : bus_(bus),
      options_(checked(std::move(options))),
      controller_(bus.attach(options_.name)),
      engine_(engine_options(options_, bus_.simulation())) {
    const can::ErrorStatus status = controller_->error_status();
    if (status.state != can::ControllerState::error_active) {
        engine_.on_event(can::StateChanged{status, now()}, now());
    }
    if (Simulation* simulation = bus_.simulation()) simulation->impl().add(*this);
    Lock lock{mutex_};
    transmit(now());  // installs the filters
}

OrbImpl::~OrbImpl() = default;

void OrbImpl::close() {
    Lock lock{mutex_};
    if (bus_.simulation() == nullptr) {
        // Nothing is served any more: the servants may be gone already.
        wait(lock, Role::closing, now() + options_.default_timeout,
             [&] { return engine_.queued_messages() == 0; });
    }
    closed_ = true;
    shutdown();
    wake_sleepers();
    ++sleeping_;
    changed_.wait(lock, [&] { return waiting_ == 0; });
    --sleeping_;
    if (Simulation* simulation = bus_.simulation()) simulation->impl().remove(*this);
    // References may keep this object alive, but nothing on the bus may; and callbacks, which may
    // hold references, must not keep it alive for ever. What they hold may call this ORB while it
    // goes, so that they go without the mutex.
    const std::unique_ptr<can::Controller> controller = std::move(controller_);
    const Timers timers = std::exchange(timers_, Timers{});
    const auto waiting_for_sent = std::exchange(sent_callbacks_, {});
    const auto sent = std::exchange(sent_, {});
    const auto unsent = std::exchange(unsent_, {});
    const auto event_callback = std::exchange(event_callback_, nullptr);
    lock.unlock();
}

// ---- waiting

template <typename Done>
bool OrbImpl::wait(Lock& lock, Role role, TimePoint deadline, Done done) {
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
        if (is_done || closed_ || time >= deadline) break;
        if (too_deep() && refuse_nested(time)) continue;
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
    const TimePoint time = now();
    timespec timeout{};
    if (until != never && until > time) {
        const auto nanoseconds = (until - time).count();
        timeout.tv_sec = static_cast<time_t>(nanoseconds / 1'000'000'000);
        timeout.tv_nsec = static_cast<long>(nanoseconds % 1'000'000'000);
    }
    pollfd sources[] = {{wake_signal_.fd(), POLLIN, 0}, {controller_->event_fd(), POLLIN, 0}};
    leading_ = true;
    lock.unlock();
    ::ppoll(sources, 2, until == never ? nullptr : &timeout, nullptr);
    lock.lock();
    leading_ = false;
    if (sources[0].revents != 0) wake_signal_.clear();
    if (sources[1].revents != 0) may_have_events_ = true;
    wake_sleepers();
}

void OrbImpl::wake() {
    if (leading_) wake_signal_.raise();
    wake_sleepers();
}

void OrbImpl::wake_sleepers() {
    if (sleeping_ > 0) changed_.notify_all();
}

bool OrbImpl::may_run(Role role) const {
    if (role == Role::closing) return false;
    if (depth_ > 0) return serving_thread_ == std::this_thread::get_id() && depth_ < max_nesting;
    return role == Role::loop || loops_ == 0;
}

bool OrbImpl::too_deep() const {
    return depth_ >= max_nesting && serving_thread_ == std::this_thread::get_id();
}

TimePoint OrbImpl::wakeup(Role role) const {
    const TimePoint engine = engine_.next_deadline();
    return may_run(role) ? std::min(engine, timers_.next()) : engine;
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
    while (auto request = engine_.next_request()) {
        engine_.count(request->group ? Counter::group_requests_dropped : Counter::requests_refused);
        engine_.refuse(request->answer_to, {SystemErrorKind::transient, Completion::no}, now);
        engine_.buffers().release(std::move(request->parameters));
        any = true;
    }
    return any;
}

// ---- calls

void OrbImpl::require_open() const {
    if (closed_) throw BAD_INV_ORDER("the Orb of this reference is gone");
}

void OrbImpl::require_node() const {
    if (!engine_.node()) throw BAD_INV_ORDER("this node has no number yet: set_node() first");
}

TimePoint OrbImpl::after(Duration duration) const {
    const TimePoint time = now();
    // Far, and yet a time that can be computed with.
    const Duration longest = (never - time) / 2;
    return time + std::min(duration, longest);
}

TimePoint OrbImpl::deadline(Duration timeout) const {
    return after(timeout > Duration::zero() ? timeout : options_.default_timeout);
}

void OrbImpl::after_queueing(std::optional<caniop::MessageHandle> message,
                             const SentCallback& sent) {
    if (sent) {
        if (message) {
            sent_callbacks_.emplace_back(*message, sent);
        } else {
            sent_.push_back(sent);
        }
    }
    transmit(now());
    wake();
}

std::optional<SentCallback> OrbImpl::take_sent_callback(caniop::MessageHandle message) {
    const auto found = std::find_if(sent_callbacks_.begin(), sent_callbacks_.end(),
                                    [&](const auto& entry) { return entry.first == message; });
    if (found == sent_callbacks_.end()) return std::nullopt;
    SentCallback callback = std::move(found->second);
    sent_callbacks_.erase(found);
    return callback;
}

core::CallResult OrbImpl::call(ObjectKey target, OperationId operation, MutableBytes message,
                               Duration timeout, const SentCallback& sent) {
    Lock lock{mutex_};
    require_open();
    require_node();
    const TimePoint until = deadline(timeout);
    const auto handle = engine_.call(target, operation, message, until);
    if (!handle) return handle.error();
    const bool refused = engine_.ended(*handle);
    after_queueing(engine_.message_of(*handle), refused ? SentCallback{} : sent);
    wait(lock, Role::caller, until, [&] { return engine_.ended(*handle); });
    if (auto result = engine_.take_result(*handle)) return std::move(*result);
    if (closed_) throw BAD_INV_ORDER("the Orb went during the call", Completion::maybe);
    return SystemError{SystemErrorKind::internal, Completion::maybe};
}

std::optional<SystemError> OrbImpl::send(ObjectKey target, OperationId operation,
                                         MutableBytes message, Duration timeout,
                                         const SentCallback& sent) {
    const Lock lock{mutex_};
    require_open();
    require_node();
    const auto queued = engine_.send(target, operation, message, deadline(timeout));
    if (!queued) return queued.error();
    after_queueing(*queued, sent);
    return std::nullopt;
}

std::optional<SystemError> OrbImpl::multicast(GroupId group, std::uint16_t interface_key,
                                              OperationId operation, MutableBytes message,
                                              Duration timeout, const SentCallback& sent) {
    const Lock lock{mutex_};
    require_open();
    require_node();
    const auto queued =
        engine_.multicast(group, interface_key, operation, message, deadline(timeout));
    if (!queued) return queued.error();
    after_queueing(*queued, sent);
    return std::nullopt;
}

void OrbImpl::give_back(core::Buffer body) {
    const Lock lock{mutex_};
    engine_.buffers().release(std::move(body));
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
    for (std::size_t i = 0; i < max_polled && !closed_; ++i) {
        if (!may_run(Role::loop) || !run_one(lock)) break;
        exchange(now(), true);
    }
    --waiting_;
    wake();
}

void OrbImpl::shutdown() noexcept {
    shut_down_ = true;
    wake_signal_.raise();
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
    if (too_deep()) return refuse_nested(time) || came;
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

// ---- what happened

void OrbImpl::on_event(std::function<void(const Event&)> callback) {
    auto shared = std::make_shared<const std::function<void(const Event&)>>(std::move(callback));
    Lock lock{mutex_};
    event_callback_.swap(shared);
    lock.unlock();  // what the old one holds may call this ORB when it goes
}

Counters OrbImpl::counters() const {
    const Lock lock{mutex_};
    return engine_.counters();
}

can::ErrorStatus OrbImpl::error_status() const {
    const Lock lock{mutex_};
    return controller_ ? controller_->error_status()
                       : can::ErrorStatus{can::ControllerState::stopped, 0, 0};
}

can::Capabilities OrbImpl::capabilities() const {
    const Lock lock{mutex_};
    return controller_ ? controller_->capabilities() : can::Capabilities{};
}

void OrbImpl::recover() {
    const Lock lock{mutex_};
    require_open();
    if (const auto obstacle = controller_->recover()) throw NO_PERMISSION(*obstacle);
}

}  // namespace canorb::runtime
