#pragma once

#include <deque>
#include <span>
#include <string>
#include <vector>

#include "orb/base/result.hpp"
#include "orb/can/sim/bus.hpp"
#include "orb/can/sim/protocol.hpp"

namespace canorb::can {

/// A simulated bus and its nodes at one moment.
struct BusReport {
    std::uint32_t bitrate = 0;  ///< bit/s
    sim::BusStatus bus;
    std::vector<sim::NodeStatus> nodes;
};

/// Makes the reports of a bus: knows when it began, and how busy it was a second ago.
///
/// Not safe for use by two threads at once.
class BusReporter {
  public:
    /// The bus begins now. It must outlive this object.
    explicit BusReporter(const sim::Bus& bus);

    /// To be called after each step of the bus. What a second's beginning divides, between two
    /// calls or within a millisecond, is taken to be evenly busy.
    void sample();

    BusReport report(std::span<const sim::NodeIndex> nodes) const;

  private:
    struct Sample {
        TimePoint time;
        std::uint64_t bits = 0;
        std::uint64_t busy_bits = 0;
    };

    Sample present() const;
    Sample sample_at(TimePoint time) const;

    const sim::Bus& bus_;
    TimePoint start_;
    /// In order of time; the first one is the latest that is a second old, or the start.
    std::deque<Sample> samples_;
};

}  // namespace canorb::can
