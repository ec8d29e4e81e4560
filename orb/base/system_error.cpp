#include "orb/base/system_error.hpp"

#include <array>
#include <cstddef>

namespace canorb {
namespace {

constexpr std::string_view id_prefix = "IDL:omg.org/CORBA/";
constexpr std::string_view id_suffix = ":1.0";

// In the order of SystemErrorKind.
constexpr std::array<std::string_view, system_error_kind_count> repository_ids = {
    "IDL:omg.org/CORBA/UNKNOWN:1.0",
    "IDL:omg.org/CORBA/BAD_CONTEXT:1.0",
    "IDL:omg.org/CORBA/BAD_INV_ORDER:1.0",
    "IDL:omg.org/CORBA/BAD_OPERATION:1.0",
    "IDL:omg.org/CORBA/BAD_PARAM:1.0",
    "IDL:omg.org/CORBA/BAD_QOS:1.0",
    "IDL:omg.org/CORBA/BAD_TYPECODE:1.0",
    "IDL:omg.org/CORBA/CODESET_INCOMPATIBLE:1.0",
    "IDL:omg.org/CORBA/COMM_FAILURE:1.0",
    "IDL:omg.org/CORBA/DATA_CONVERSION:1.0",
    "IDL:omg.org/CORBA/FREE_MEM:1.0",
    "IDL:omg.org/CORBA/IMP_LIMIT:1.0",
    "IDL:omg.org/CORBA/INITIALIZE:1.0",
    "IDL:omg.org/CORBA/INTERNAL:1.0",
    "IDL:omg.org/CORBA/INTF_REPOS:1.0",
    "IDL:omg.org/CORBA/INV_FLAG:1.0",
    "IDL:omg.org/CORBA/INV_IDENT:1.0",
    "IDL:omg.org/CORBA/INV_OBJREF:1.0",
    "IDL:omg.org/CORBA/INV_POLICY:1.0",
    "IDL:omg.org/CORBA/INVALID_TRANSACTION:1.0",
    "IDL:omg.org/CORBA/MARSHAL:1.0",
    "IDL:omg.org/CORBA/NO_IMPLEMENT:1.0",
    "IDL:omg.org/CORBA/NO_MEMORY:1.0",
    "IDL:omg.org/CORBA/NO_PERMISSION:1.0",
    "IDL:omg.org/CORBA/NO_RESOURCES:1.0",
    "IDL:omg.org/CORBA/NO_RESPONSE:1.0",
    "IDL:omg.org/CORBA/OBJ_ADAPTER:1.0",
    "IDL:omg.org/CORBA/OBJECT_NOT_EXIST:1.0",
    "IDL:omg.org/CORBA/PERSIST_STORE:1.0",
    "IDL:omg.org/CORBA/REBIND:1.0",
    "IDL:omg.org/CORBA/TIMEOUT:1.0",
    "IDL:omg.org/CORBA/TRANSACTION_MODE:1.0",
    "IDL:omg.org/CORBA/TRANSACTION_REQUIRED:1.0",
    "IDL:omg.org/CORBA/TRANSACTION_ROLLEDBACK:1.0",
    "IDL:omg.org/CORBA/TRANSACTION_UNAVAILABLE:1.0",
    "IDL:omg.org/CORBA/TRANSIENT:1.0",
};
static_assert(!repository_ids.back().empty());

}  // namespace

std::string_view repository_id(SystemErrorKind kind) {
    return repository_ids[static_cast<std::size_t>(kind)];
}

std::string_view name(SystemErrorKind kind) {
    const std::string_view id = repository_id(kind);
    return id.substr(id_prefix.size(), id.size() - id_prefix.size() - id_suffix.size());
}

std::string_view name(Completion completion) {
    switch (completion) {
        case Completion::yes:
            return "YES";
        case Completion::no:
            return "NO";
        case Completion::maybe:
            break;
    }
    return "MAYBE";
}

std::optional<SystemErrorKind> system_error_kind(std::string_view repository_id) {
    for (std::size_t i = 0; i < repository_ids.size(); ++i) {
        if (repository_ids[i] == repository_id) return static_cast<SystemErrorKind>(i);
    }
    return std::nullopt;
}

}  // namespace canorb
