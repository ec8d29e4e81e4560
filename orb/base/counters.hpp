#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace canorb {

/// Everything that an ORB counts. What a peer or the bus can cause and the ORB does not pass on
/// has its counter here: nothing is lost silently.
enum class Counter : std::uint8_t {
    // Traffic.
    frames_received,    ///< CANIOP frames that passed the acceptance filters, for this node
    frames_sent,        ///< frames that the controller confirmed
    messages_received,  ///< whole messages, of one frame or more
    messages_sent,      ///< messages whose last frame the controller confirmed

    // Frames ignored.
    frames_not_caniop,  ///< extended, remote or error frames, identifiers that CANIOP never sends
    frames_of_other_groups,    ///< passed the controller's mask, but this node is no member
                               ///< (doc/wire/caniop.md)
    frames_of_duplicate_node,  ///< carried this node's own number as the sender
    frames_for_other_nodes,    ///< addressed to another node; the controller has no exact filter

    // Reassembly.
    duplicate_frames,  ///< same sequence number, or same first frame, as the frame before
    sequence_errors,   ///< an unexpected sequence number closed a partial message
    continuations_without_message,  ///< a continuation frame with no message open
    interrupted_messages,           ///< a new first frame closed a partial message
    short_first_frames,             ///< a first frame with fewer octets than the header
    excess_octets,                  ///< octets beyond message_size; the message was dropped
    short_frames,                   ///< a frame that is not the last was not full; dropped
    reassembly_timeouts,            ///< a partial message got no frame for the inter-frame timeout
    reassemblies_evicted,           ///< the oldest partial message gave way to a new one
    partials_lost_with_frames,      ///< partial messages dropped: frames lost, or off the bus
    frames_lost_by_link,            ///< frames that the link reported as lost
    oversize_messages,              ///< messages above the receiver's limit, skipped

    // Messages refused.
    malformed_messages,          ///< not GIOP/CAN 1.0, or an impossible size
    message_errors_sent,         ///< MessageErrors sent in answer to those
    message_errors_received,     ///< MessageErrors from peers
    message_errors_suppressed,   ///< not sent: one per peer and inter-frame timeout is enough
    replies_on_group,            ///< a Reply or MessageError on a group identifier
    duplicate_requests,          ///< same request_id as the Request before on that identifier
    unmatched_replies,           ///< a Reply that no outstanding call waits for
    replies_to_cancelled_calls,  ///< the Reply to a call that was cancelled meanwhile

    // Calls.
    requests_dispatched,         ///< servant calls, local ones included
    group_interface_mismatches,  ///< a group member without the interface that the Request names
    group_requests_failed,       ///< group or oneway calls whose servant raised or did not decode
    requests_refused,            ///< Requests answered with an exception before any servant call
    calls_timed_out,             ///< two-way calls that reached their deadline
    messages_expired,            ///< queued messages withdrawn at their deadline
    messages_stopped,            ///< messages given up between two of their frames
    messages_failed,             ///< messages that failed with the controller
    group_requests_dropped,      ///< group calls with too many others waiting for servants
    answers_dropped,  ///< Replies and MessageErrors that the transmit queue had no room for
    notices_lost,     ///< events beyond what the application fetched
    traces_lost,      ///< traced messages beyond what the application fetched

    count_  ///< not a counter: their number
};

inline constexpr std::size_t counter_count = static_cast<std::size_t>(Counter::count_);

/// The counter's name as above, for people: "frames_received".
std::string_view name(Counter counter);

/// One value for each Counter. A plain value: copy it to compare before and after.
class Counters {
  public:
    std::uint64_t operator[](Counter counter) const {
        return values_[static_cast<std::size_t>(counter)];
    }
    void add(Counter counter, std::uint64_t n = 1) {
        values_[static_cast<std::size_t>(counter)] += n;
    }

  private:
    std::array<std::uint64_t, counter_count> values_{};
};

}  // namespace canorb
