#include "orb/base/counters.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string_view>

namespace canorb {
namespace {

struct Named {
    Counter counter;
    std::string_view name;
};

constexpr Named all[] = {
    {Counter::frames_received, "frames_received"},
    {Counter::frames_sent, "frames_sent"},
    {Counter::messages_received, "messages_received"},
    {Counter::messages_sent, "messages_sent"},
    {Counter::frames_not_caniop, "frames_not_caniop"},
    {Counter::frames_of_other_groups, "frames_of_other_groups"},
    {Counter::frames_of_duplicate_node, "frames_of_duplicate_node"},
    {Counter::frames_for_other_nodes, "frames_for_other_nodes"},
    {Counter::duplicate_frames, "duplicate_frames"},
    {Counter::sequence_errors, "sequence_errors"},
    {Counter::continuations_without_message, "continuations_without_message"},
    {Counter::interrupted_messages, "interrupted_messages"},
    {Counter::short_first_frames, "short_first_frames"},
    {Counter::excess_octets, "excess_octets"},
    {Counter::short_frames, "short_frames"},
    {Counter::reassembly_timeouts, "reassembly_timeouts"},
    {Counter::reassemblies_evicted, "reassemblies_evicted"},
    {Counter::partials_lost_with_frames, "partials_lost_with_frames"},
    {Counter::frames_lost_by_link, "frames_lost_by_link"},
    {Counter::oversize_messages, "oversize_messages"},
    {Counter::malformed_messages, "malformed_messages"},
    {Counter::message_errors_sent, "message_errors_sent"},
    {Counter::message_errors_received, "message_errors_received"},
    {Counter::message_errors_suppressed, "message_errors_suppressed"},
    {Counter::replies_on_group, "replies_on_group"},
    {Counter::duplicate_requests, "duplicate_requests"},
    {Counter::unmatched_replies, "unmatched_replies"},
    {Counter::replies_to_cancelled_calls, "replies_to_cancelled_calls"},
    {Counter::requests_dispatched, "requests_dispatched"},
    {Counter::group_interface_mismatches, "group_interface_mismatches"},
    {Counter::group_requests_failed, "group_requests_failed"},
    {Counter::requests_refused, "requests_refused"},
    {Counter::calls_timed_out, "calls_timed_out"},
    {Counter::messages_expired, "messages_expired"},
    {Counter::messages_stopped, "messages_stopped"},
    {Counter::messages_failed, "messages_failed"},
    {Counter::group_requests_dropped, "group_requests_dropped"},
    {Counter::answers_dropped, "answers_dropped"},
    {Counter::notices_lost, "notices_lost"},
    {Counter::traces_lost, "traces_lost"},
};

TEST(CounterNames, AreTheEnumerators) {
    ASSERT_EQ(std::size(all), counter_count) << "a new counter belongs into this table";
    for (std::size_t i = 0; i < counter_count; ++i) {
        EXPECT_EQ(static_cast<std::size_t>(all[i].counter), i) << all[i].name;
        EXPECT_EQ(name(all[i].counter), all[i].name);
    }
}

TEST(CounterNames, AreDistinct) {
    std::set<std::string_view> names;
    for (std::size_t i = 0; i < counter_count; ++i) {
        const std::string_view one = name(static_cast<Counter>(i));
        EXPECT_FALSE(one.empty()) << i;
        EXPECT_TRUE(names.insert(one).second) << one;
    }
}

TEST(Counters, CountEachForItself) {
    Counters counters;
    counters.add(Counter::frames_received);
    counters.add(Counter::frames_lost_by_link, 41);
    counters.add(Counter::frames_lost_by_link);
    const Counters before = counters;
    counters.add(Counter::frames_received);
    EXPECT_EQ(before[Counter::frames_received], 1U);
    EXPECT_EQ(counters[Counter::frames_received], 2U);
    EXPECT_EQ(counters[Counter::frames_lost_by_link], 42U);
    EXPECT_EQ(counters[Counter::frames_sent], 0U);
}

}  // namespace
}  // namespace canorb
