#include "packet_capture.hpp"

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>

#include "program.hpp"

namespace peers {

namespace {

constexpr std::size_t udp_header_size = 8;

/// What a packet carries, if it is UDP. What was sent in fragments is not put together again: the
/// loopback interface has no need for them.
std::optional<Octets> udp_content(std::span<const std::uint8_t> packet) {
    if (packet.size() < 20 || packet[0] >> 4 != 4 || packet[9] != IPPROTO_UDP) return std::nullopt;
    const std::size_t header = 4 * static_cast<std::size_t>(packet[0] & 0xF);
    if (packet.size() < header + udp_header_size) return std::nullopt;
    const std::size_t size = read_unsigned(packet, header + 4, 2, false);
    if (size < udp_header_size || header + size > packet.size()) return std::nullopt;
    const auto content = packet.subspan(header + udp_header_size, size - udp_header_size);
    return Octets{content.begin(), content.end()};
}

/// Packets may be lost when nobody takes them: then nothing can be said.
void require_no_loss(int socket) {
    tpacket_stats statistics{};
    socklen_t length = sizeof(statistics);
    if (::getsockopt(socket, SOL_PACKET, PACKET_STATISTICS, &statistics, &length) != 0 ||
        statistics.tp_drops > 0) {
        throw std::runtime_error("packets were lost while capturing");
    }
}

}  // namespace

// A socket for one kind of packets sees each once, when it is received.
PacketCapture::PacketCapture()
    : socket_(::socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(ETH_P_IP))) {
    if (socket_ < 0) {
        throw Skipped("packets cannot be captured: " + std::string{std::strerror(errno)});
    }
    const int size = 8 << 20;  // for what passes until take(); the kernel may give less
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &size, sizeof(size));
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_IP);
    address.sll_ifindex = static_cast<int>(::if_nametoindex("lo"));
    if (::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
        const std::string reason = std::strerror(errno);
        ::close(socket_);
        throw Skipped("packets of the loopback interface cannot be captured: " + reason);
    }
}

PacketCapture::~PacketCapture() {
    ::close(socket_);
}

std::vector<Octets> PacketCapture::take() {
    std::vector<Octets> contents;
    std::vector<std::uint8_t> buffer(65536);
    while (true) {
        const ssize_t count = ::recv(socket_, buffer.data(), buffer.size(), 0);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno != EAGAIN) {
            throw std::system_error(errno, std::generic_category(), "capturing");
        }
        if (count < 0) break;
        if (auto content = udp_content({buffer.data(), static_cast<std::size_t>(count)})) {
            contents.push_back(std::move(*content));
        }
    }
    require_no_loss(socket_);
    return contents;
}

}  // namespace peers
