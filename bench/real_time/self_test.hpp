#pragma once

#include <nlohmann/json.hpp>

#include "longest_frame.hpp"

namespace canorb::bench {

/// Checks the analysis against its paper's example, against a schedule that is computed event by
/// event, and the longest frames against the bus's own encoder. "passed", and each check.
nlohmann::ordered_json self_test(const LongestFrame& longest);

}  // namespace canorb::bench
