#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "orb/base/time.hpp"
#include "orb/can/frame.hpp"

namespace canorb::can {

/// Names one transmission on one controller, from its send() to its TransmitResult.
enum class TransmitHandle : std::uint64_t {};

enum class TransmitOutcome : std::uint8_t {
    sent,     ///< on the bus and acknowledged
    aborted,  ///< withdrawn by abort() before it was on the bus
    failed,   ///< one-shot and disturbed, or the controller left the bus
};

/// ISO 11898-1's fault confinement states; `stopped` is a controller that takes no part at all
/// (interface down, daemon gone, never started).
enum class ControllerState : std::uint8_t { error_active, error_passive, bus_off, stopped };

std::string_view name(ControllerState state);

/// State, transmit and receive error counters at one moment.
struct ErrorStatus {
    ControllerState state = ControllerState::error_active;
    std::uint16_t tec = 0;
    std::uint16_t rec = 0;
    friend bool operator==(const ErrorStatus&, const ErrorStatus&) = default;
};

/// A frame came in through the acceptance filters.
struct Received {
    Frame frame;
    TimePoint time;  ///< end of EOF, on the bus's clock
};

/// A transmission came to its end. Exactly one for each successful send(), from poll() or from
/// send() itself.
struct TransmitResult {
    TransmitHandle handle;
    TransmitOutcome outcome;
    TimePoint time;  ///< `sent`: end of EOF, on the bus's clock; else the moment it was known
    friend bool operator==(const TransmitResult&, const TransmitResult&) = default;
};

/// The fault confinement state changed.
struct StateChanged {
    ErrorStatus status;
    TimePoint time;
};

/// The link lost received frames: a full receive buffer, an overrun, a slow client. Or it may have:
/// an error passive controller could not read a frame, and cannot have it repeated.
struct FramesLost {
    std::uint64_t count;  ///< at least this many; 0: perhaps none
    TimePoint time;
};

/// What a controller tells, in the order in which it happened.
using ControllerEvent = std::variant<Received, TransmitResult, StateChanged, FramesLost>;

/// What a controller can do, fixed once it is open.
struct Capabilities {
    std::uint8_t max_payload = Frame::max_classic_payload;  ///< octets in a frame
    std::size_t mailboxes = 1;  ///< transmissions it holds at once; more are refused as `full`
    /// Room for this many exact filters; 0: a BasicCAN controller with two mask-and-match
    /// registers.
    std::size_t filter_list = 0;
    std::uint32_t bitrate = 0;  ///< bit/s; 0: the link does not know
    bool one_shot = false;
    bool listen_only = false;
    /// The mailboxes are a queue that others keep: frames leave in the order of their send(), and
    /// abort() cannot withdraw them.
    bool fifo = false;
};

enum class SendError : std::uint8_t {
    full,         ///< no room: send again after the next TransmitResult, or when event_fd() wakes
    bus_off,      ///< recover() first
    stopped,      ///< the link is down or gone
    unsupported,  ///< the frame, or one-shot, is beyond the Capabilities, or listen-only is on
};

/// The handle of a transmission whose TransmitResult will come; or the result itself, where it is
/// known at once; or why there is none.
using SendResult = std::variant<TransmitHandle, TransmitResult, SendError>;

struct SendOptions {
    bool one_shot = false;  ///< do not repeat after an error or a lost arbitration
};

/// Who is to be woken. Any thread.
class Waker {
  public:
    virtual void wake() noexcept = 0;

  protected:
    ~Waker() = default;
};

/// A CAN controller: the seam between the ORB and every link (in-process, simulated bus,
/// SocketCAN, serial adapter). Frames with one identifier leave in the order of their send();
/// among those that wait in the mailboxes the lowest identifier leaves first, except where
/// Capabilities::fifo says otherwise.
///
/// No function blocks, and none calls back but a Waker. A link that other threads feed makes every
/// function safe to call from any thread; one consumer at a time takes events.
class Controller {
  public:
    virtual ~Controller() = default;
    Controller(const Controller&) = delete;
    Controller& operator=(const Controller&) = delete;

    virtual Capabilities capabilities() const = 0;

    /// Hands a frame over for transmission.
    [[nodiscard]] virtual SendResult send(const Frame& frame, SendOptions options = {}) = 0;

    /// Asks to withdraw a transmission. Its TransmitResult tells what became of it: a frame
    /// already on the bus may still be `sent`. Unknown handles are ignored.
    virtual void abort(TransmitHandle handle) = 0;

    /// Replaces all acceptance filters; a frame passes when any accepts it, none means nothing
    /// passes. A BasicCAN controller takes at most two. False: more than the controller has room
    /// for; the old ones stay.
    [[nodiscard]] virtual bool set_filters(std::span<const Filter> filters) = 0;

    /// Silent on the bus: receives, but neither acknowledges nor sends. False: not supported.
    [[nodiscard]] virtual bool set_listen_only(bool on) = 0;

    virtual ErrorStatus error_status() const = 0;

    /// Asks to leave bus-off. A StateChanged tells when it has; in any other state it does
    /// nothing. A request is kept while the link itself is down. When it cannot be asked for, for
    /// example without permission: why, a sentence for people that says what to do.
    virtual std::optional<std::string> recover() = 0;

    /// What is behind the state that error_status() tells, for people, for example which interface
    /// is down and what brings it up; empty where there is nothing to add.
    virtual std::string explanation() const { return {}; }

    /// The next event, or nothing.
    virtual std::optional<ControllerEvent> poll() = 0;

    /// A file descriptor that is readable while poll() may have an event, or -1 where there is
    /// none (a virtual bus). Valid as long as the controller; do not read from it.
    virtual int event_fd() const = 0;

    /// Wakes `waker`, too, when poll() may have an event, from then on; cheaper than a descriptor
    /// inside a process. False: it does not.
    [[nodiscard]] virtual bool wake_with(std::shared_ptr<Waker> /*waker*/) { return false; }

  protected:
    Controller() = default;
};

}  // namespace canorb::can
