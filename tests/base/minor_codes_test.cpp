// The minor codes, as doc/errors.md lists them for people and for deployed nodes.
#include "orb/base/minor_codes.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <string_view>

namespace canorb {
namespace {

struct Row {
    unsigned minor;
    SystemError error;
    std::string_view says;
};

std::string in_words(const SystemError& error) {
    return std::string{name(error.kind)} + " " + std::string{name(error.completion)};
}

TEST(MinorCodes, AreWhatDeployedNodesSend) {
    // Lines are added at the end. One that is changed or taken away misleads who is older.
    const Row rows[] = {
        {1, cause::expired_in_queue, "TIMEOUT NO"},
        {2, cause::deadline_passed, "TIMEOUT MAYBE"},
        {3, cause::expired_behind_local_calls, "TIMEOUT NO"},
        {4, cause::link_down, "COMM_FAILURE NO"},
        {5, cause::link_failed_before_sending, "COMM_FAILURE NO"},
        {6, cause::link_failed_during_call, "COMM_FAILURE MAYBE"},
        {7, cause::sending_stopped, "COMM_FAILURE MAYBE"},
        {8, cause::peer_sent_message_error, "COMM_FAILURE MAYBE"},
        {9, cause::bus_refused, "COMM_FAILURE NO"},
        {10, cause::transmit_queue_full, "NO_RESOURCES NO"},
        {11, cause::too_many_calls, "NO_RESOURCES NO"},
        {12, cause::object_indices_used_up, "NO_RESOURCES NO"},
        {13, cause::server_busy, "TRANSIENT NO"},
        {14, cause::nested_too_deep, "TRANSIENT NO"},
        {15, cause::own_objects_busy, "TRANSIENT NO"},
        {16, cause::no_such_object, "OBJECT_NOT_EXIST NO"},
        {17, cause::object_of_another_node, "OBJECT_NOT_EXIST NO"},
        {18, cause::no_such_operation, "BAD_OPERATION NO"},
        {19, cause::not_for_groups, "BAD_OPERATION NO"},
        {20, cause::bad_parameters, "MARSHAL NO"},
        {21, cause::bad_reply, "MARSHAL YES"},
        {22, cause::bad_value, "BAD_PARAM NO"},
        {23, cause::bad_result, "BAD_PARAM YES"},
        {24, cause::bad_option, "BAD_PARAM NO"},
        {25, cause::bad_argument, "BAD_PARAM NO"},
        {26, cause::bad_reference_text, "BAD_PARAM NO"},
        {27, cause::not_active_here, "BAD_PARAM NO"},
        {28, cause::no_common_interface, "BAD_PARAM NO"},
        {29, cause::bad_union_member, "BAD_PARAM NO"},
        {30, cause::request_too_long, "IMP_LIMIT NO"},
        {31, cause::request_above_limit, "IMP_LIMIT NO"},
        {32, cause::reply_above_limit, "IMP_LIMIT YES"},
        {33, cause::reply_too_long, "IMP_LIMIT YES"},
        {34, cause::nil_reference, "INV_OBJREF NO"},
        {35, cause::bad_reference_octets, "INV_OBJREF NO"},
        {36, cause::no_node_number, "BAD_INV_ORDER NO"},
        {37, cause::reference_without_orb, "BAD_INV_ORDER NO"},
        {38, cause::orb_is_gone, "BAD_INV_ORDER NO"},
        {39, cause::orb_went_during_call, "BAD_INV_ORDER MAYBE"},
        {40, cause::undeclared_exception, "UNKNOWN MAYBE"},
        {41, cause::unexpected_user_exception, "UNKNOWN MAYBE"},
        {42, cause::call_lost, "INTERNAL MAYBE"},
        {43, cause::recover_not_permitted, "NO_PERMISSION NO"},
        {44, cause::manager_discards, "TRANSIENT NO"},
        {45, cause::hold_queue_full, "TRANSIENT NO"},
        {46, cause::manager_inactive, "OBJ_ADAPTER NO"},
        {47, cause::poa_destroyed, "OBJECT_NOT_EXIST NO"},
        {48, cause::would_wait_for_itself, "BAD_INV_ORDER NO"},
        {49, cause::not_in_a_simulation, "BAD_INV_ORDER NO"},
        {50, cause::no_file_descriptors, "NO_RESOURCES NO"},
        {51, cause::restart_not_allowed, "NO_PERMISSION NO"},
        {52, cause::no_threads, "NO_RESOURCES NO"},
        {53, cause::never_a_member, "BAD_PARAM NO"},
        {54, cause::future_without_call, "BAD_INV_ORDER NO"},
        {55, cause::call_cancelled, "BAD_INV_ORDER MAYBE"},
    };
    unsigned expected = 1;
    for (const Row& row : rows) {
        EXPECT_EQ(row.minor, expected++);
        EXPECT_EQ(row.error.minor, row.minor);
        EXPECT_EQ(in_words(row.error), row.says) << row.minor;
        EXPECT_FALSE(explanation(row.error).empty()) << row.minor;
    }
    // All of them: the next number says nothing with any exception.
    for (std::size_t kind = 0; kind < system_error_kind_count; ++kind) {
        const SystemError next{static_cast<SystemErrorKind>(kind), Completion::no, expected};
        EXPECT_EQ(explanation(next), "") << name(next.kind);
    }
}

TEST(MinorCodes, AreExplainedWhereTheyAreCanorbsOwn) {
    EXPECT_EQ(explanation(cause::expired_in_queue), "the deadline passed in the transmit queue");
    EXPECT_EQ(explanation(cause::recover_not_permitted),
              "this program may not restart the CAN interface");
    // The completion is the sender's word, and changes nothing.
    EXPECT_EQ(explanation({SystemErrorKind::timeout, Completion::maybe, 1}),
              "the deadline passed in the transmit queue");
    EXPECT_EQ(explanation({SystemErrorKind::timeout, Completion::no, 0}), "");
    // A number of canorb's with an exception that canorb does not raise for it.
    EXPECT_EQ(explanation({SystemErrorKind::marshal, Completion::no, 1}), "");
    EXPECT_EQ(explanation({SystemErrorKind::timeout, Completion::no, first_minor_of_applications}),
              "");
    EXPECT_EQ(explanation({SystemErrorKind::timeout, Completion::no, 0xFFFFFFFF}), "");
}

}  // namespace
}  // namespace canorb
