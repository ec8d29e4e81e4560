#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/base/result.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/link/descriptor.hpp"

namespace canorb::can {

/// What the kernel tells of a network interface (rtnetlink(7), linux/can/netlink.h).
struct InterfaceStatus {
    int index = 0;
    std::string name{};
    bool is_can = false;  ///< carries CAN frames
    bool removed = false;
    bool up = false;
    /// A driver takes its carrier away in bus-off, and a vxcan has none while its peer is down. The
    /// kernel drops frames without an error until it is `running` again, which may be a second
    /// later.
    bool carrier = false;
    bool running = false;
    bool echoes = false;  ///< gives sent frames back when they are on the bus, not before
    bool listen_only = false;
    bool restarts_itself = false;         ///< after bus-off: restart-ms is set
    std::uint32_t bitrate = 0;            ///< bit/s; 0: not told, as for vcan
    std::optional<ErrorStatus> errors{};  ///< nothing: not told, as for vcan
};

/// The kernel's answer to a request: 0, or an errno. ENODEV: there is no such interface.
struct NetlinkAnswer {
    int error;
    friend bool operator==(const NetlinkAnswer&, const NetlinkAnswer&) = default;
};

using NetlinkMessage = std::variant<InterfaceStatus, NetlinkAnswer>;

/// What is in one datagram from the kernel. Anything else, and what is cut short, is left out.
std::vector<NetlinkMessage> parse_netlink(Bytes datagram);

/// The datagram that asks for an interface by its name, of at most 15 characters.
std::vector<std::uint8_t> interface_query(std::string_view name);

/// The datagram that asks to restart an interface after bus-off, and for an answer.
std::vector<std::uint8_t> restart_request(int index);

/// Watches one interface, by its name: whatever may come under that name.
class InterfaceMonitor {
  public:
    /// The error is an errno.
    static Result<InterfaceMonitor, int> open(std::string name);

    /// Readable when update() has something to do.
    int fd() const { return socket_.get(); }

    /// Takes in what has changed. True: there were news of this interface, and status() is as of
    /// now, whatever was in the news.
    bool update();

    /// Asks the kernel: status() is as of now.
    void refresh();

    /// As of the last update() or refresh(). An interface that does not exist is `removed`.
    const InterfaceStatus& status() const { return status_; }

  private:
    InterfaceMonitor(std::string name, Descriptor socket);
    bool drain();
    bool take(const NetlinkMessage& message);

    std::string name_;
    Descriptor socket_;
    std::vector<std::uint8_t> buffer_;
    InterfaceStatus status_{.removed = true};
};

/// Asks the kernel to take an interface out of bus-off. 0, or an errno: EPERM without
/// CAP_NET_ADMIN, EBUSY where it is not bus-off, EINVAL where it restarts by itself.
int restart_interface(int index);

}  // namespace canorb::can
