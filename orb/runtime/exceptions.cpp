#include "canorb/exceptions.hpp"

namespace canorb {

SystemException::SystemException(const SystemError& error, std::string_view detail)
    : error_(error) {
    text_.append(name(error.kind)).append(" (completed ").append(name(error.completion));
    if (error.minor != 0) text_.append(", minor ").append(std::to_string(error.minor));
    text_.append(")");
    if (!detail.empty()) text_.append(": ").append(detail);
}

std::string_view SystemException::_repository_id() const noexcept {
    return repository_id(error_.kind);
}

namespace {

template <SystemErrorKind Kind>
[[noreturn]] void throw_as(const SystemError& error, std::string_view detail) {
    throw StandardException<Kind>(detail, error.completion, error.minor);
}

}  // namespace

void throw_system_exception(const SystemError& error, std::string_view detail) {
    switch (error.kind) {
        case SystemErrorKind::unknown:
            break;
        case SystemErrorKind::bad_param:
            throw_as<SystemErrorKind::bad_param>(error, detail);
        case SystemErrorKind::bad_operation:
            throw_as<SystemErrorKind::bad_operation>(error, detail);
        case SystemErrorKind::bad_inv_order:
            throw_as<SystemErrorKind::bad_inv_order>(error, detail);
        case SystemErrorKind::comm_failure:
            throw_as<SystemErrorKind::comm_failure>(error, detail);
        case SystemErrorKind::imp_limit:
            throw_as<SystemErrorKind::imp_limit>(error, detail);
        case SystemErrorKind::internal:
            throw_as<SystemErrorKind::internal>(error, detail);
        case SystemErrorKind::inv_objref:
            throw_as<SystemErrorKind::inv_objref>(error, detail);
        case SystemErrorKind::marshal:
            throw_as<SystemErrorKind::marshal>(error, detail);
        case SystemErrorKind::no_implement:
            throw_as<SystemErrorKind::no_implement>(error, detail);
        case SystemErrorKind::no_permission:
            throw_as<SystemErrorKind::no_permission>(error, detail);
        case SystemErrorKind::no_resources:
            throw_as<SystemErrorKind::no_resources>(error, detail);
        case SystemErrorKind::obj_adapter:
            throw_as<SystemErrorKind::obj_adapter>(error, detail);
        case SystemErrorKind::object_not_exist:
            throw_as<SystemErrorKind::object_not_exist>(error, detail);
        case SystemErrorKind::timeout:
            throw_as<SystemErrorKind::timeout>(error, detail);
        case SystemErrorKind::transient:
            throw_as<SystemErrorKind::transient>(error, detail);
    }
    throw_as<SystemErrorKind::unknown>(error, detail);
}

}  // namespace canorb
