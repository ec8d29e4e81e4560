#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "orb/base/result.hpp"
#include "tools/console/model.hpp"

namespace canorb::console {

/// The parameters of a Request, in CCDR, from what people write for each in and inout parameter.
/// doc/console.md says what they may write. The error is a sentence for people that names the
/// argument, its type and what would be accepted:
///
///     argument 2 (speed: unsigned short): 70000 is not 0 to 65535
Result<std::vector<std::uint8_t>, std::string> encode_arguments(const Operation& operation,
                                                                std::span<const std::string> texts,
                                                                const Model& model);

}  // namespace canorb::console
