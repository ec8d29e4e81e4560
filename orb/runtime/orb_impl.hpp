#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "canorb/orb.hpp"
#include "orb/can/link/descriptor.hpp"
#include "orb/core/engine.hpp"
#include "orb/core/reference.hpp"
#include "orb/giop/format.hpp"
#include "orb/runtime/call_callbacks.hpp"
#include "orb/runtime/condition.hpp"
#include "orb/runtime/simulation_impl.hpp"
#include "orb/runtime/sleeper.hpp"
#include "orb/runtime/timers.hpp"
#include "orb/runtime/user_code.hpp"
#include "orb/runtime/watch.hpp"

namespace canorb::runtime {

/// Finds the ORB that a decoded reference belongs to.
struct ReferenceOwner final : ccdr::DecodeContext {
    explicit ReferenceOwner(OrbImpl& owner) : orb(owner) {}
    std::shared_ptr<const ccdr::DecodeContext> shared() const override;
    OrbImpl& orb;
};

/// Buffers in which whole messages are built, each of giop::max_message octets with undefined
/// contents. Any thread.
class MessageBuffers {
  public:
    core::Buffer take() {
        const std::lock_guard lock{mutex_};
        if (free_.empty()) return core::Buffer(giop::max_message);
        core::Buffer buffer = std::move(free_.back());
        free_.pop_back();
        return buffer;
    }
    void give_back(core::Buffer buffer) {
        const std::lock_guard lock{mutex_};
        free_.push_back(std::move(buffer));
    }

  private:
    std::mutex mutex_;
    std::vector<core::Buffer> free_;
};

/// The Orb behind the facade: the engine, its link, its clock, and the threads that lend
/// themselves to it.
///
/// It needs no thread of its own; workers are threads that run the event loop. A thread that runs
/// the event loop, or that waits for a reply, does the ORB's work meanwhile. One of those waiting
/// leads: it alone sleeps on the link; the others sleep on changed_ and are woken when the leader
/// found something or leaves.
///
/// Invariants:
///  * the engine and all members without a note are touched with mutex_ held;
///  * user code (servants, timers, callbacks) runs with mutex_ released, in as many threads at once
///    as there are workers, or in one: in a thread that runs user code already (a nested call), or
///    when fewer do;
///  * while a thread runs the event loop, others that wait for replies leave user code to it.
class OrbImpl final : public std::enable_shared_from_this<OrbImpl>, public SimulatedOrb {
  public:
    OrbImpl(Bus& bus, OrbOptions options);
    ~OrbImpl() override;

    /// To be called once, when all that the workers are to serve from the start is there. Throws
    /// NO_RESOURCES.
    void start_workers();

    /// Sends what is queued, then lets go of the bus. Calls throw BAD_INV_ORDER from then on.
    void close();

    const OrbOptions& options() const { return options_; }
    std::optional<NodeId> node() const;
    void set_node(int node);

    Poa& root_poa() { return *poas_.front(); }

    /// Has `servant` serve object index 0, which belongs to no POA. To be called once, before
    /// anybody runs the event loop.
    void set_management_object(std::unique_ptr<Servant> servant);

    ObjectRef make_reference(core::Reference reference);
    ObjectRef string_to_object(std::string_view text);
    std::string object_to_string(const ObjectRef& reference) const;
    ObjectRef group_reference(GroupId group);

    void join(const ObjectRef& object, GroupId group);
    void leave(const ObjectRef& object, GroupId group);
    bool is_member(const ObjectRef& object, GroupId group) const;
    std::vector<ObjectRef> members(GroupId group);

    /// Runs the event loop until shutdown() (false) or the deadline (true).
    bool run_until(TimePoint deadline);
    void poll();
    int event_fd();
    bool drain(Duration limit);
    void shutdown() noexcept;

    TimePoint now() const { return bus_.now(); }
    /// `duration` from now, or as far as time can be computed with.
    TimePoint after(Duration duration) const;
    TimerId add_timer(TimePoint time, Duration period, Callback callback);
    void cancel_timer(TimerId timer);

    void on_event(std::function<void(const Event&)> callback);
    void on_restart(Callback callback);
    /// Has the restart callback called when whoever asks has the answer. False: there is none.
    [[nodiscard]] bool request_restart();

    /// Calls `look` with what the engine knows, while it cannot change. `look` calls nothing here.
    template <typename Look>
    void inspect(Look look) const {
        const Lock lock{mutex_};
        look(engine_);
    }
    void on_message(std::function<void(const MessageTrace&)> callback);
    Counters counters() const;
    can::ErrorStatus error_status() const;
    can::Capabilities capabilities() const;
    void recover();

    // ---- for stubs. `message` as Engine::call() wants it; `timeout` 0: the default.

    MessageBuffers& message_buffers() { return message_buffers_; }
    /// Returns the body of an answer, to be used again.
    void give_back(core::Buffer body);

    core::CallResult call(ObjectKey target, OperationId operation, MutableBytes message,
                          Duration timeout, const SentCallback& sent);
    std::optional<SystemError> send(ObjectKey target, OperationId operation, MutableBytes message,
                                    Duration timeout, const SentCallback& sent);
    std::optional<SystemError> multicast(GroupId group, std::uint16_t interface_key,
                                         OperationId operation, MutableBytes message,
                                         Duration timeout, const SentCallback& sent);
    const ccdr::DecodeContext* decode_context() const { return &owner_; }

    // ---- for futures: orb_calls.cpp

    /// Begins a two-way call; its end is fetched with finish_call().
    Result<core::CallHandle, SystemError> begin_call(ObjectKey target, OperationId operation,
                                                     MutableBytes message, Duration timeout,
                                                     const SentCallback& sent);
    /// Waits for the end of a call, as call() does. Throws BAD_INV_ORDER when the Orb goes, or the
    /// call is cancelled, before it has ended.
    core::CallResult finish_call(core::CallHandle call);
    /// Whether finish_call() would return, or throw, at once.
    bool has_ended(core::CallHandle call);
    /// Waits until then at most, and not beyond the call's deadline. Whether it has ended.
    bool wait_for_end(core::CallHandle call, Duration duration);
    void cancel_call(core::CallHandle call);
    /// Runs `callback` from the event loop when the call has ended; at once for a call that is
    /// unknown. Throws BAD_INV_ORDER.
    CallbackId when_ended(core::CallHandle call, Callback callback);
    void cancel_callback(CallbackId callback);

    // ---- for the Simulation
    bool work() override;
    bool run_due_timer() override;
    TimePoint next_wakeup() const override;

  private:
    friend class canorb::Poa;
    friend class canorb::PoaManager;

    using Lock = std::unique_lock<std::mutex>;

    /// A servant, and the object as which it is called now.
    struct ServantCall {
        const Servant* servant;
        ObjectIndex object;
        std::optional<poa::PoaId> poa;

        friend bool operator==(const ServantCall&, const ServantCall&) = default;
    };

    /// Why a thread waits.
    enum class Role : std::uint8_t { loop, caller, closing };

    bool wait(Lock& lock, Role role, TimePoint deadline, const Condition& done);
    Result<core::CallHandle, SystemError> begin_call(Lock& lock, ObjectKey target,
                                                     OperationId operation, MutableBytes message,
                                                     Duration timeout, const SentCallback& sent);
    core::CallResult finish_call(Lock& lock, core::CallHandle call);
    void lead(Lock& lock, TimePoint until);
    void run_worker();
    void stop_workers();
    /// For wait_for_completion: throws BAD_INV_ORDER where it would be for ever.
    void require_no_user_code(std::string_view what) const;
    /// Waits until no servant is called for which `concerns(ServantCall)` is true.
    template <typename Concerns>
    void wait_for_completion(Lock& lock, Concerns concerns) {
        ++sleeping_;
        changed_.wait(lock, [&] { return std::ranges::none_of(servant_calls_, concerns); });
        --sleeping_;
    }
    void wake_sleepers();
    void wake();

    bool may_run(Role role) const;
    TimePoint wakeup(Role role) const;
    /// True: the controller had something to tell.
    bool exchange(TimePoint now, bool serving);
    void collect_notices();
    void add_event(Event event);
    void transmit(TimePoint now);
    /// True: there was a Request to refuse.
    bool refuse_nested(TimePoint now);

    bool run_one(Lock& lock);
    bool run_sent(Lock& lock);
    bool run_restart(Lock& lock);
    bool run_timer(Lock& lock);
    /// Hands the oldest trace to the log and the callback.
    bool run_trace(Lock& lock);
    /// The rest goes to the log alone: nobody runs the event loop any more.
    void log_last_traces(Lock& lock);
    void log_trace(const MessageTrace& trace) const;
    bool run_call_callback(Lock& lock);
    /// What the code raised, in words; empty: nothing.
    std::string run_user_code(Lock& lock, std::function<void()> code);
    /// The same for all user code but servants.
    std::string run_callback(Lock& lock, std::function<void()> code);
    void report_failure(std::string_view what, const std::string& failure);
    void serve(Lock& lock, core::IncomingRequest request);
    void serve_object(Lock& lock, const core::IncomingRequest& request);
    void serve_group(Lock& lock, const core::IncomingRequest& request);
    void serve_member(Lock& lock, const core::IncomingRequest& request, ObjectIndex member,
                      MutableBytes buffer);
    void call_servant(Lock& lock, ObjectIndex object, Servant& servant, ServerCall& call);
    Event describe(const core::Notice& notice) const;
    void report(Lock& lock, Event event);
    void after_queueing(std::optional<caniop::MessageHandle> message, const SentCallback& sent);
    std::optional<SentCallback> take_sent_callback(caniop::MessageHandle message);

    void require_open() const;
    void require_node() const;
    TimePoint deadline(Duration timeout) const;
    ObjectIndex local_index(const ObjectRef& object) const;
    /// Throws when the POA, or the Orb, is gone.
    poa::ObjectAdapter& adapter_with(poa::PoaId poa);
    /// Throws ObjectNotActive.
    Servant& servant_of(poa::PoaId poa, ObjectIndex index);
    ObjectRef reference_to(ObjectIndex index, std::string_view repository_id);
    void change_manager(poa::ManagerId manager, PoaManagerState state, bool wait,
                        std::string_view what);
    PoaManager& make_manager(poa::ManagerId id);
    Poa& make_poa(poa::PoaId id, PoaManager& manager);

    Bus& bus_;
    const OrbOptions options_;
    ReferenceOwner owner_{*this};
    MessageBuffers message_buffers_;
    const std::shared_ptr<Sleeper> sleeper_ = std::make_shared<Sleeper>();  ///< the leader
    std::unique_ptr<Servant> management_object_;  ///< not changed once somebody may call it
    std::atomic<bool> shut_down_ = false;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::unique_ptr<can::Controller> controller_;  ///< null when closed
    const bool wakes_leader_;                      ///< by itself, without a descriptor
    core::Engine engine_;
    Timers timers_;
    std::vector<std::pair<caniop::MessageHandle, SentCallback>> sent_callbacks_;
    std::deque<SentCallback> sent_;     ///< to be called
    std::vector<SentCallback> unsent_;  ///< never to be called: to be destroyed without the mutex
    CallCallbacks call_callbacks_;
    std::deque<Event> events_;  ///< to be reported
    std::shared_ptr<const std::function<void(const Event&)>> event_callback_;
    std::shared_ptr<const std::function<void(const MessageTrace&)>> message_callback_;
    std::shared_ptr<const Callback> restart_callback_;
    TimePoint restart_due_ = never;  ///< at the latest; never: nobody asked
    bool served_last_ = false;       ///< a request, and no timer since
    bool closed_ = false;
    bool leading_ = false;
    /// The controller's event_fd() was readable, and poll() has not yet said that there is nothing;
    /// or there is more to send.
    bool may_have_events_ = true;
    int loops_ = 0;     ///< threads in the event loop
    int waiting_ = 0;   ///< threads in wait()
    int sleeping_ = 0;  ///< threads that wait for changed_
    UserCode user_code_;
    std::vector<ServantCall> servant_calls_;             ///< those that run now
    std::vector<std::unique_ptr<PoaManager>> managers_;  ///< by ManagerId
    std::vector<std::unique_ptr<Poa>> poas_;             ///< by PoaId, destroyed ones too
    std::optional<Watch> watch_;                         ///< once event_fd() was asked for
    bool stop_workers_ = false;
    std::vector<std::thread> workers_;  ///< touched by start_workers() and the destructor only
};

}  // namespace canorb::runtime
