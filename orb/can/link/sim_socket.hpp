#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <optional>
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

/// What identifies a file, to remove only the socket that is ours.
struct FileIdentity {
    dev_t device = 0;
    ino_t inode = 0;
    friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};
std::optional<FileIdentity> identity(const std::string& path);

/// Makes way for a new daemon's socket. The error is a sentence.
std::optional<std::string> remove_stale_socket(const std::string& path);

/// The number of the process at the other end, as text.
std::string process_of(const Descriptor& socket);

}  // namespace canorb::can
