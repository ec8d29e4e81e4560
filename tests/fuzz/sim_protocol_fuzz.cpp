// Any octets as a packet of the bus daemon's protocol, in both directions: there is one way to
// write each packet, so what is accepted is what encode() makes of it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <variant>

#include "orb/can/sim/protocol.hpp"

namespace {

using namespace canorb;
using namespace canorb::can;

void require_same(const sim::Packet& packet, Bytes octets) {
    const Bytes written = packet.bytes();
    if (!std::equal(written.begin(), written.end(), octets.begin(), octets.end())) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Bytes octets{data, size};
    if (const auto packet = sim::parse_client_packet(octets)) {
        const auto* hello = std::get_if<sim::Hello>(&*packet);
        // Of other versions nothing else is known, so it cannot be written again.
        if (hello == nullptr || hello->version == sim::protocol_version) {
            require_same(sim::encode(*packet), octets);
        }
    }
    if (const auto packet = sim::parse_server_packet(octets)) {
        const auto* refusal = std::get_if<sim::Refusal>(&*packet);
        if (refusal == nullptr || refusal->version == sim::protocol_version) {
            require_same(sim::encode(*packet), octets);
        }
    }
    return 0;
}
