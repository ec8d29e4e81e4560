#pragma once

#include <linux/can.h>

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
#include "orb/can/link/can_socket.hpp"
#include "orb/can/link/descriptor.hpp"

namespace canorb::can {

/// A CAN interface of Linux (doc/links.md, doc/decisions/008-socketcan-link.md).
///
/// Invariants, all under the mutex:
///  * The epoll descriptor, which is what users wait for, holds both sockets while they are open,
///    the monitor, the timer, and the signal, which is raised while `own_events_` has any.
///  * Both sockets are open, or none is.
///  * `in_flight_` has each frame that the kernel took, until it was confirmed or has failed; it is
///    empty while the controller is stopped or bus-off, and where the interface does not echo.
///  * `sent_ids_` are those that the watcher's filters pass: all that are in flight are among them.
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
    struct InFlight {
        TransmitHandle handle;
        can_frame frame;
        TimePoint sent;
    };

    SocketCanController(std::string name, InterfaceMonitor monitor);

    /// 0, or an errno.
    int open_sockets();
    int try_to_open_sockets();
    void close_sockets();
    void apply_filters() const;
    void expect_echo(std::uint32_t can_id);

    void ask_kernel();
    std::optional<ControllerEvent> next_from_watcher();
    std::optional<ControllerEvent> next_from_socket();
    std::optional<ControllerEvent> confirm(const CanSocket::Arrival& arrival);
    void take_error(const can_frame& frame);

    void follow_interface();
    void lose_interface(int error);
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
    CanSocket socket_;  ///< sends, and receives what others send
    CanSocket
        watcher_;  ///< receives what socket_ has sent, and errors: a flood cannot push them out
    int bound_to_ = 0;  ///< the index of the sockets' interface
    Descriptor epoll_;
    Timer timer_;
    Signal own_signal_;
    std::deque<ControllerEvent> own_events_;  ///< that are told before what waits in the sockets
    ErrorStatus status_{.state = ControllerState::stopped};
    ControllerState told_state_ = ControllerState::stopped;  ///< by the StateChanged taken last
    bool echoes_ = false;                                    ///< the interface does
    bool carrier_lost_ = false;  ///< and the interface is not running again
    std::vector<Filter> filters_;
    std::vector<std::uint32_t> sent_ids_;
    std::vector<InFlight> in_flight_;
    std::uint64_t next_handle_ = 1;
    bool waiting_for_room_ = false;   ///< the timer says when to send again
    bool watching_ = false;           ///< the timer looks after in_flight_
    bool drained_ = false;            ///< nothing waited when the kernel was asked last
    bool overflow_possible_ = false;  ///< since losses were looked for
};

}  // namespace canorb::can
