// What the measurements of round trips have in common: where the two processes run, how many
// round trips there are, and the figures that come of them.
#pragma once

#include <chrono>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace peers {

using Clock = std::chrono::steady_clock;

struct RoundTrips {
    std::size_t warm_up;
    std::size_t timed;       // each by itself
    std::size_t throughput;  // all together, with no clock between them
};

RoundTrips round_trips(bool quick);

/// The CPUs of client and server, none where the kernel may choose.
struct Placement {
    std::optional<int> client;
    std::optional<int> server;
};

/// NAME is one (both on the same), two (each on its own) or any.
Placement placement(const std::string& name);

/// For this thread and those that it will start.
void pin(std::optional<int> cpu);

struct LatencyResult {
    std::vector<Clock::duration> times;
    Clock::duration throughput_time{};
};

/// min, median, p99, p99_9 and calls_per_second, and where it was measured.
nlohmann::ordered_json figures(LatencyResult result, const RoundTrips& counts,
                               const std::string& cpus, const Placement& place);

}  // namespace peers
