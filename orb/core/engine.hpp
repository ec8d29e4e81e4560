#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "orb/base/counters.hpp"
#include "orb/base/fifo.hpp"
#include "orb/base/ids.hpp"
#include "orb/base/interface_info.hpp"
#include "orb/base/result.hpp"
#include "orb/base/system_error.hpp"
#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"
#include "orb/caniop/filters.hpp"
#include "orb/caniop/reassembler.hpp"
#include "orb/caniop/transmit_queue.hpp"
#include "orb/core/buffer_pool.hpp"
#include "orb/core/message_tracer.hpp"
#include "orb/core/outstanding_calls.hpp"
#include "orb/mca/multicast_agent.hpp"
#include "orb/poa/object_adapter.hpp"

namespace canorb::core {

struct EngineOptions {
    std::optional<NodeId> node;
    /// How long answers and refusals may wait in the transmit queue.
    Duration answer_lifetime = std::chrono::seconds{1};
    /// Two-way calls that wait for their end, or whose end was not yet fetched. Fewer than there
    /// are request ids.
    std::size_t max_outstanding_calls = 64;
    /// Requests that wait for a servant; a two-way one beyond is answered TRANSIENT.
    std::size_t max_incoming_requests = 64;
    /// Requests that one holding POA manager keeps; a two-way one beyond is answered TRANSIENT.
    std::size_t max_held_requests = 64;
    caniop::ReassemblerLimits receive{};
    caniop::TransmitLimits transmit{};
    /// Start of the request id counter; random, so that a restarted node repeats none.
    RequestId first_request_id = 0;
};

/// Where the answer to a Request goes.
struct RemoteCaller {
    NodeId node;
    RequestId request_id;
};
struct LocalCaller {
    CallHandle call;
};
/// To a group, or oneway within this node.
struct NoAnswer {};
using AnswerTo = std::variant<NoAnswer, RemoteCaller, LocalCaller>;

/// A Request whose servants are to be called.
struct IncomingRequest {
    AnswerTo answer_to{};
    std::optional<GroupId> group;     ///< nothing: one object
    ObjectIndex object = 0;           ///< where it is for one object, or for one member of a group
    bool one_member = false;          ///< to a group, of which only `object` has not had it yet
    std::uint16_t interface_key = 0;  ///< where it is for a group; 0: unchecked
    OperationId operation = 0;
    Buffer parameters{};
};

/// The last frame of a message is confirmed.
struct MessageSent {
    caniop::MessageHandle message;
};
/// Its message will never be sent: expired, stopped or failed.
struct MessageDropped {
    caniop::MessageHandle message;
};
struct DuplicateNodeSeen {
    TimePoint time;
};
struct ControllerChanged {
    can::StateChanged change;
};
struct LinkLostFrames {
    can::FramesLost loss;
};

/// What the application may want to know, in the order in which it happened.
using Notice = std::variant<std::monostate, MessageSent, MessageDropped, DuplicateNodeSeen,
                            ControllerChanged, LinkLostFrames>;

/// The ORB without a clock, a thread or a link: controller events and the time come in, frames,
/// requests for servants, results of calls and notices go out.
///
/// Not safe for several threads at once. After any call that is not const, the owner
///  * fetches take_filters(), next_abort() and next_frame() for the controller,
///  * and next_request() and next_notice() for the application.
///
/// Invariants:
///  * a two-way call ends exactly once, at its deadline at the latest (given on_time()), or is
///    cancelled and never ends;
///  * a request id is not used again while its Reply may still come before the call's deadline;
///  * a message that the link or a peer sends is executed at most once, and what is not executed
///    is counted;
///  * what is held belongs to objects that were active when it came; each POA manager holds at most
///    max_held_requests;
///  * while the link is down nothing is queued.
class Engine {
  public:
    explicit Engine(const EngineOptions& options);

    // ---- the node

    std::optional<NodeId> node() const { return options_.node; }
    void set_node(std::optional<NodeId> node);

    poa::ObjectAdapter& adapter() { return adapter_; }
    const poa::ObjectAdapter& adapter() const { return adapter_; }
    const mca::MulticastAgent& agent() const { return agent_; }
    [[nodiscard]] bool join(GroupId group, const mca::Member& member);
    void leave(GroupId group, ObjectIndex index);
    /// Takes an object out of the adapter and of all groups; false when it was not active.
    [[nodiscard]] bool deactivate(ObjectIndex index);
    /// Deactivates all objects of a POA and of those below it, then destroys these POAs.
    void destroy_poa(poa::PoaId poa);
    /// What is held goes on, or is refused, with the next next_request(). False when the manager
    /// is inactive.
    [[nodiscard]] bool set_manager_state(poa::ManagerId manager, PoaManagerState state);

    const Counters& counters() const { return counters_; }
    /// For what only the owner can see: servants' exceptions.
    void count(Counter counter) { counters_.add(counter); }

    // ---- calls out. `message` has the octets of a Request, with giop::request_header_size octets
    // reserved in front of the parameters; the engine writes the header and copies the message.
    // Targets have valid numbers. An error, completion NO, tells that nothing was queued:
    // BAD_INV_ORDER without a node number, COMM_FAILURE while the link is down, NO_RESOURCES for
    // a full transmit queue or too many outstanding calls, TRANSIENT for too many Requests waiting
    // for servants of this node, IMP_LIMIT for a message that is too long.

    /// A two-way call. Its end is fetched with take_result().
    Result<CallHandle, SystemError> call(ObjectKey target, OperationId operation,
                                         MutableBytes message, TimePoint deadline);
    /// A oneway call. Nothing in place of a handle: the object is this node's own.
    Result<std::optional<caniop::MessageHandle>, SystemError> send(ObjectKey target,
                                                                   OperationId operation,
                                                                   MutableBytes message,
                                                                   TimePoint deadline);
    /// A call to a group, local members included.
    Result<std::optional<caniop::MessageHandle>, SystemError> multicast(GroupId group,
                                                                        std::uint16_t interface_key,
                                                                        OperationId operation,
                                                                        MutableBytes message,
                                                                        TimePoint deadline);

    /// The message of a two-way call, while it is on its way to the bus.
    std::optional<caniop::MessageHandle> message_of(CallHandle call);
    /// Whether take_result() has something to give.
    bool ended(CallHandle call);
    /// When it ends at the latest; nothing for a call that is unknown, fetched or cancelled.
    std::optional<TimePoint> deadline_of(CallHandle call);
    /// next_ended() is to tell its end, if it is to come.
    void watch(CallHandle call);
    /// A watched call that has ended: each once, in the order of their ends.
    std::optional<CallHandle> next_ended() { return calls_.next_watched(); }
    /// Nobody wants its end any more: the call is forgotten. A Request not begun is withdrawn, and
    /// one to an object of this node that waits for its servant does not run; else it may have
    /// been executed, its Reply is dropped and counted, and until then or the deadline it occupies
    /// one of the max_outstanding_calls. No effect on a call that is unknown.
    void cancel(CallHandle call);
    /// The end of a call; nothing while it is outstanding. The call is forgotten.
    std::optional<CallResult> take_result(CallHandle call) { return calls_.take(call); }

    // ---- calls in

    /// The next Request that is to be served, or answered OBJECT_NOT_EXIST where the adapter finds
    /// no servant. One whose POA manager is not active is held or refused instead. A Request to a
    /// group comes once, and each member is asked for with admit(). The buffer of its parameters
    /// goes back with buffers().release().
    std::optional<IncomingRequest> next_request(TimePoint now);
    /// Whether next_request() may have something to give.
    bool has_request() const { return !incoming_.empty() || (held_may_go_ && !held_.empty()); }
    /// Whether a member may be called now with a Request to its group. If not, it is held for that
    /// member, or counted.
    [[nodiscard]] bool admit(const IncomingRequest& request, ObjectIndex member);
    /// Whether nobody waits: no two-way call for its answer, no Request for its servant, no
    /// message for the bus. What is held does not count.
    bool is_idle() const {
        return incoming_.empty() && queue_.size() == 0 && !calls_.any_waiting();
    }
    /// Answers a Request. `message` has giop::reply_header_size octets reserved in front of the
    /// body; one that is too long becomes IMP_LIMIT, YES. With NoAnswer it does nothing.
    void answer(const AnswerTo& to, giop::ReplyStatus status, MutableBytes message, TimePoint now);
    void refuse(const AnswerTo& to, const SystemError& error, TimePoint now);

    // ---- the link

    void on_event(const can::ControllerEvent& event, TimePoint now);
    /// Whether take_filters() has something to give.
    bool filters_changed() const { return filters_changed_; }
    /// The filters for the controller, when they changed since the last time.
    std::optional<caniop::FilterSet> take_filters(const can::Capabilities& capabilities);
    std::optional<can::Frame> next_frame(TimePoint now) { return queue_.next_frame(now); }
    void handed_over(can::TransmitHandle frame) { queue_.handed_over(frame); }
    std::optional<can::TransmitHandle> next_abort() { return queue_.next_abort(); }
    /// Messages that are not yet sent.
    std::size_t queued_messages() const { return queue_.size(); }

    // ---- time

    /// Ends what is due by time alone.
    void on_time(TimePoint now);
    /// When on_time() or next_frame() has something to do; never: not at all.
    TimePoint next_deadline() const;

    std::optional<Notice> next_notice() { return notices_.pop(); }
    BufferPool& buffers() { return buffers_; }

    /// Off until turned on. The owner sets its time before call(), send() and cancel(), which have
    /// none.
    MessageTracer& tracer() { return tracer_; }
    const MessageTracer& tracer() const { return tracer_; }

  private:
    using Sent = Result<std::optional<caniop::MessageHandle>, SystemError>;

    RequestId take_request_id();
    /// Why nothing can be sent now, if so.
    std::optional<SystemError> obstacle() const;
    bool is_own(ObjectKey target) const { return options_.node == target.node(); }
    [[nodiscard]] bool queue_local(IncomingRequest request, Bytes parameters);
    std::optional<IncomingRequest> next_held(TimePoint now);
    [[nodiscard]] bool is_wanted(const IncomingRequest& request);
    [[nodiscard]] bool has_room_to_hold(ObjectIndex object);
    void begin(const IncomingRequest& request);
    void turn_away(IncomingRequest request, poa::Admission why, TimePoint now);
    void give_up(IncomingRequest request);
    Result<caniop::MessageHandle, SystemError> enqueue(caniop::Identifier to, Bytes message,
                                                       TimePoint deadline);

    void on_frame(const can::Received& received, TimePoint now);
    void on_message(const caniop::Message& message, TimePoint now);
    void on_oversize(const caniop::Oversize& message, TimePoint now);
    void on_malformed(const caniop::Malformed& message, TimePoint received, TimePoint now);
    void on_group_request(caniop::Identifier from, const giop::Request& request);
    void on_request(caniop::Identifier from, const giop::Request& request, TimePoint now);
    void on_reply(NodeId peer, const giop::Reply& reply);
    void drop_reply(bool to_cancelled_call);
    void on_message_error(NodeId peer);
    void on_state(const can::StateChanged& change, TimePoint now);
    bool is_duplicate(caniop::Identifier from, RequestId id);
    void fail_calls(std::optional<NodeId> peer, const SystemError& error);
    void note_groups(std::size_t groups_before);

    // engine_tracing.cpp
    NodeId own_number() const { return options_.node.value_or(NodeId{0}); }
    const InterfaceInfo* interface_of(ObjectIndex object) const;
    void trace_local_request(ObjectKey target, OperationId operation, Bytes message, bool oneway);
    void trace_received(const caniop::Message& message);

    void collect_finished();
    void notify(Notice notice);

    EngineOptions options_;
    Counters counters_;
    BufferPool buffers_;
    poa::ObjectAdapter adapter_;
    mca::MulticastAgent agent_;
    caniop::Reassembler reassembler_;
    caniop::TransmitQueue queue_;
    OutstandingCalls calls_;
    Fifo<IncomingRequest> incoming_;
    std::vector<IncomingRequest> held_;  ///< in the order of their coming
    bool held_may_go_ = false;           ///< something changed since they were looked at
    Fifo<Notice> notices_;
    MessageTracer tracer_;
    RequestId next_request_id_;
    bool filters_changed_ = true;
    bool link_down_ = false;
    /// The request id seen last on each CAN identifier.
    std::vector<std::optional<RequestId>> last_request_ids_;
    std::array<std::optional<TimePoint>, NodeId::highest + std::size_t{1}> last_message_error_{};
    std::optional<TimePoint> last_duplicate_notice_;
};

}  // namespace canorb::core
