#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "orb/base/result.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/link/can_interface.hpp"
#include "orb/can/link/descriptor.hpp"
#include "orb/can/link/receive_clock.hpp"

namespace canorb::can {

/// A CAN_RAW socket on a CAN interface.
///
/// Invariants, all under the mutex:
///  * The epoll descriptor, which is what users wait for, holds the CAN socket while there is one,
///    the monitor, the timer, and the signal, which is raised while `own_events_` has any that do
///    not follow from send().
///  * `in_flight_` has each frame that the kernel took, until it was confirmed or has failed; it is
///    empty while the controller is stopped or bus-off.
///  * The kernel's filters pass what `filters_` accept and the identifiers in `sent_ids_`: a frame
///  of
///    one's own comes back, as its confirmation, only through a filter.
class SocketCanController final : public Controller {
  public:
    /// The error is a sentence for people.
    static Result<std::unique_ptr<SocketCanController>, std::string> open(std::string interface);

    Capabilities capabilities() const override;
    [[nodiscard]] SendResult send(const Frame& frame, SendOptions options) override;
    /// No effect: the kernel gives back nothing that it took.
    void abort(TransmitHandle) override {}
    [[nodiscard]] bool set_filters(std::span<const Filter> filters) override;
    /// Not supported: the mode of an interface belongs to its administrator.
    [[nodiscard]] bool set_listen_only(bool on) override { return !on; }
    ErrorStatus error_status() const override;
    std::optional<std::string> recover() override;
    std::string explanation() const override;
    std::optional<ControllerEvent> poll() override;
    int event_fd() const override { return epoll_.get(); }

  private:
    /// Frames taken from the kernel at once. A queue of fewer is empty then.
    static constexpr std::size_t batch_size = 16;

    struct InFlight {
        TransmitHandle handle;
        can_frame frame;
        TimePoint sent;
    };

    /// What recvmmsg() fills in.
    struct Batch {
        struct Control {
            alignas(cmsghdr) std::array<char, 128> octets;
        };
        Batch();
        std::array<can_frame, batch_size> frames{};
        std::array<Control, batch_size> controls{};
        std::array<iovec, batch_size> vectors{};
        std::array<mmsghdr, batch_size> headers{};
    };

    /// What the kernel says beside a frame.
    struct Stamps {
        std::optional<Duration> software;
        std::optional<Duration> hardware;
        std::optional<std::uint32_t> dropped;  ///< by the socket so far
    };

    SocketCanController(std::string name, InterfaceMonitor monitor);

    /// 0, or an errno.
    int open_socket();
    int apply_filters();
    bool passes(const Frame& frame) const;
    void expect_own(std::uint32_t can_id);

    void receive();
    void find_losses_at_end();
    std::optional<ControllerEvent> understand(const mmsghdr& header, const can_frame& frame);
    static Stamps stamps_of(const msghdr& message);
    std::optional<ControllerEvent> confirm(const can_frame& frame, TimePoint time);
    void take_error(const can_frame& frame, TimePoint time);
    std::optional<FramesLost> note_dropped(std::uint32_t dropped);

    void follow_interface();
    void lose_socket(int error);
    void enter_state(ErrorStatus status);
    void fail_in_flight();
    void tell(const ControllerEvent& event);
    void wait_for_room();
    void watch_in_flight();
    void on_timer();
    std::string by_hand() const;

    const std::string name_;
    mutable std::mutex mutex_;
    InterfaceMonitor monitor_;
    Descriptor socket_;
    int bound_to_ = 0;  ///< the index of the socket's interface
    /// The interface gives back what it has sent. One that does not is virtual: the kernel would
    /// give back a copy by itself as soon as it has the frame, which send() knows as well.
    bool confirms_ = false;
    Descriptor epoll_;
    Descriptor timer_;
    Signal own_signal_;
    std::deque<ControllerEvent> own_events_;  ///< that no frame brought
    std::size_t results_ = 0;                 ///< TransmitResults among them
    bool signalled_ = false;
    ErrorStatus status_{.state = ControllerState::stopped};
    ControllerState told_state_ = ControllerState::stopped;  ///< by the StateChanged taken last
    bool carrier_lost_ = false;  ///< and the interface is not running again
    std::vector<Filter> filters_;
    std::vector<std::uint32_t> sent_ids_;
    std::vector<InFlight> in_flight_;
    std::uint64_t next_handle_ = 1;
    bool waiting_for_room_ = false;  ///< the timer says when to send again
    bool watching_ = false;          ///< the timer looks after in_flight_
    Batch batch_;
    std::size_t received_ = 0;  ///< frames in the batch
    std::size_t next_ = 0;      ///< of those, the next to be told
    bool drained_ = false;      ///< there was nothing behind the batch
    bool overflow_possible_ = false;
    std::uint32_t dropped_ = 0;  ///< by the socket, and told
    ReceiveClock clock_;
    ReceiveClock::Present present_{};  ///< when the batch came
};

}  // namespace canorb::can
