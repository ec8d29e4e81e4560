#include "orb/can/link/sim_socket.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>

namespace canorb::can {
namespace {

constexpr int backlog = 64;

sockaddr_un socket_address(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    assert(path.size() < sizeof address.sun_path);
    std::copy(path.begin(), path.end(), address.sun_path);
    return address;
}

Descriptor new_socket() {
    return Descriptor{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
}

const sockaddr* generic(const sockaddr_un& address) {
    return reinterpret_cast<const sockaddr*>(&address);
}

}  // namespace

Result<Descriptor, int> connect_to_bus(const std::string& path) {
    Descriptor socket = new_socket();
    if (!socket.is_open()) return Failure{errno};
    const sockaddr_un address = socket_address(path);
    if (::connect(socket.get(), generic(address), sizeof address) != 0) return Failure{errno};
    return socket;
}

Result<Descriptor, int> listen_at(const std::string& path) {
    Descriptor socket = new_socket();
    if (!socket.is_open()) return Failure{errno};
    const sockaddr_un address = socket_address(path);
    // Before bind(), so that the file is never anybody else's to write to.
    if (::fchmod(socket.get(), S_IRUSR | S_IWUSR) != 0) return Failure{errno};
    if (::bind(socket.get(), generic(address), sizeof address) != 0 ||
        ::listen(socket.get(), backlog) != 0) {
        return Failure{errno};
    }
    return socket;
}

SendOutcome send_packet(const Descriptor& socket, const sim::Packet& packet) {
    const Bytes octets = packet.bytes();
    while (true) {
        const auto sent =
            ::send(socket.get(), octets.data(), octets.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent >= 0) return SendOutcome::sent;
        if (errno == EINTR) continue;
        return errno == EAGAIN || errno == ENOBUFS || errno == ENOMEM ? SendOutcome::would_block
                                                                      : SendOutcome::gone;
    }
}

ReceiveOutcome receive_packet(const Descriptor& socket, MutableBytes buffer, std::size_t& size) {
    while (true) {
        const auto got =
            ::recv(socket.get(), buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_TRUNC);
        if (got > 0) {
            size = std::min(static_cast<std::size_t>(got), buffer.size() + 1);
            return ReceiveOutcome::packet;
        }
        if (got == 0) return ReceiveOutcome::gone;
        // A reset is told once, before the packets that are still there to read.
        if (errno == EINTR || errno == ECONNRESET) continue;
        return errno == EAGAIN ? ReceiveOutcome::nothing : ReceiveOutcome::gone;
    }
}

std::optional<FileIdentity> identity(const std::string& path) {
    struct stat status{};
    if (::lstat(path.c_str(), &status) != 0) return std::nullopt;
    return FileIdentity{status.st_dev, status.st_ino};
}

std::string process_of(const Descriptor& socket) {
    ucred credentials{};
    socklen_t size = sizeof credentials;
    if (::getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return "?";
    return std::to_string(credentials.pid);
}

std::optional<std::string> remove_stale_socket(const std::string& path) {
    struct stat status{};
    if (::lstat(path.c_str(), &status) != 0) return std::nullopt;  // nothing there
    if (!S_ISSOCK(status.st_mode)) return path + " exists and is not a socket";
    const auto connection = connect_to_bus(path);
    if (connection || connection.error() != ECONNREFUSED) {
        if (connection || connection.error() == EAGAIN || connection.error() == EPROTOTYPE) {
            return "a bus is already running at sim:" + path;
        }
        return "cannot tell whether a bus is running at sim:" + path + ": " +
               error_text(connection.error());
    }
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) {
        return "cannot remove the old socket " + path + ": " + error_text(errno);
    }
    return std::nullopt;
}

}  // namespace canorb::can
