#pragma once

#include <string>

#include "idlc/model.hpp"

namespace canorb::idlc::emit {

/// All that a program needs to make and read messages without generated code, in the format of
/// doc/idl-json.md. The same model gives the same octets.
std::string json(const model::Model& model);

}  // namespace canorb::idlc::emit
