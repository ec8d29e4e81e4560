// Round trips of a sample and the sample that answers it.
#pragma once

#include "fastdds_client.hpp"
#include "latency.hpp"

namespace peers {

/// With WAIT listener, the thread that reads a reply writes the next request: the least that Fast
/// DDS needs. With WAIT caller it wakes the thread that wrote, as a call that returns must.
LatencyResult measure_round_trips(Caller& caller, const std::string& wait,
                                  const RoundTrips& counts);

}  // namespace peers
