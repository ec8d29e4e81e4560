#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "orb/base/time.hpp"
#include "orb/can/link/descriptor.hpp"
#include "orb/can/link/receive_clock.hpp"

namespace canorb::can {

/// A CAN_RAW socket: frames, time stamps and losses. Functions that return an int return 0 or an
/// errno. Nothing blocks.
class CanSocket {
  public:
    /// A frame that came.
    struct Arrival {
        can_frame frame{};
        TimePoint time;
        bool from_this_host = false;
        std::uint32_t lost_before = 0;  ///< frames that the socket had no room for
    };

    CanSocket();
    CanSocket(const CanSocket&) = delete;
    CanSocket& operator=(const CanSocket&) = delete;

    /// On the interface with this index. Nothing passes until there are filters.
    int open(int interface);
    void close();
    bool is_open() const { return socket_.is_open(); }
    int fd() const { return socket_.get(); }

    /// At most CAN_RAW_FILTER_MAX (512).
    int set_filters(std::span<const can_filter> filters) const;
    int set_error_filter(can_err_mask_t classes) const;

    /// Other sockets on this host see the frame as well, this one does not.
    int send(const can_frame& frame) const;

    /// An error that waits, such as that the interface went down, is not told any more.
    void forget_error() const;

    /// Takes frames that wait, for next(). The errno is EAGAIN when there are none.
    int receive();
    std::optional<Arrival> next();
    /// The last receive() took as many as it can, so that there may be more.
    bool was_full() const { return received_ == batch_size; }
    /// Losses behind the last frame: a frame tells only of those before it. Costs a system call.
    std::uint32_t find_losses();

  private:
    static constexpr std::size_t batch_size = 16;

    struct Control {
        alignas(cmsghdr) std::array<char, 128> octets;
    };
    /// What the kernel says beside a frame.
    struct Details {
        std::optional<Duration> software;
        std::optional<Duration> hardware;
        std::optional<std::uint32_t> dropped;
    };

    static Details details_of(const msghdr& message);
    std::uint32_t note_dropped(std::uint32_t dropped);

    Descriptor socket_;
    std::array<can_frame, batch_size> frames_{};
    std::array<Control, batch_size> controls_{};
    std::array<iovec, batch_size> vectors_{};
    std::array<mmsghdr, batch_size> headers_{};
    std::size_t received_ = 0;
    std::size_t next_ = 0;
    std::uint32_t dropped_ = 0;  ///< by the socket, and told
    ReceiveClock clock_;
    ReceiveClock::Present present_{};  ///< when the batch came
};

}  // namespace canorb::can
