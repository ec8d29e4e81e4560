// The octets of each operation's request and reply in RTPS, captured from live samples.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace peers {

/// The server of all operations, for fastdds_sizes() of another process, until a signal ends it.
void answer_all(const std::string& reliability, const std::string& domain, const std::string& name);

/// RELIABILITY is best_effort or reliable. Throws Skipped where capturing is not allowed.
nlohmann::ordered_json rtps_sizes(const std::string& reliability);

}  // namespace peers
