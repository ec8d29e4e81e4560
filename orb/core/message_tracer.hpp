#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/base/counters.hpp"
#include "orb/base/fifo.hpp"
#include "orb/base/interface_info.hpp"
#include "orb/caniop/identifier.hpp"
#include "orb/caniop/transmit_queue.hpp"
#include "orb/core/message_trace.hpp"

namespace canorb::core {

/// Records the messages of one Engine, when asked to. Off, it holds no memory, and costs the engine
/// one look at on() for each message; only set_time() may be called then.
class MessageTracer {
  public:
    /// Traces that wait to be fetched; more are counted as `traces_lost`.
    static constexpr std::size_t capacity = 1024;

    /// The counters outlive it.
    MessageTracer(Counters& counters, std::size_t max_queued_messages)
        : counters_(counters), max_queued_messages_(max_queued_messages) {}

    bool on() const { return traces_.has_value(); }
    /// Turned off, what was not fetched is forgotten. A message that was queued before it is turned
    /// on leaves no trace.
    void turn(bool on);

    /// The time of what is recorded next.
    void set_time(TimePoint now) { now_ = now; }

    // ---- out. They are kept until finished() or withdrawn(), which each message that was queued
    // comes to: so there are never more than the transmit queue holds.

    void queued(caniop::MessageHandle handle, caniop::Identifier to, Bytes message);
    /// The message queued last is a oneway Request.
    void is_oneway();
    void finished(const caniop::Finished& finished);
    /// Taken out of the transmit queue, which tells no outcome then: its call was cancelled.
    void withdrawn(caniop::MessageHandle handle);

    // ---- in. `interface` is null where no object of this node is meant.

    void received(caniop::Identifier from, Bytes message, const InterfaceInfo* interface);
    /// `first_frame` is all there is of the message; its fate is `refused`.
    void refused(caniop::Identifier from, Bytes first_frame);
    void malformed(caniop::Identifier from, Bytes first_frame);

    // ---- within the node. `octets` is the size of the message that it would be on the bus.

    void local_request(NodeId node, ObjectIndex object, OperationId operation, std::size_t octets,
                       bool oneway, const InterfaceInfo* interface);
    void local_reply(NodeId node, giop::ReplyStatus status, Bytes message);
    void local_failure(NodeId node, const SystemError& error);

    /// The oldest that was not fetched.
    std::optional<MessageTrace> next() { return traces_ ? traces_->pop() : std::nullopt; }
    bool has_next() const { return traces_ && !traces_->empty(); }

  private:
    struct Pending {
        caniop::MessageHandle handle;
        MessageTrace trace;
    };

    void record(MessageTrace trace);
    void end(caniop::MessageHandle handle, MessageTrace::Fate fate);

    Counters& counters_;
    std::size_t max_queued_messages_;
    TimePoint now_{};
    std::optional<Fifo<MessageTrace>> traces_;
    std::vector<Pending> pending_;  ///< in the transmit queue
};

}  // namespace canorb::core
