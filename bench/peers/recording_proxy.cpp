#include "recording_proxy.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace peers {

namespace {

constexpr std::size_t header_size = 12;  // of GIOP
constexpr int poll_milliseconds = 20;    // how soon the end is noticed

[[noreturn]] void throw_errno(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
}

int listen_on_loopback(std::uint16_t& port) {
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (listener < 0) throw_errno("socket");
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    auto* any = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener, any, length) != 0 || ::listen(listener, 4) != 0 ||
        ::getsockname(listener, any, &length) != 0) {
        throw_errno("listening on 127.0.0.1");
    }
    port = ntohs(address.sin_port);
    return listener;
}

int connect_to(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof(address.sun_path)) return -1;
    std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
    const int server = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::connect(server, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
        ::close(server);
        return -1;
    }
    return server;
}

bool send_all(int to, std::span<const std::uint8_t> octets) {
    while (!octets.empty()) {
        const ssize_t count = ::send(to, octets.data(), octets.size(), MSG_NOSIGNAL);
        if (count <= 0) return false;
        octets = octets.subspan(static_cast<std::size_t>(count));
    }
    return true;
}

std::vector<Octets> split(const Octets& stream) {
    std::vector<Octets> messages;
    for (std::size_t begin = 0; begin < stream.size();) {
        const std::span<const std::uint8_t> rest{stream.data() + begin, stream.size() - begin};
        if (rest.size() < header_size) throw std::runtime_error("a GIOP header is not complete");
        const std::string_view magic{reinterpret_cast<const char*>(rest.data()), 4};
        if (magic != "GIOP") throw std::runtime_error("what was recorded is not GIOP");
        const bool little_endian = (rest[6] & 1) != 0;
        const std::size_t size = header_size + read_unsigned(rest, 8, 4, little_endian);
        if (rest.size() < size) throw std::runtime_error("a GIOP message is not complete");
        messages.emplace_back(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(size));
        begin += size;
    }
    return messages;
}

}  // namespace

RecordingProxy::RecordingProxy(std::string server_path)
    : server_path_(std::move(server_path)), listener_(listen_on_loopback(port_)) {
    thread_ = std::thread{[this] { relay(); }};
}

RecordingProxy::~RecordingProxy() {
    ending_ = true;
    thread_.join();
    ::close(listener_);
}

/// One client after the other: an omniORB client whose calls do not overlap has one connection.
void RecordingProxy::relay() {
    while (!ending_) {
        pollfd descriptor{listener_, POLLIN, 0};
        if (::poll(&descriptor, 1, poll_milliseconds) <= 0) continue;
        const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
        const int server = connect_to(server_path_);
        if (client >= 0 && server >= 0) pass(client, server);
        ::close(client);
        ::close(server);
    }
}

void RecordingProxy::pass(int client, int server) {
    std::array<std::uint8_t, 65536> buffer{};
    std::array<pollfd, 2> descriptors{{{client, POLLIN, 0}, {server, POLLIN, 0}}};
    while (!ending_) {
        if (::poll(descriptors.data(), descriptors.size(), poll_milliseconds) <= 0) continue;
        for (const auto& from : descriptors) {
            if (from.revents == 0) continue;
            const bool is_client = from.fd == client;
            const ssize_t count = ::recv(from.fd, buffer.data(), buffer.size(), 0);
            if (count <= 0) return;
            const std::span<const std::uint8_t> octets{buffer.data(),
                                                       static_cast<std::size_t>(count)};
            {
                // Before it is passed on: who has an answer finds it recorded.
                const std::lock_guard lock{mutex_};
                Octets& record = is_client ? to_server_ : to_client_;
                record.insert(record.end(), octets.begin(), octets.end());
            }
            if (!send_all(is_client ? server : client, octets)) return;
        }
    }
}

RecordingProxy::Recording RecordingProxy::take() {
    const std::lock_guard lock{mutex_};
    Recording recording{split(to_server_), split(to_client_)};
    to_server_.clear();
    to_client_.clear();
    return recording;
}

std::string message_type(const Octets& message) {
    constexpr std::array names{"Request",     "Reply",           "CancelRequest", "LocateRequest",
                               "LocateReply", "CloseConnection", "MessageError",  "Fragment"};
    const std::size_t type = message.at(7);
    return type < names.size() ? names[type] : "unknown";
}

}  // namespace peers
