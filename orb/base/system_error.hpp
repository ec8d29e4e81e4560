#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace canorb {

/// CORBA's standard system exceptions, as far as canorb raises or understands them.
enum class SystemErrorKind : std::uint8_t {
    unknown,           ///< an exception that the operation does not declare
    bad_param,         ///< a value outside what the IDL or the call allows
    bad_operation,     ///< no such operation, or not one that can be called this way
    bad_inv_order,     ///< a call that is not allowed in this state
    comm_failure,      ///< the bus or the peer failed during the call
    imp_limit,         ///< a message larger than a limit
    internal,          ///< a fault in canorb itself
    inv_objref,        ///< a malformed object reference
    marshal,           ///< octets that are not the encoding of the declared types
    no_implement,      ///< declared, but not implemented
    no_permission,     ///< refused
    no_resources,      ///< a table or queue is full
    obj_adapter,       ///< the POA manager is inactive
    object_not_exist,  ///< no object with this key
    timeout,           ///< the deadline passed
    transient,         ///< not now; trying again may work
};

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
    std::uint32_t minor = 0;

    friend bool operator==(const SystemError&, const SystemError&) = default;
};

/// "IDL:omg.org/CORBA/TIMEOUT:1.0" and so on.
std::string_view repository_id(SystemErrorKind kind);

/// "TIMEOUT" and so on.
std::string_view name(SystemErrorKind kind);

/// "YES", "NO" or "MAYBE".
std::string_view name(Completion completion);

/// Nothing when the id is none of CORBA's that canorb knows.
std::optional<SystemErrorKind> system_error_kind(std::string_view repository_id);

}  // namespace canorb
