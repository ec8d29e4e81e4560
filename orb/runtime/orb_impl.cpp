#include "orb/runtime/orb_impl.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <system_error>

#include "orb/giop/message.hpp"
#include "orb/poa/servant.hpp"

namespace canorb::runtime {
namespace {

// As in <canorb/node.idl>.
constexpr std::size_t max_name = 16;
constexpr std::size_t max_label = 32;

std::string in_words(Duration duration) {
    return std::to_string(duration.count()) + " ns";
}

/// A text that goes into a string of at most `longest` characters.
void check_text(std::string_view what, const std::string& text, std::size_t longest) {
    if (text.size() > longest) {
        throw_system_exception(cause::bad_option, std::string{what} + " '" + text +
                                                      "' is longer than " +
                                                      std::to_string(longest) + " characters");
    }
    if (text.find('\0') != std::string::npos) {
        throw_system_exception(cause::bad_option, std::string{what} + " has a NUL in it");
    }
}

bool is_asked_for_by_the_environment() {
    const char* trace = std::getenv("CANORB_TRACE");
    return trace != nullptr && std::string_view{trace} == "1";
}

OrbOptions checked(OrbOptions options) {
    if (options.node && !NodeId::from(*options.node)) {
        throw_system_exception(cause::bad_option,
                               "node " + std::to_string(*options.node) + " is not 0 to 30");
    }
    check_text("the node's name", options.name, max_name);
    check_text("vendor", options.vendor, max_label);
    check_text("product", options.product, max_label);
    check_text("software_version", options.software_version, max_label);
    if (options.name.empty()) {
        options.name = options.node ? "node-" + std::to_string(*options.node) : "node";
    }
    if (options.default_timeout <= Duration::zero()) {
        throw_system_exception(
            cause::bad_option,
            "default_timeout " + in_words(options.default_timeout) + " is not greater than 0");
    }
    if (options.max_message < giop::request_header_size ||
        options.max_message > giop::max_message) {
        throw_system_exception(
            cause::bad_option,
            "max_message " + std::to_string(options.max_message) + " is not 8 to 65538 octets");
    }
    if (options.max_queued_messages == 0 || options.max_outstanding_calls == 0 ||
        options.frames_in_controller == 0) {
        throw_system_exception(
            cause::bad_option,
            "max_queued_messages, max_outstanding_calls and frames_in_controller must not be 0");
    }
    constexpr std::size_t most_workers = 256;
    if (options.worker_threads > most_workers) {
        throw_system_exception(
            cause::bad_option,
            "worker_threads " + std::to_string(options.worker_threads) + " is more than 256");
    }
    if (options.inter_frame_timeout <= Duration::zero()) {
        throw_system_exception(cause::bad_option, "inter_frame_timeout " +
                                                      in_words(options.inter_frame_timeout) +
                                                      " is not greater than 0");
    }
    if (options.continuation_gap < Duration::zero() ||
        options.continuation_gap >= options.inter_frame_timeout / 2) {
        throw_system_exception(cause::bad_option,
                               "continuation_gap " + in_words(options.continuation_gap) +
                                   " is not from 0 to less than half of inter_frame_timeout " +
                                   in_words(options.inter_frame_timeout));
    }
    options.trace = options.trace || is_asked_for_by_the_environment();
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
      wakes_leader_(controller_->wake_with(sleeper_)),
      engine_(engine_options(options_, bus_.simulation())),
      user_code_(std::max<std::size_t>(options_.worker_threads, 1)) {
    if (bus_.simulation() != nullptr && options_.worker_threads > 0) {
        throw_system_exception(cause::bad_option, "worker_threads: a simulation has one thread");
    }
    make_poa(poa::root_poa, make_manager(poa::root_manager));
    servant_calls_.reserve(options_.worker_threads + UserCode::max_nesting);
    const can::ErrorStatus status = controller_->error_status();
    if (status.state != can::ControllerState::error_active) {
        engine_.on_event(can::StateChanged{status, now()}, now());
    }
    if (Simulation* simulation = bus_.simulation()) simulation->impl().add(*this);
    Lock lock{mutex_};
    engine_.tracer().turn(options_.trace);
    transmit(now());  // installs the filters
}

void OrbImpl::start_workers() {
    try {
        for (std::size_t i = 0; i < options_.worker_threads; ++i) {
            workers_.emplace_back([this] { run_worker(); });
        }
    } catch (const std::system_error& error) {
        stop_workers();
        throw_system_exception(
            cause::no_threads,
            "worker_threads " + std::to_string(options_.worker_threads) + ": " + error.what());
    }
}

OrbImpl::~OrbImpl() {
    stop_workers();
}

void OrbImpl::close() {
    stop_workers();
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
    log_last_traces(lock);
    if (Simulation* simulation = bus_.simulation()) simulation->impl().remove(*this);
    // References may keep this object alive, but nothing on the bus may; and callbacks, which may
    // hold references, must not keep it alive for ever. What they hold may call this ORB while it
    // goes, so that they go without the mutex.
    const std::unique_ptr<can::Controller> controller = std::move(controller_);
    const Timers timers = std::exchange(timers_, Timers{});
    const auto waiting_for_sent = std::exchange(sent_callbacks_, {});
    const auto sent = std::exchange(sent_, {});
    const auto unsent = std::exchange(unsent_, {});
    const CallCallbacks call_callbacks = std::exchange(call_callbacks_, {});
    const auto event_callback = std::exchange(event_callback_, nullptr);
    const auto restart_callback = std::exchange(restart_callback_, nullptr);
    const auto message_callback = std::exchange(message_callback_, nullptr);
    lock.unlock();
}

// ---- calls

void OrbImpl::require_open() const {
    if (closed_) throw_system_exception(cause::orb_is_gone);
}

void OrbImpl::require_node() const {
    if (!engine_.node()) throw_system_exception(cause::no_node_number, "set_node() first");
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

std::optional<SystemError> OrbImpl::send(ObjectKey target, OperationId operation,
                                         MutableBytes message, Duration timeout,
                                         const SentCallback& sent) {
    const Lock lock{mutex_};
    require_open();
    require_node();
    if (engine_.tracer().on()) engine_.tracer().set_time(now());
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

// ---- what happened

void OrbImpl::on_event(std::function<void(const Event&)> callback) {
    auto shared = std::make_shared<const std::function<void(const Event&)>>(std::move(callback));
    Lock lock{mutex_};
    event_callback_.swap(shared);
    lock.unlock();  // what the old one holds may call this ORB when it goes
}

void OrbImpl::on_restart(Callback callback) {
    auto shared = callback ? std::make_shared<const Callback>(std::move(callback)) : nullptr;
    Lock lock{mutex_};
    restart_callback_.swap(shared);
    if (!restart_callback_) restart_due_ = never;
    lock.unlock();  // as in on_event()
}

bool OrbImpl::request_restart() {
    const Lock lock{mutex_};
    if (!restart_callback_) return false;
    if (restart_due_ == never) restart_due_ = after(options_.default_timeout);
    return true;
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
    if (const auto obstacle = controller_->recover())
        throw_system_exception(cause::recover_not_permitted, *obstacle);
}

}  // namespace canorb::runtime
