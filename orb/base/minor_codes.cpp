#include "orb/base/minor_codes.hpp"

#include <array>
#include <cstddef>

namespace canorb {
namespace {

struct Described {
    SystemError error;
    std::string_view text;
};

// In the order of their minor codes, from 1.
constexpr auto causes = std::to_array<Described>({
    {cause::expired_in_queue, "the deadline passed in the transmit queue"},
    {cause::deadline_passed, "no answer before the deadline"},
    {cause::expired_behind_local_calls, "the deadline passed behind other calls of this node"},
    {cause::link_down, "the bus is off or the link is down"},
    {cause::link_failed_before_sending,
     "the bus went off or the link down before the call was begun"},
    {cause::link_failed_during_call, "the bus went off or the link down during the call"},
    {cause::sending_stopped, "the message was given up between two of its frames"},
    {cause::peer_sent_message_error, "the peer did not understand a message"},
    {cause::bus_refused, "no bus"},
    {cause::transmit_queue_full, "the transmit queue is full"},
    {cause::too_many_calls, "too many calls are outstanding"},
    {cause::object_indices_used_up, "no object index is left"},
    {cause::server_busy, "too many requests wait at the server"},
    {cause::nested_too_deep, "calls are nested too deep at the server"},
    {cause::own_objects_busy, "too many requests wait for objects of this node"},
    {cause::no_such_object, "no such object"},
    {cause::object_of_another_node, "the object key names another node"},
    {cause::no_such_operation, "no such operation"},
    {cause::not_for_groups, "not an operation for groups"},
    {cause::bad_parameters, "the server cannot decode the parameters"},
    {cause::bad_reply, "the answer cannot be decoded"},
    {cause::bad_value, "a value is not of its IDL type"},
    {cause::bad_result, "the servant's result is not of its IDL type"},
    {cause::bad_option, "an option is out of range"},
    {cause::bad_argument, "an argument is out of range"},
    {cause::bad_reference_text, "not a reference"},
    {cause::not_active_here, "not an active object of this node"},
    {cause::no_common_interface, "no interface in common with the group's members"},
    {cause::bad_union_member, "not the union's member"},
    {cause::request_too_long, "the request is longer than a message can be"},
    {cause::request_above_limit, "the request is above the server's max_message"},
    {cause::reply_above_limit, "the answer is above the client's max_message"},
    {cause::reply_too_long, "the answer is longer than a message can be"},
    {cause::nil_reference, "the reference is nil"},
    {cause::bad_reference_octets, "not the octets of a reference"},
    {cause::no_node_number, "this node has no number yet"},
    {cause::reference_without_orb, "the reference belongs to no Orb"},
    {cause::orb_is_gone, "the Orb is gone"},
    {cause::orb_went_during_call, "the Orb went during the call"},
    {cause::undeclared_exception, "the servant raised what the operation does not declare"},
    {cause::unexpected_user_exception, "a user exception that the caller does not know"},
    {cause::call_lost, "a fault in canorb"},
    {cause::recover_not_permitted, "this program may not restart the CAN interface"},
    {cause::manager_discards, "the object's POA manager discards requests"},
    {cause::hold_queue_full, "the object's POA manager holds too many requests"},
    {cause::manager_inactive, "the object's POA manager is inactive"},
    {cause::poa_destroyed, "the POA was destroyed"},
    {cause::would_wait_for_itself, "user code would wait for its own end"},
    {cause::not_in_a_simulation, "not in a simulation"},
    {cause::no_file_descriptors, "no file descriptors are left"},
    {cause::restart_not_allowed, "this node allows no restart from outside"},
    {cause::no_threads, "no more threads"},
    {cause::never_a_member, "no object for groups"},
    {cause::future_without_call, "this future is of no call"},
    {cause::call_cancelled, "the call was cancelled while it was waited for"},
});

constexpr bool are_numbered_from_1() {
    for (std::size_t i = 0; i < causes.size(); ++i) {
        if (causes[i].error.minor != i + 1) return false;
    }
    return true;
}
static_assert(are_numbered_from_1());
static_assert(causes.size() < first_minor_of_applications);

}  // namespace

std::string_view explanation(const SystemError& error) {
    if (error.minor == 0 || error.minor > causes.size()) return {};
    const Described& described = causes[error.minor - 1];
    // Another program's use of a number that is ours says nothing.
    return described.error.kind == error.kind ? described.text : std::string_view{};
}

}  // namespace canorb
