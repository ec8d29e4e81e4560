#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace canorb {

/// The standard system exceptions of CORBA 2.6. canorb itself raises those of doc/errors.md; a
/// servant may raise any.
enum class SystemErrorKind : std::uint8_t {
    unknown,                  ///< an exception that the operation does not declare
    bad_context,              ///< no such context value; canorb has no contexts
    bad_inv_order,            ///< a call that is not allowed in this state
    bad_operation,            ///< no such operation, or not one that can be called this way
    bad_param,                ///< a value outside what the IDL or the call allows
    bad_qos,                  ///< a quality of service that cannot be had
    bad_typecode,             ///< a malformed TypeCode
    codeset_incompatible,     ///< no character set in common
    comm_failure,             ///< the bus or the peer failed during the call
    data_conversion,          ///< a value that cannot be represented on the other side
    free_mem,                 ///< memory could not be freed
    imp_limit,                ///< a message larger than a limit
    initialize,               ///< the ORB could not be initialized
    internal,                 ///< a fault in canorb itself
    intf_repos,               ///< the interface repository failed
    inv_flag,                 ///< an invalid flag
    inv_ident,                ///< a malformed identifier
    inv_objref,               ///< a malformed object reference
    inv_policy,               ///< policies that do not agree
    invalid_transaction,      ///< a malformed transaction context
    marshal,                  ///< octets that are not the encoding of the declared types
    no_implement,             ///< declared, but not implemented
    no_memory,                ///< no memory is left
    no_permission,            ///< refused
    no_resources,             ///< a table or queue is full
    no_response,              ///< the answer is not there yet
    obj_adapter,              ///< the POA manager is inactive
    object_not_exist,         ///< no object with this key
    persist_store,            ///< persistent storage failed
    rebind,                   ///< the reference must be bound again
    timeout,                  ///< the deadline passed
    transaction_mode,         ///< the object does not agree with the transaction
    transaction_required,     ///< a call that needs a transaction
    transaction_rolledback,   ///< the transaction was rolled back
    transaction_unavailable,  ///< no transaction service
    transient,                ///< not now; trying again may work
};

inline constexpr std::size_t system_error_kind_count =
    static_cast<std::size_t>(SystemErrorKind::transient) + 1;

/// How far the operation got when it failed. The values are those of the wire.
enum class Completion : std::uint8_t {
    yes = 0,    ///< it was executed
    no = 1,     ///< it was not executed
    maybe = 2,  ///< nobody knows
};

/// A system exception as a value. The layers below the stubs pass it; the stubs throw it.
struct SystemError {
    SystemErrorKind kind = SystemErrorKind::unknown;
    Completion completion = Completion::maybe;
    /// Why: one of orb/base/minor_codes.hpp, an application's own, or 0.
    std::uint32_t minor = 0;

    friend bool operator==(const SystemError&, const SystemError&) = default;
};

/// "IDL:omg.org/CORBA/TIMEOUT:1.0" and so on.
std::string_view repository_id(SystemErrorKind kind);

/// "TIMEOUT" and so on.
std::string_view name(SystemErrorKind kind);

/// "YES", "NO" or "MAYBE".
std::string_view name(Completion completion);

/// Nothing when the id is none of CORBA 2.6's.
std::optional<SystemErrorKind> system_error_kind(std::string_view repository_id);

}  // namespace canorb
