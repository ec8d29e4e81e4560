#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "orb/base/bytes.hpp"
#include "orb/base/result.hpp"
#include "orb/can/link/descriptor.hpp"
#include "orb/can/sim/protocol.hpp"

namespace canorb::can {

/// A non-blocking SOCK_SEQPACKET socket connected to the daemon at `path` (which fits a
/// sockaddr_un), or the errno.
Result<Descriptor, int> connect_to_bus(const std::string& path);

/// The same, bound and listening. The file is its user's only (mode 0600).
Result<Descriptor, int> listen_at(const std::string& path);

enum class SendOutcome : std::uint8_t { sent, would_block, gone };

/// Never blocks and raises no SIGPIPE.
SendOutcome send_packet(const Descriptor& socket, const sim::Packet& packet);

enum class ReceiveOutcome : std::uint8_t { packet, nothing, gone };

/// Never blocks. With `packet`, `size` octets are in `buffer`; a packet longer than the buffer
/// counts as one octet longer than it.
ReceiveOutcome receive_packet(const Descriptor& socket, MutableBytes buffer, std::size_t& size);

}  // namespace canorb::can
