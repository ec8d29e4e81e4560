#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "orb/base/time.hpp"
#include "orb/can/sim/bus_types.hpp"

namespace canorb::bench {

/// Measured response times of one stream, all of them kept.
class Responses {
  public:
    void reserve(std::size_t messages) { times_.reserve(messages); }
    void add(Duration response) { times_.push_back(response.count()); }
    std::size_t messages() const { return times_.size(); }
    std::uint64_t above(Duration bound) const;
    Duration longest() const;

    /// messages, min_ns, median_ns, p99_ns, p999_ns, max_ns; bound_ns and exceeded where there is a
    /// bound. Sorts.
    nlohmann::ordered_json summary(std::optional<Duration> bound);
    /// Bucket i counts what is at least i and less than i + 1 times the width. Up to the longest.
    nlohmann::ordered_json histogram(Duration bucket) const;

  private:
    std::vector<std::int64_t> times_;
};

/// busy bits of all, in percent.
double load_percent(const can::sim::BusStatistics& statistics);

/// Throws std::runtime_error if there were errors on the bus.
void check_undisturbed(const can::sim::BusStatistics& statistics);

/// Tells on standard error how far a scenario is, every few seconds.
class Progress {
  public:
    Progress(std::string name, std::uint64_t goal);
    void reached(std::uint64_t done);
    double seconds() const;

  private:
    using Clock = std::chrono::steady_clock;
    std::string name_;
    std::uint64_t goal_;
    Clock::time_point begin_ = Clock::now();
    Clock::time_point told_ = begin_;
};

}  // namespace canorb::bench
