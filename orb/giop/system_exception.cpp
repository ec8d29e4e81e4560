#include "orb/giop/system_exception.hpp"

namespace canorb::giop {

void encode(ccdr::Encoder& out, const SystemError& error) {
    out.string(repository_id(error.kind));
    out.variable_unsigned(error.minor);
    out.variable_unsigned(static_cast<std::uint32_t>(error.completion));
}

void decode(ccdr::Decoder& in, SystemError& error) {
    const std::string_view id = in.string();
    std::uint32_t minor{};
    decode(in, minor);
    const std::uint32_t completion =
        in.variable_unsigned(static_cast<std::uint32_t>(Completion::maybe));
    if (!in.ok()) {
        error = {};
        return;
    }
    error = {.kind = system_error_kind(id).value_or(SystemErrorKind::unknown),
             .completion = static_cast<Completion>(completion),
             .minor = minor};
}

}  // namespace canorb::giop
