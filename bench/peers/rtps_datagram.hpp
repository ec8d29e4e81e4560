// The parts of an RTPS datagram.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "octets.hpp"

namespace peers {

/// Of a writer or reader in the whole network: its participant's 12 octets and 4 of its own.
using Guid = std::array<std::uint8_t, 16>;

struct Submessage {
    std::uint8_t kind;
    std::size_t octets;  // with its header
};

struct RtpsDatagram {
    std::vector<Submessage> submessages;
    std::optional<Guid> writer;        // of the first data submessage
    std::optional<Guid> acknowledged;  // the writer to whom the first ACKNACK is addressed
};

/// Nothing where it is not RTPS.
std::optional<RtpsDatagram> parse_rtps(const Octets& datagram);

/// The octets of the statistics that Fast DDS adds when it is built with them, used or not.
std::size_t statistics_octets(const RtpsDatagram& datagram);

nlohmann::ordered_json to_json(const std::vector<Submessage>& submessages);

}  // namespace peers
