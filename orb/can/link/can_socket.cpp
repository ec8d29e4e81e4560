#include "orb/can/link/can_socket.hpp"

#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <linux/sock_diag.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>

#include "orb/can/link/link.hpp"

namespace canorb::can {
namespace {

/// More than the default, which holds some 270 frames. The kernel gives what rmem_max allows.
constexpr int receive_buffer = 1 << 20;

template <typename Value>
int set_option(const Descriptor& socket, int level, int option, const Value& value) {
    return ::setsockopt(socket.get(), level, option, &value, sizeof value) == 0 ? 0 : errno;
}

Duration to_duration(const timespec& time) {
    return std::chrono::seconds{time.tv_sec} + Duration{time.tv_nsec};
}

ReceiveClock::Present look_at_clocks() {
    timespec time_of_day{};
    ::clock_gettime(CLOCK_REALTIME, &time_of_day);
    return {monotonic_now(), to_duration(time_of_day)};
}

}  // namespace

CanSocket::CanSocket() {
    for (std::size_t i = 0; i < batch_size; ++i) {
        vectors_[i] = {&frames_[i], sizeof frames_[i]};
        headers_[i].msg_hdr.msg_iov = &vectors_[i];
        headers_[i].msg_hdr.msg_iovlen = 1;
        headers_[i].msg_hdr.msg_control = controls_[i].octets.data();
    }
}

int CanSocket::open(int interface) {
    socket_ = Descriptor{::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)};
    if (!socket_.is_open()) return errno;
    received_ = next_ = 0;
    dropped_ = 0;
    // Without these two a time stamp is the moment of reading, and losses go unseen; nothing that
    // a kernel with CAN_RAW lacks.
    const int on = 1;
    const int stamps = SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE |
                       SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
    set_option(socket_, SOL_SOCKET, SO_TIMESTAMPING, stamps);
    set_option(socket_, SOL_SOCKET, SO_RXQ_OVFL, on);
    // With CAP_NET_ADMIN all of it; else as much as is allowed.
    if (set_option(socket_, SOL_SOCKET, SO_RCVBUFFORCE, receive_buffer) != 0) {
        set_option(socket_, SOL_SOCKET, SO_RCVBUF, receive_buffer);
    }
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = interface;
    int error = set_filters({});
    if (error == 0 &&
        ::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        error = errno;
    }
    if (error != 0) socket_.reset();
    return error;
}

void CanSocket::close() {
    socket_.reset();
}

int CanSocket::set_filters(std::span<const can_filter> filters) const {
    return ::setsockopt(socket_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                        static_cast<socklen_t>(filters.size_bytes())) == 0
               ? 0
               : errno;
}

int CanSocket::set_error_filter(can_err_mask_t classes) const {
    return set_option(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, classes);
}

int CanSocket::send(const can_frame& frame) const {
    return ::write(socket_.get(), &frame, sizeof frame) == sizeof frame ? 0 : errno;
}

void CanSocket::forget_error() const {
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
}

int CanSocket::receive() {
    received_ = next_ = 0;
    for (mmsghdr& header : headers_) header.msg_hdr.msg_controllen = sizeof(Control);
    int count = 0;
    do {
        count = ::recvmmsg(socket_.get(), headers_.data(), batch_size, 0, nullptr);
    } while (count < 0 && errno == EINTR);
    if (count < 0) return errno;
    received_ = static_cast<std::size_t>(count);
    present_ = look_at_clocks();
    return 0;
}

std::optional<CanSocket::Arrival> CanSocket::next() {
    if (next_ == received_) return std::nullopt;
    const msghdr& message = headers_[next_].msg_hdr;
    const Details details = details_of(message);
    Arrival arrival;
    arrival.frame = frames_[next_];
    arrival.time = clock_.time_of(details.software, details.hardware, present_);
    arrival.from_this_host = (message.msg_flags & MSG_DONTROUTE) != 0;
    if (details.dropped) arrival.lost_before = note_dropped(*details.dropped);
    ++next_;
    return arrival;
}

std::uint32_t CanSocket::find_losses() {
    std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
    socklen_t size = sizeof memory;
    if (::getsockopt(socket_.get(), SOL_SOCKET, SO_MEMINFO, memory.data(), &size) != 0) return 0;
    return note_dropped(memory[SK_MEMINFO_DROPS]);
}

CanSocket::Details CanSocket::details_of(const msghdr& message) {
    Details details;
    msghdr copy = message;  // CMSG_NXTHDR wants one that is not const
    for (cmsghdr* control = CMSG_FIRSTHDR(&copy); control != nullptr;
         control = CMSG_NXTHDR(&copy, control)) {
        if (control->cmsg_level != SOL_SOCKET) continue;
        if (control->cmsg_type == SO_TIMESTAMPING) {
            scm_timestamping times{};
            std::memcpy(&times, CMSG_DATA(control), sizeof times);
            // Zero is "none".
            if (const auto time = to_duration(times.ts[0]); time != Duration::zero()) {
                details.software = time;
            }
            if (const auto time = to_duration(times.ts[2]); time != Duration::zero()) {
                details.hardware = time;
            }
        } else if (control->cmsg_type == SO_RXQ_OVFL) {
            std::uint32_t dropped = 0;
            std::memcpy(&dropped, CMSG_DATA(control), sizeof dropped);
            details.dropped = dropped;
        }
    }
    return details;
}

// The count wraps around; and one that find_losses() has told may come with a frame once more.
std::uint32_t CanSocket::note_dropped(std::uint32_t dropped) {
    const auto more = static_cast<std::int32_t>(dropped - dropped_);
    if (more <= 0) return 0;
    dropped_ = dropped;
    return static_cast<std::uint32_t>(more);
}

}  // namespace canorb::can
