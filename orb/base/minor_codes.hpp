#pragma once

/// Why canorb itself raises a system exception: each cause of doc/errors.md's table has a constant
/// here, with a minor code that no other cause of any exception has.
///
///     } catch (const canorb::TIMEOUT& e) {
///         if (e.error() == canorb::cause::expired_in_queue) ...
///
/// A minor code is sent with the exception, so that deployed nodes know these numbers: one is never
/// changed, and never used again. A new cause gets the next number and a line in doc/errors.md.
/// They stay below first_minor_of_applications, so that they take one octet in a Reply
/// (doc/decisions/014-minor-codes.md).

#include <cstdint>
#include <string_view>

#include "orb/base/system_error.hpp"

namespace canorb {

/// From here on minor codes are the applications' own.
inline constexpr std::uint32_t first_minor_of_applications = 128;

namespace cause {

// TIMEOUT
inline constexpr SystemError expired_in_queue{SystemErrorKind::timeout, Completion::no, 1};
inline constexpr SystemError deadline_passed{SystemErrorKind::timeout, Completion::maybe, 2};
inline constexpr SystemError expired_behind_local_calls{SystemErrorKind::timeout, Completion::no,
                                                        3};

// COMM_FAILURE
inline constexpr SystemError link_down{SystemErrorKind::comm_failure, Completion::no, 4};
inline constexpr SystemError link_failed_before_sending{SystemErrorKind::comm_failure,
                                                        Completion::no, 5};
inline constexpr SystemError link_failed_during_call{SystemErrorKind::comm_failure,
                                                     Completion::maybe, 6};
inline constexpr SystemError sending_stopped{SystemErrorKind::comm_failure, Completion::maybe, 7};
inline constexpr SystemError peer_sent_message_error{SystemErrorKind::comm_failure,
                                                     Completion::maybe, 8};
inline constexpr SystemError bus_refused{SystemErrorKind::comm_failure, Completion::no, 9};

// NO_RESOURCES
inline constexpr SystemError transmit_queue_full{SystemErrorKind::no_resources, Completion::no, 10};
inline constexpr SystemError too_many_calls{SystemErrorKind::no_resources, Completion::no, 11};
inline constexpr SystemError object_indices_used_up{SystemErrorKind::no_resources, Completion::no,
                                                    12};
inline constexpr SystemError no_file_descriptors{SystemErrorKind::no_resources, Completion::no, 50};
inline constexpr SystemError no_threads{SystemErrorKind::no_resources, Completion::no, 52};

// TRANSIENT
inline constexpr SystemError server_busy{SystemErrorKind::transient, Completion::no, 13};
inline constexpr SystemError nested_too_deep{SystemErrorKind::transient, Completion::no, 14};
inline constexpr SystemError own_objects_busy{SystemErrorKind::transient, Completion::no, 15};
inline constexpr SystemError manager_discards{SystemErrorKind::transient, Completion::no, 44};
inline constexpr SystemError hold_queue_full{SystemErrorKind::transient, Completion::no, 45};

// OBJ_ADAPTER
inline constexpr SystemError manager_inactive{SystemErrorKind::obj_adapter, Completion::no, 46};

// OBJECT_NOT_EXIST
inline constexpr SystemError no_such_object{SystemErrorKind::object_not_exist, Completion::no, 16};
inline constexpr SystemError object_of_another_node{SystemErrorKind::object_not_exist,
                                                    Completion::no, 17};
inline constexpr SystemError poa_destroyed{SystemErrorKind::object_not_exist, Completion::no, 47};

// BAD_OPERATION
inline constexpr SystemError no_such_operation{SystemErrorKind::bad_operation, Completion::no, 18};
inline constexpr SystemError not_for_groups{SystemErrorKind::bad_operation, Completion::no, 19};

// MARSHAL
inline constexpr SystemError bad_parameters{SystemErrorKind::marshal, Completion::no, 20};
inline constexpr SystemError bad_reply{SystemErrorKind::marshal, Completion::yes, 21};

// BAD_PARAM
inline constexpr SystemError bad_value{SystemErrorKind::bad_param, Completion::no, 22};
inline constexpr SystemError bad_result{SystemErrorKind::bad_param, Completion::yes, 23};
inline constexpr SystemError bad_option{SystemErrorKind::bad_param, Completion::no, 24};
inline constexpr SystemError bad_argument{SystemErrorKind::bad_param, Completion::no, 25};
inline constexpr SystemError bad_reference_text{SystemErrorKind::bad_param, Completion::no, 26};
inline constexpr SystemError not_active_here{SystemErrorKind::bad_param, Completion::no, 27};
inline constexpr SystemError no_common_interface{SystemErrorKind::bad_param, Completion::no, 28};
inline constexpr SystemError bad_union_member{SystemErrorKind::bad_param, Completion::no, 29};
inline constexpr SystemError never_a_member{SystemErrorKind::bad_param, Completion::no, 53};

// IMP_LIMIT
inline constexpr SystemError request_too_long{SystemErrorKind::imp_limit, Completion::no, 30};
inline constexpr SystemError request_above_limit{SystemErrorKind::imp_limit, Completion::no, 31};
inline constexpr SystemError reply_above_limit{SystemErrorKind::imp_limit, Completion::yes, 32};
inline constexpr SystemError reply_too_long{SystemErrorKind::imp_limit, Completion::yes, 33};

// INV_OBJREF
inline constexpr SystemError nil_reference{SystemErrorKind::inv_objref, Completion::no, 34};
inline constexpr SystemError bad_reference_octets{SystemErrorKind::inv_objref, Completion::no, 35};

// BAD_INV_ORDER
inline constexpr SystemError no_node_number{SystemErrorKind::bad_inv_order, Completion::no, 36};
inline constexpr SystemError reference_without_orb{SystemErrorKind::bad_inv_order, Completion::no,
                                                   37};
inline constexpr SystemError orb_is_gone{SystemErrorKind::bad_inv_order, Completion::no, 38};
inline constexpr SystemError orb_went_during_call{SystemErrorKind::bad_inv_order, Completion::maybe,
                                                  39};
inline constexpr SystemError would_wait_for_itself{SystemErrorKind::bad_inv_order, Completion::no,
                                                   48};
inline constexpr SystemError not_in_a_simulation{SystemErrorKind::bad_inv_order, Completion::no,
                                                 49};
inline constexpr SystemError future_without_call{SystemErrorKind::bad_inv_order, Completion::no,
                                                 54};
inline constexpr SystemError call_cancelled{SystemErrorKind::bad_inv_order, Completion::maybe, 55};

// UNKNOWN
inline constexpr SystemError undeclared_exception{SystemErrorKind::unknown, Completion::maybe, 40};
inline constexpr SystemError unexpected_user_exception{SystemErrorKind::unknown, Completion::maybe,
                                                       41};

// INTERNAL
inline constexpr SystemError call_lost{SystemErrorKind::internal, Completion::maybe, 42};

// NO_PERMISSION
inline constexpr SystemError recover_not_permitted{SystemErrorKind::no_permission, Completion::no,
                                                   43};
inline constexpr SystemError restart_not_allowed{SystemErrorKind::no_permission, Completion::no,
                                                 51};

}  // namespace cause

/// Why canorb, here or on another node, raised this: "the deadline passed in the transmit queue".
/// Empty for minor 0, for minor codes of applications, and for those of a later canorb.
std::string_view explanation(const SystemError& error);

}  // namespace canorb
