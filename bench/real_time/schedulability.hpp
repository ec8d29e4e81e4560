#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "orb/base/time.hpp"

/// Worst-case response times on CAN: R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien, "Controller
/// Area Network (CAN) schedulability analysis: Refuted, revisited and revised", Real-Time Systems
/// 35 (2007).
namespace canorb::bench {

/// The paper's longest frame with an 11-bit identifier, in bit times: SOF to the end of the
/// intermission, with as many stuff bits as 34 + 8 `octets` bits could take.
constexpr std::uint32_t longest_by_formula(std::uint32_t octets) {
    const std::uint32_t stuffed = 34 + 8 * octets;
    return stuffed + 13 + (stuffed - 1) / 4;
}

/// Rounded up: a bound must not be too short.
constexpr Duration bit_times(std::int64_t bits, std::uint32_t bitrate) {
    return Duration{(bits * 1'000'000'000 + bitrate - 1) / bitrate};
}

/// One stream of messages. In a set, the more urgent ones come first.
struct Stream {
    Duration transmission;  ///< C
    Duration period;        ///< T, the least time between two of them
    Duration deadline;      ///< D
    Duration jitter{0};     ///< J: so long after its event at most a message is queued
};

/// What the analysis says of one stream.
struct WorstCase {
    Duration response;           ///< R
    std::int64_t instances = 1;  ///< Q, of the busy period that were examined
    std::int64_t worst = 0;      ///< q, the instance that has R
};

/// The exact test: each instance in the longest busy period of the stream's priority level. Nothing
/// where that never ends, because the streams down to this one need all of the bus.
///
/// The deadline is not looked at: a response time beyond it is still the right one.
std::optional<WorstCase> worst_case(std::span<const Stream> streams, std::size_t index,
                                    Duration bit);

/// The sufficient test of the paper: one instance, and blocking by the longer of B and C. An upper
/// bound where it is at most the deadline and that at most the period; else nothing.
std::optional<Duration> sufficient_bound(std::span<const Stream> streams, std::size_t index,
                                         Duration bit);

/// The analysis of 1994 that the paper refutes, for the self-test: the first instance only.
std::optional<Duration> refuted_bound(std::span<const Stream> streams, std::size_t index,
                                      Duration bit);

/// The part of the bus that they need, 0 to 1 and above.
double utilization(std::span<const Stream> streams);

}  // namespace canorb::bench
