// The octets of each operation's request and reply in GIOP, recorded from live calls.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace peers {

/// VERSION of GIOP is 1.0, 1.1 or 1.2. Client of a server that is a process of its own.
nlohmann::ordered_json giop_sizes(const std::string& version);

}  // namespace peers
