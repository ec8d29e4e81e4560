#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "longest_frame.hpp"

namespace canorb::bench {

struct RunOptions {
    std::uint32_t bitrate = 500'000;      ///< of all scenarios but the periodic sets
    std::uint64_t messages = 10'000'000;  ///< of the most urgent one
    std::uint64_t seed = 1;
    bool quick = false;
};

/// What one scenario found: `json` for the report, and whether every bound did that applies. Where
/// the analysis does not, "exceeded" in it may be above 0.
struct Outcome {
    nlohmann::ordered_json json;
    bool holds = true;
};

/// The most urgent message, a group call through an ORB, under 100 % load of other nodes.
Outcome group_under_load(const RunOptions& options, const LongestFrame& longest);

/// The same where the ORB sends less urgent calls as well, which occupy its controller.
Outcome shared_controller(const RunOptions& options, const LongestFrame& longest);

/// A periodic set on controllers that hold all of a node's messages, as the analysis assumes.
Outcome periodic_set(const RunOptions& options, const LongestFrame& longest);

/// The three streams of the paper's example, the third of which the analysis before it got wrong.
Outcome paper_example(const RunOptions& options, const LongestFrame& longest);

/// The set of periodic_set() as calls of ORBs, with so many frames in the controller.
Outcome periodic_set_of_calls(const RunOptions& options, std::size_t frames_in_controller);

}  // namespace canorb::bench
