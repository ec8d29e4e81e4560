#pragma once

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "orb/base/bytes.hpp"

namespace canorb::test {

/// A socket on one CAN interface, as any other program has one: nothing of the ORB is in it.
/// Everything throws std::system_error.
class RawSocket {
  public:
    explicit RawSocket(const std::string& interface)
        : fd_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)) {
        check(fd_, "socket(CAN_RAW)");
        sockaddr_can address{};
        address.can_family = AF_CAN;
        address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
        if (address.can_ifindex == 0) throw failure("interface " + interface);
        check(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), "bind");
    }
    ~RawSocket() { ::close(fd_); }
    RawSocket(const RawSocket&) = delete;
    RawSocket& operator=(const RawSocket&) = delete;

    /// Receives data frames with this standard identifier and nothing else.
    void accept_only(std::uint32_t id) {
        const can_filter filter{id, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
        check(::setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter),
              "CAN_RAW_FILTER");
    }

    /// Blocks while the interface's queue is full.
    void send(const can_frame& frame) {
        while (::write(fd_, &frame, sizeof frame) != sizeof frame) {
            if (errno != ENOBUFS) throw failure("write");
            std::this_thread::sleep_for(std::chrono::microseconds{200});
        }
    }
    void send(std::uint32_t id, Bytes data) {
        can_frame frame{};
        frame.can_id = id;
        frame.can_dlc = static_cast<std::uint8_t>(data.size());
        std::memcpy(frame.data, data.data(), data.size());
        send(frame);
    }

    /// Blocks until a frame comes.
    can_frame receive() {
        can_frame frame{};
        if (::read(fd_, &frame, sizeof frame) != sizeof frame) throw failure("read");
        return frame;
    }
    /// Nothing where none comes in time.
    std::optional<can_frame> receive_within(std::chrono::milliseconds patience) {
        pollfd readable{fd_, POLLIN, 0};
        if (::poll(&readable, 1, static_cast<int>(patience.count())) <= 0) return {};
        return receive();
    }

  private:
    static std::system_error failure(const std::string& what) {
        return {errno, std::generic_category(), what};
    }
    static void check(int result, const char* what) {
        if (result < 0) throw failure(what);
    }

    int fd_;
};

}  // namespace canorb::test
