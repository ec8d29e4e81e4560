#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/result.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/descriptor.hpp"
#include "orb/can/link/serial_port.hpp"
#include "orb/can/link/slcan_mailboxes.hpp"
#include "orb/can/link/slcan_protocol.hpp"
#include "orb/can/sim/event_queue.hpp"

namespace canorb::can {

/// The controller of a serial adapter: doc/wire/slcan.md.
///
/// Invariants, all under the mutex:
/// * The epoll descriptor, which is what users wait for, holds the terminal while there is one,
///   the timer, which is due at the next deadline or before, and the signal, which is raised while
///   there are events or unread octets here.
/// * At most one command awaits its answer. A new one is written only when the one before is
///   written completely and answered.
class SlcanController final : public Controller {
  public:
    /// Blocks until the adapter is on the bus, some seconds where nothing answers. The error is a
    /// sentence for people.
    static Result<std::unique_ptr<SlcanController>, std::string> open(SlcanAddress address);

    ~SlcanController() override;

    Capabilities capabilities() const override;
    [[nodiscard]] SendResult send(const Frame& frame, SendOptions options) override;
    void abort(TransmitHandle handle) override;
    [[nodiscard]] bool set_filters(std::span<const Filter> filters) override;
    [[nodiscard]] bool set_listen_only(bool on) override;
    ErrorStatus error_status() const override;
    std::optional<std::string> recover() override;
    std::string explanation() const override;
    std::optional<ControllerEvent> poll() override;
    int event_fd() const override { return epoll_.get(); }

  private:
    /// What the adapter is asked to do.
    enum class Command : std::uint8_t {
        none,
        greeting,  ///< the first of the setup; up to first_flags in this order
        settling,  ///< nothing is asked: answers to earlier greetings may still come
        bitrate,
        auto_poll,
        open,
        first_flags,
        change_mode,  ///< close and open, with two answers
        flags,
        transmit,
    };

    explicit SlcanController(SlcanAddress address);

    void await_room(bool on);
    bool is_up() const;

    void open_port(TimePoint now);
    /// Begins the setup, once the command that is awaited is answered.
    void greet();
    /// The way to `stopped`; the port is opened again later.
    void lose(std::string why, TimePoint now);
    void change_state(const ErrorStatus& status, TimePoint now);

    void end_transmission(bool accepted, TimePoint now);

    /// Writes commands until one has to wait for its answer. Every public function that may have
    /// changed something ends with it.
    void go_on(TimePoint now);
    /// Writes what there is to write. False: it has to wait, or the port is gone.
    bool flush(TimePoint now);
    /// False: there is nothing to ask for now.
    bool put_next(TimePoint now);
    void put_setup(TimePoint now);
    /// To be written now.
    std::string_view open_text();
    void put(Command command, std::string_view text, TimePoint now, int answers = 1);

    void on_done(TimePoint now);
    void on_refused(TimePoint now);
    void on_version(TimePoint now);
    std::optional<ControllerEvent> on_flags(std::uint8_t bits, TimePoint now);
    /// Looks whether the answer is late. All that the adapter has said by now is understood.
    void check_answer(TimePoint now);
    void next_setup(Command next);
    void finish_setup(bool tells_flags, TimePoint now);

    std::optional<ControllerEvent> next_event(TimePoint now);
    std::optional<ControllerEvent> understand(const slcan::Message& message, TimePoint now);

    void set_timer();
    void update_signal();

    std::string gone() const;
    std::string refused_to_open() const;

    const SlcanAddress address_;
    mutable std::mutex mutex_;
    ErrorStatus status_{.state = ControllerState::stopped};
    std::string explanation_;
    std::vector<Filter> filters_;
    bool listen_only_ = false;
    bool channel_listens_only_ = false;

    SerialPort port_;
    slcan::Receiver receiver_;
    std::array<char, 512> input_buffer_;
    std::span<const char> input_;  ///< what is not understood yet
    TimePoint input_time_;
    std::array<char, 32> output_buffer_;
    std::string_view output_;  ///< what is not written yet
    bool writable_watched_ = false;

    Command setup_ = Command::none;  ///< what comes before anything else
    Command awaited_ = Command::none;
    int answers_due_ = 0;
    int greetings_left_ = 0;
    TimePoint answer_by_ = never;
    TimePoint flags_due_ = never;  ///< `never`: the adapter has no flags
    TimePoint last_flags_;
    TimePoint retry_at_;
    TimePoint reopen_at_ = never;

    sim::EventQueue own_events_;
    SlcanMailboxes mailboxes_;
    Signal own_signal_;
    bool signalled_ = false;
    Descriptor epoll_;
    Timer timer_;
    TimePoint timer_due_ = never;
};

}  // namespace canorb::can
