#include "canorb/exceptions.hpp"

#include <cstddef>
#include <utility>

namespace canorb {

SystemException::SystemException(const SystemError& error, std::string_view detail)
    : error_(error) {
    text_.append(name(error.kind)).append(" (completed ").append(name(error.completion));
    if (error.minor != 0) text_.append(", minor ").append(std::to_string(error.minor));
    text_.append(")");
    if (const std::string_view why = explanation(error); !why.empty())
        text_.append(": ").append(why);
    if (!detail.empty()) text_.append(": ").append(detail);
}

std::string_view SystemException::_repository_id() const noexcept {
    return repository_id(error_.kind);
}

namespace {

template <std::size_t... Kinds>
void throw_one_of(std::index_sequence<Kinds...>, const SystemError& error,
                  std::string_view detail) {
    // The class of each kind, without a list that a new kind could be forgotten in.
    ((error.kind == SystemErrorKind{Kinds}
          ? throw StandardException<SystemErrorKind{Kinds}>(detail, error.completion, error.minor)
          : void()),
     ...);
}

}  // namespace

void throw_system_exception(const SystemError& error, std::string_view detail) {
    throw_one_of(std::make_index_sequence<system_error_kind_count>{}, error, detail);
    throw UNKNOWN(detail, error.completion, error.minor);
}

}  // namespace canorb
