#pragma once

/// The exceptions that calls throw.
///
///     try {
///         motor.start();
///     } catch (const Devices::MotorStartException& e) {   // declared in the IDL
///     } catch (const canorb::TIMEOUT& e) {                // a system exception
///     } catch (const canorb::Exception& e) {              // any other: e.what() says which
///     }

#include <exception>
#include <string>
#include <string_view>

#include "orb/base/minor_codes.hpp"
#include "orb/base/system_error.hpp"

namespace canorb {

/// The base of everything that canorb throws.
class Exception : public std::exception {
  public:
    /// "IDL:omg.org/CORBA/TIMEOUT:1.0", or the id of the IDL's exception.
    virtual std::string_view _repository_id() const noexcept = 0;
};

/// The base of the exceptions that IDL declares. Generated classes derive from it.
class UserException : public Exception {
  public:
    const char* what() const noexcept override { return _repository_id().data(); }
};

/// The base of CORBA's system exceptions: every call can throw one.
class SystemException : public Exception {
  public:
    /// `detail` is for people, and is not sent.
    SystemException(const SystemError& error, std::string_view detail);

    /// Why: one of canorb's own (orb/base/minor_codes.hpp), a servant's own, or 0.
    std::uint32_t minor() const noexcept { return error_.minor; }
    /// Whether the operation was executed, as far as is known.
    Completion completed() const noexcept { return error_.completion; }
    /// All of it; to be compared with the constants of namespace cause.
    const SystemError& error() const noexcept { return error_; }

    std::string_view _repository_id() const noexcept override;
    /// "TIMEOUT (completed MAYBE, minor 2): ", what the minor says where it is canorb's, and the
    /// detail.
    const char* what() const noexcept override { return text_.c_str(); }

  private:
    SystemError error_;
    std::string text_;
};

/// Each system exception is a class of its own, so that it can be caught by name. The default
/// completion is what a servant means that throws one before it did anything. A servant's own
/// minors begin with first_minor_of_applications.
template <SystemErrorKind Kind>
class StandardException final : public SystemException {
  public:
    explicit StandardException(std::string_view detail = {}, Completion completion = Completion::no,
                               std::uint32_t minor = 0)
        : SystemException({Kind, completion, minor}, detail) {}
};

using UNKNOWN = StandardException<SystemErrorKind::unknown>;
using BAD_CONTEXT = StandardException<SystemErrorKind::bad_context>;
using BAD_INV_ORDER = StandardException<SystemErrorKind::bad_inv_order>;
using BAD_OPERATION = StandardException<SystemErrorKind::bad_operation>;
using BAD_PARAM = StandardException<SystemErrorKind::bad_param>;
using BAD_QOS = StandardException<SystemErrorKind::bad_qos>;
using BAD_TYPECODE = StandardException<SystemErrorKind::bad_typecode>;
using CODESET_INCOMPATIBLE = StandardException<SystemErrorKind::codeset_incompatible>;
using COMM_FAILURE = StandardException<SystemErrorKind::comm_failure>;
using DATA_CONVERSION = StandardException<SystemErrorKind::data_conversion>;
using FREE_MEM = StandardException<SystemErrorKind::free_mem>;
using IMP_LIMIT = StandardException<SystemErrorKind::imp_limit>;
using INITIALIZE = StandardException<SystemErrorKind::initialize>;
using INTERNAL = StandardException<SystemErrorKind::internal>;
using INTF_REPOS = StandardException<SystemErrorKind::intf_repos>;
using INV_FLAG = StandardException<SystemErrorKind::inv_flag>;
using INV_IDENT = StandardException<SystemErrorKind::inv_ident>;
using INV_OBJREF = StandardException<SystemErrorKind::inv_objref>;
using INV_POLICY = StandardException<SystemErrorKind::inv_policy>;
using INVALID_TRANSACTION = StandardException<SystemErrorKind::invalid_transaction>;
using MARSHAL = StandardException<SystemErrorKind::marshal>;
using NO_IMPLEMENT = StandardException<SystemErrorKind::no_implement>;
using NO_MEMORY = StandardException<SystemErrorKind::no_memory>;
using NO_PERMISSION = StandardException<SystemErrorKind::no_permission>;
using NO_RESOURCES = StandardException<SystemErrorKind::no_resources>;
using NO_RESPONSE = StandardException<SystemErrorKind::no_response>;
using OBJ_ADAPTER = StandardException<SystemErrorKind::obj_adapter>;
using OBJECT_NOT_EXIST = StandardException<SystemErrorKind::object_not_exist>;
using PERSIST_STORE = StandardException<SystemErrorKind::persist_store>;
using REBIND = StandardException<SystemErrorKind::rebind>;
using TIMEOUT = StandardException<SystemErrorKind::timeout>;
using TRANSACTION_MODE = StandardException<SystemErrorKind::transaction_mode>;
using TRANSACTION_REQUIRED = StandardException<SystemErrorKind::transaction_required>;
using TRANSACTION_ROLLEDBACK = StandardException<SystemErrorKind::transaction_rolledback>;
using TRANSACTION_UNAVAILABLE = StandardException<SystemErrorKind::transaction_unavailable>;
using TRANSIENT = StandardException<SystemErrorKind::transient>;

/// Throws the class that `error` names.
[[noreturn]] void throw_system_exception(const SystemError& error, std::string_view detail = {});

}  // namespace canorb
