#include "orb/can/link/can_interface.hpp"

#include <linux/can/netlink.h>
#include <linux/if_arp.h>
#include <linux/rtnetlink.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>

namespace canorb::can {
namespace {

constexpr std::size_t alignment = 4;  // NLMSG_ALIGNTO and RTA_ALIGNTO
constexpr int answer_timeout_ms = 1000;
constexpr std::size_t largest_datagram = 32768;

constexpr std::size_t aligned(std::size_t size) {
    return (size + alignment - 1) / alignment * alignment;
}

/// A structure at the start of `bytes`, in the machine's octet order; nothing when it is cut short.
template <typename T>
std::optional<T> leading(Bytes bytes) {
    if (bytes.size() < sizeof(T)) return std::nullopt;
    T value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
}

Bytes behind(Bytes bytes, std::size_t size) {
    return bytes.subspan(std::min(aligned(size), bytes.size()));
}

/// The attribute's content; nothing when it is not there.
std::optional<Bytes> find_attribute(Bytes attributes, std::uint16_t type) {
    while (const auto header = leading<rtattr>(attributes)) {
        if (header->rta_len < sizeof(rtattr) || header->rta_len > attributes.size()) break;
        if ((header->rta_type & NLA_TYPE_MASK) == type) {
            return attributes.first(header->rta_len).subspan(sizeof(rtattr));
        }
        attributes = behind(attributes, header->rta_len);
    }
    return std::nullopt;
}

template <typename T>
std::optional<T> find_value(Bytes attributes, std::uint16_t type) {
    const auto content = find_attribute(attributes, type);
    return content ? leading<T>(*content) : std::nullopt;
}

std::string find_text(Bytes attributes, std::uint16_t type) {
    const Bytes content = find_attribute(attributes, type).value_or(Bytes{});
    return {content.begin(), std::find(content.begin(), content.end(), std::uint8_t{0})};
}

// ISO 11898-1 knows no warning state; and that a controller is stopped the interface's being down
// tells better than drivers do.
ControllerState controller_state(std::uint32_t kernel_state) {
    switch (kernel_state) {
        case CAN_STATE_ERROR_PASSIVE:
            return ControllerState::error_passive;
        case CAN_STATE_BUS_OFF:
            return ControllerState::bus_off;
        default:
            return ControllerState::error_active;
    }
}

void read_can_details(Bytes details, InterfaceStatus& status) {
    if (const auto timing = find_value<can_bittiming>(details, IFLA_CAN_BITTIMING)) {
        status.bitrate = timing->bitrate;
    }
    if (const auto mode = find_value<can_ctrlmode>(details, IFLA_CAN_CTRLMODE)) {
        status.listen_only = (mode->flags & CAN_CTRLMODE_LISTENONLY) != 0;
    }
    status.restarts_itself =
        find_value<std::uint32_t>(details, IFLA_CAN_RESTART_MS).value_or(0) != 0;
    if (const auto state = find_value<std::uint32_t>(details, IFLA_CAN_STATE)) {
        status.errors = ErrorStatus{.state = controller_state(*state)};
        if (const auto counters = find_value<can_berr_counter>(details, IFLA_CAN_BERR_COUNTER)) {
            status.errors->tec = counters->txerr;
            status.errors->rec = counters->rxerr;
        }
    }
}

std::optional<InterfaceStatus> parse_interface(Bytes content, bool removed) {
    const auto link = leading<ifinfomsg>(content);
    if (!link) return std::nullopt;
    const Bytes attributes = behind(content, sizeof(ifinfomsg));
    InterfaceStatus status;
    status.index = link->ifi_index;
    status.name = find_text(attributes, IFLA_IFNAME);
    status.is_can = link->ifi_type == ARPHRD_CAN;
    status.removed = removed;
    status.up = !removed && (link->ifi_flags & IFF_UP) != 0;
    status.carrier = (link->ifi_flags & IFF_LOWER_UP) != 0;
    status.running = (link->ifi_flags & IFF_RUNNING) != 0;
    status.echoes = (link->ifi_flags & IFF_ECHO) != 0;
    const Bytes information = find_attribute(attributes, IFLA_LINKINFO).value_or(Bytes{});
    if (find_text(information, IFLA_INFO_KIND) == "can") {
        read_can_details(find_attribute(information, IFLA_INFO_DATA).value_or(Bytes{}), status);
    }
    return status;
}

/// A request that grows attribute by attribute, nested ones from the inside out.
class Attributes {
  public:
    Attributes& add(std::uint16_t type, Bytes content) {
        rtattr header{};
        header.rta_len = static_cast<std::uint16_t>(sizeof header + content.size());
        header.rta_type = type;
        append(octets_, &header, sizeof header);
        append(octets_, content.data(), content.size());
        octets_.resize(aligned(octets_.size()));
        return *this;
    }
    Attributes& add(std::uint16_t type, std::string_view text) {
        std::vector<std::uint8_t> content{text.begin(), text.end()};
        content.push_back(0);
        return add(type, Bytes{content});
    }
    Bytes octets() const { return octets_; }

    static void append(std::vector<std::uint8_t>& to, const void* data, std::size_t size) {
        const auto* const from = static_cast<const std::uint8_t*>(data);
        to.insert(to.end(), from, from + size);
    }

  private:
    std::vector<std::uint8_t> octets_;
};

std::vector<std::uint8_t> request(std::uint16_t type, std::uint16_t flags, int index,
                                  const Attributes& attributes) {
    ifinfomsg link{};
    link.ifi_family = AF_UNSPEC;
    link.ifi_index = index;
    nlmsghdr header{};
    header.nlmsg_len =
        static_cast<std::uint32_t>(sizeof header + sizeof link + attributes.octets().size());
    header.nlmsg_type = type;
    header.nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | flags);
    std::vector<std::uint8_t> datagram;
    Attributes::append(datagram, &header, sizeof header);
    Attributes::append(datagram, &link, sizeof link);
    Attributes::append(datagram, attributes.octets().data(), attributes.octets().size());
    return datagram;
}

/// 0, or an errno.
int send_datagram(const Descriptor& socket, Bytes datagram) {
    sockaddr_nl kernel{};
    kernel.nl_family = AF_NETLINK;
    const auto sent = ::sendto(socket.get(), datagram.data(), datagram.size(), 0,
                               reinterpret_cast<const sockaddr*>(&kernel), sizeof kernel);
    return sent < 0 ? errno : 0;
}

/// Nothing: errno tells why.
std::optional<std::vector<NetlinkMessage>> receive_datagram(const Descriptor& socket,
                                                            std::vector<std::uint8_t>& buffer) {
    ssize_t size = 0;
    do {
        size = ::recv(socket.get(), buffer.data(), buffer.size(), 0);
    } while (size < 0 && errno == EINTR);
    if (size < 0) return std::nullopt;
    return parse_netlink(Bytes{buffer}.first(static_cast<std::size_t>(size)));
}

Descriptor netlink_socket() {
    return Descriptor{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)};
}

}  // namespace

std::vector<NetlinkMessage> parse_netlink(Bytes datagram) {
    std::vector<NetlinkMessage> messages;
    while (const auto header = leading<nlmsghdr>(datagram)) {
        if (header->nlmsg_len < sizeof(nlmsghdr) || header->nlmsg_len > datagram.size()) break;
        const Bytes content = behind(datagram.first(header->nlmsg_len), sizeof(nlmsghdr));
        if (header->nlmsg_type == NLMSG_ERROR) {
            if (const auto error = leading<std::int32_t>(content)) {
                // A negative errno, or 0; anything else is none.
                messages.emplace_back(NetlinkAnswer{-std::clamp(*error, -4095, 0)});
            }
        } else if (header->nlmsg_type == RTM_NEWLINK || header->nlmsg_type == RTM_DELLINK) {
            if (auto status = parse_interface(content, header->nlmsg_type == RTM_DELLINK)) {
                messages.emplace_back(std::move(*status));
            }
        }
        datagram = behind(datagram, header->nlmsg_len);
    }
    return messages;
}

std::vector<std::uint8_t> interface_query(std::string_view name) {
    assert(name.size() < IFNAMSIZ);
    return request(RTM_GETLINK, 0, 0, Attributes{}.add(IFLA_IFNAME, name));
}

std::vector<std::uint8_t> restart_request(int index) {
    const std::uint32_t yes = 1;
    std::array<std::uint8_t, sizeof yes> octets{};
    std::memcpy(octets.data(), &yes, sizeof yes);
    const Attributes details = Attributes{}.add(IFLA_CAN_RESTART, octets);
    const Attributes information =
        Attributes{}.add(IFLA_INFO_KIND, "can").add(IFLA_INFO_DATA, details.octets());
    return request(RTM_NEWLINK, NLM_F_ACK, index,
                   Attributes{}.add(IFLA_LINKINFO, information.octets()));
}

InterfaceMonitor::InterfaceMonitor(std::string name, Descriptor socket)
    : name_(std::move(name)), socket_(std::move(socket)), buffer_(largest_datagram) {}

Result<InterfaceMonitor, int> InterfaceMonitor::open(std::string name) {
    Descriptor socket = netlink_socket();
    if (!socket.is_open()) return Failure{errno};
    sockaddr_nl address{};
    address.nl_family = AF_NETLINK;
    address.nl_groups = RTMGRP_LINK;
    if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        return Failure{errno};
    }
    InterfaceMonitor monitor{std::move(name), std::move(socket)};
    monitor.refresh();
    return monitor;
}

bool InterfaceMonitor::update() {
    if (!drain()) return false;
    refresh();
    return true;
}

void InterfaceMonitor::refresh() {
    // A socket that is full takes no answer.
    drain();
    // The kernel answers before this returns. It fails only where drain() would fail as well.
    [[maybe_unused]] const int error = send_datagram(socket_, interface_query(name_));
    drain();
}

// True: there were news of this interface, or something was lost.
bool InterfaceMonitor::drain() {
    bool any = false;
    for (;;) {
        const auto messages = receive_datagram(socket_, buffer_);
        if (messages) {
            for (const NetlinkMessage& message : *messages) any = take(message) || any;
        } else if (errno == ENOBUFS) {
            any = true;
        } else {
            return any;
        }
    }
}

bool InterfaceMonitor::take(const NetlinkMessage& message) {
    if (const auto* answer = std::get_if<NetlinkAnswer>(&message)) {
        // The only question asked here is the one for the interface.
        if (answer->error == ENODEV) status_ = InterfaceStatus{.removed = true};
        return true;
    }
    const auto& news = std::get<InterfaceStatus>(message);
    const bool is_known = !status_.removed && news.index == status_.index;
    if (news.name == name_ && (is_known || !news.removed)) {
        status_ = news;
        return true;
    }
    // It has another name now.
    if (is_known) status_ = InterfaceStatus{.removed = true};
    return is_known;
}

int restart_interface(int index) {
    const Descriptor socket = netlink_socket();
    if (!socket.is_open()) return errno;
    if (const int error = send_datagram(socket, restart_request(index)); error != 0) return error;
    pollfd readable{socket.get(), POLLIN, 0};
    if (::poll(&readable, 1, answer_timeout_ms) <= 0) return ETIMEDOUT;
    std::vector<std::uint8_t> buffer(largest_datagram);
    const auto answers = receive_datagram(socket, buffer);
    if (!answers) return errno;
    for (const NetlinkMessage& message : *answers) {
        if (const auto* answer = std::get_if<NetlinkAnswer>(&message)) return answer->error;
    }
    return ENOMSG;
}

}  // namespace canorb::can
