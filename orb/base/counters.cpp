#include "orb/base/counters.hpp"

namespace canorb {
namespace {

// In the order of Counter.
constexpr std::array<std::string_view, counter_count> names = {
    "frames_received",
    "frames_sent",
    "messages_received",
    "messages_sent",
    "frames_not_caniop",
    "frames_of_other_groups",
    "frames_of_duplicate_node",
    "frames_for_other_nodes",
    "duplicate_frames",
    "sequence_errors",
    "continuations_without_message",
    "interrupted_messages",
    "short_first_frames",
    "excess_octets",
    "short_frames",
    "reassembly_timeouts",
    "reassemblies_evicted",
    "partials_lost_with_frames",
    "frames_lost_by_link",
    "oversize_messages",
    "malformed_messages",
    "message_errors_sent",
    "message_errors_received",
    "message_errors_suppressed",
    "replies_on_group",
    "duplicate_requests",
    "unmatched_replies",
    "replies_to_cancelled_calls",
    "requests_dispatched",
    "group_interface_mismatches",
    "group_requests_failed",
    "requests_refused",
    "calls_timed_out",
    "messages_expired",
    "messages_stopped",
    "messages_failed",
    "group_requests_dropped",
    "answers_dropped",
    "notices_lost",
    "traces_lost",
};
static_assert(!names.back().empty());

}  // namespace

std::string_view name(Counter counter) {
    return names[static_cast<std::size_t>(counter)];
}

}  // namespace canorb
