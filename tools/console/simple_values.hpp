#pragma once

#include <optional>
#include <string>

#include "orb/ccdr/encoder.hpp"
#include "tools/console/literal.hpp"
#include "tools/console/model.hpp"

namespace canorb::console {

/// Writes a value that has no others in it: a number, text, name or reference. Nothing when that
/// went well, else what is wrong: "70000 is not 0 to 65535".
std::optional<std::string> write_simple(ccdr::Encoder& out, const Type& type, const Literal& value);

}  // namespace canorb::console
