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

    std::uint32_t minor() const noexcept { return error_.minor; }
    /// Whether the operation was executed, as far as is known.
    Completion completed() const noexcept { return error_.completion; }
    const SystemError& error() const noexcept { return error_; }

    std::string_view _repository_id() const noexcept override;
    /// "TIMEOUT (completed MAYBE): ..." and the detail.
    const char* what() const noexcept override { return text_.c_str(); }

  private:
    SystemError error_;
    std::string text_;
};

/// Each system exception is a class of its own, so that it can be caught by name. The default
/// completion is what a servant means that throws one before it did anything.
template <SystemErrorKind Kind>
class StandardException final : public SystemException {
  public:
    explicit StandardException(std::string_view detail = {}, Completion completion = Completion::no,
                               std::uint32_t minor = 0)
        : SystemException({Kind, completion, minor}, detail) {}
};

using UNKNOWN = StandardException<SystemErrorKind::unknown>;
using BAD_PARAM = StandardException<SystemErrorKind::bad_param>;
using BAD_OPERATION = StandardException<SystemErrorKind::bad_operation>;
using BAD_INV_ORDER = StandardException<SystemErrorKind::bad_inv_order>;
using COMM_FAILURE = StandardException<SystemErrorKind::comm_failure>;
using IMP_LIMIT = StandardException<SystemErrorKind::imp_limit>;
using INTERNAL = StandardException<SystemErrorKind::internal>;
using INV_OBJREF = StandardException<SystemErrorKind::inv_objref>;
using MARSHAL = StandardException<SystemErrorKind::marshal>;
using NO_IMPLEMENT = StandardException<SystemErrorKind::no_implement>;
using NO_PERMISSION = StandardException<SystemErrorKind::no_permission>;
using NO_RESOURCES = StandardException<SystemErrorKind::no_resources>;
using OBJ_ADAPTER = StandardException<SystemErrorKind::obj_adapter>;
using OBJECT_NOT_EXIST = StandardException<SystemErrorKind::object_not_exist>;
using TIMEOUT = StandardException<SystemErrorKind::timeout>;
using TRANSIENT = StandardException<SystemErrorKind::transient>;

/// Throws the class that `error` names.
[[noreturn]] void throw_system_exception(const SystemError& error, std::string_view detail = {});

}  // namespace canorb
