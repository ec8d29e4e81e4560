#include "orb/can/link/slcan_controller.hpp"

#include <poll.h>
#include <sys/epoll.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "orb/can/link/link.hpp"

namespace canorb::can {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t filter_list = 64;

constexpr Duration answer_patience = 1s;
/// An adapter that the opening of its port restarts hears nothing for a while, up to 2 s.
constexpr Duration greeting_interval = 500ms;
constexpr int greetings = 6;
/// After it, all answers to repeated greetings are here.
constexpr Duration settling_time = 250ms;
constexpr Duration reopen_interval = 500ms;
constexpr Duration flags_interval = 250ms;
/// When the adapter refused a frame: how soon the flags may tell why, and when to try again.
constexpr Duration flags_pause = 20ms;
constexpr Duration retry_pause = 2ms;
/// What one poll() reads at most, in pieces of the input buffer: no peer can keep it busy.
constexpr int pieces_per_poll = 16;

}  // namespace

SlcanController::SlcanController(SlcanAddress address)
    : address_(std::move(address)),
      own_events_(0),
      mailboxes_(own_events_),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
    watch(epoll_, own_signal_.fd());
    watch(epoll_, timer_.fd());
}

SlcanController::~SlcanController() {
    if (!port_.is_open()) return;
    // The first CR ends what may be written in part; a part of a command is no command.
    if (!output_.empty()) (void)port_.write("\r");
    (void)port_.write(slcan::close_command);
    port_.drain();
}

Result<std::unique_ptr<SlcanController>, std::string> SlcanController::open(SlcanAddress address) {
    std::unique_ptr<SlcanController> controller{new SlcanController{std::move(address)}};
    if (!controller->epoll_.is_open() || !controller->timer_.is_open() ||
        !controller->own_signal_.is_open()) {
        return Failure{std::string{"no more file descriptors for a controller"}};
    }
    controller->open_port(monotonic_now());
    const auto is_stopped = [&] { return controller->status_.state == ControllerState::stopped; };
    while (controller->port_.is_open() && is_stopped()) {
        pollfd readable{controller->event_fd(), POLLIN, 0};
        ::poll(&readable, 1, -1);
        controller->poll();
    }
    if (is_stopped()) return Failure{controller->explanation_};
    // That it is up is news only when it was up before.
    while (controller->own_events_.pop()) continue;
    controller->update_signal();
    return controller;
}

Capabilities SlcanController::capabilities() const {
    Capabilities result;
    result.mailboxes = SlcanMailboxes::count;
    result.filter_list = filter_list;
    result.bitrate = address_.bitrate;
    result.listen_only = address_.answers;
    return result;
}

SendResult SlcanController::send(const Frame& frame, SendOptions options) {
    const std::lock_guard lock{mutex_};
    if (!is_classic(frame) || options.one_shot || listen_only_) return SendError::unsupported;
    if (status_.state == ControllerState::stopped) return SendError::stopped;
    if (status_.state == ControllerState::bus_off) return SendError::bus_off;
    if (mailboxes_.full()) return SendError::full;
    const TransmitHandle handle = mailboxes_.add(frame);
    go_on(monotonic_now());
    return handle;
}

void SlcanController::abort(TransmitHandle handle) {
    const std::lock_guard lock{mutex_};
    mailboxes_.withdraw(handle, monotonic_now());
    update_signal();
}

bool SlcanController::set_filters(std::span<const Filter> filters) {
    const std::lock_guard lock{mutex_};
    if (filters.size() > filter_list) return false;
    filters_.assign(filters.begin(), filters.end());
    return true;
}

bool SlcanController::set_listen_only(bool on) {
    const std::lock_guard lock{mutex_};
    if (on == listen_only_) return true;
    if (!address_.answers) return false;
    const TimePoint now = monotonic_now();
    listen_only_ = on;
    if (on) mailboxes_.withdraw_all(now);
    go_on(now);
    return true;
}

ErrorStatus SlcanController::error_status() const {
    const std::lock_guard lock{mutex_};
    return status_;
}

std::optional<std::string> SlcanController::recover() {
    const std::lock_guard lock{mutex_};
    const TimePoint now = monotonic_now();
    if (status_.state == ControllerState::bus_off && setup_ == Command::none) {
        greet();
    } else if (status_.state == ControllerState::stopped && !port_.is_open()) {
        open_port(now);
    }
    go_on(now);
    return std::nullopt;
}

std::string SlcanController::explanation() const {
    const std::lock_guard lock{mutex_};
    return status_.state == ControllerState::stopped ? explanation_ : std::string{};
}

std::optional<ControllerEvent> SlcanController::poll() {
    const std::lock_guard lock{mutex_};
    const TimePoint now = monotonic_now();
    // An expiry that is not to be read yet will be at the next poll().
    if (now >= timer_due_ && timer_.take_expiry()) timer_due_ = never;
    if (!port_.is_open() && now >= reopen_at_) open_port(now);
    auto event = next_event(now);
    if (event) mailboxes_.on_taken(*event);
    go_on(now);
    return event;
}

void SlcanController::await_room(bool on) {
    if (on == writable_watched_) return;
    writable_watched_ = on;
    watch_writable(epoll_, port_.fd(), on);
}

bool SlcanController::is_up() const {
    return status_.state == ControllerState::error_active ||
           status_.state == ControllerState::error_passive;
}

void SlcanController::open_port(TimePoint now) {
    auto port = SerialPort::open(address_.device, address_.baud);
    if (!port) {
        explanation_ = port.error();
        reopen_at_ = now + reopen_interval;
        return;
    }
    port_ = std::move(*port);
    watch(epoll_, port_.fd());
    writable_watched_ = false;
    receiver_.reset();
    input_ = {};
    output_ = {};
    awaited_ = Command::none;
    greet();
    go_on(now);
}

void SlcanController::greet() {
    greetings_left_ = greetings;
    setup_ = Command::greeting;
}

void SlcanController::lose(std::string why, TimePoint now) {
    port_.close();  // which takes it out of the epoll set
    explanation_ = std::move(why);
    reopen_at_ = now + reopen_interval;
    input_ = {};
    output_ = {};
    awaited_ = Command::none;
    setup_ = Command::none;
    if (status_.state == ControllerState::stopped) return;
    change_state({.state = ControllerState::stopped}, now);
}

void SlcanController::change_state(const ErrorStatus& status, TimePoint now) {
    const bool news = status.state != status_.state;
    status_ = status;
    if (!news) return;
    own_events_.push(StateChanged{status, now});
    if (!is_up()) mailboxes_.fail_all(now);
}

void SlcanController::end_transmission(bool accepted, TimePoint now) {
    awaited_ = Command::none;
    if (!mailboxes_.end(accepted, now)) return;
    retry_at_ = now + retry_pause;
    // An adapter without flags is not asked for them here either.
    if (flags_due_ != never) flags_due_ = std::min(flags_due_, last_flags_ + flags_pause);
}

void SlcanController::put(Command command, std::string_view text, TimePoint now, int answers) {
    std::copy(text.begin(), text.end(), output_buffer_.begin());
    output_ = {output_buffer_.data(), text.size()};
    awaited_ = command;
    answers_due_ = answers;
    answer_by_ = !address_.answers              ? never
                 : command == Command::greeting ? now + greeting_interval
                                                : now + answer_patience;
}

bool SlcanController::flush(TimePoint now) {
    while (!output_.empty()) {
        const auto written = port_.write(output_);
        if (!written) {
            lose(gone(), now);
            return false;
        }
        output_.remove_prefix(*written);
        if (*written == 0) break;
    }
    await_room(!output_.empty());
    if (!output_.empty()) return false;
    // From a peer that never answers there is nothing more to learn.
    if (!address_.answers && awaited_ != Command::none) on_done(now);
    return true;
}

void SlcanController::go_on(TimePoint now) {
    while (port_.is_open() && flush(now) && awaited_ == Command::none) {
        if (!put_next(now)) break;
    }
    set_timer();
    update_signal();
}

bool SlcanController::put_next(TimePoint now) {
    if (setup_ != Command::none) {
        put_setup(now);
        return true;
    }
    if (!is_up()) return false;
    if (channel_listens_only_ != listen_only_) {
        put(Command::change_mode, std::string{slcan::close_command} += open_text(), now, 2);
        return true;
    }
    if (now >= flags_due_) {
        put(Command::flags, slcan::flags_command, now);
        return true;
    }
    if (!mailboxes_.waits() || now < retry_at_) return false;
    put(Command::transmit, slcan::transmit_command(mailboxes_.start()).text(), now);
    return true;
}

std::string_view SlcanController::open_text() {
    channel_listens_only_ = listen_only_;
    return listen_only_ ? slcan::listen_command : slcan::open_command;
}

void SlcanController::put_setup(TimePoint now) {
    switch (setup_) {
        case Command::greeting:
            --greetings_left_;
            put(setup_,
                std::string{slcan::flush_command} +=
                address_.answers ? slcan::version_command : std::string_view{},
                now);
            break;
        case Command::bitrate:
            put(setup_, slcan::bitrate_command(address_.bitrate).text(), now);
            break;
        case Command::auto_poll:
            put(setup_, slcan::auto_poll_command, now);
            break;
        case Command::open:
            put(setup_, open_text(), now);
            break;
        default:  // first_flags
            put(setup_, slcan::flags_command, now);
    }
}

void SlcanController::next_setup(Command next) {
    awaited_ = Command::none;
    setup_ = next;
}

void SlcanController::finish_setup(bool tells_flags, TimePoint now) {
    next_setup(Command::none);
    last_flags_ = now;
    flags_due_ = tells_flags ? now + flags_interval : never;
    if (!is_up()) change_state(ErrorStatus{}, now);
}

void SlcanController::on_done(TimePoint now) {
    switch (awaited_) {
        case Command::none:
        case Command::settling:
            return;
        case Command::greeting:  // only the version is an answer to it
            if (!address_.answers) next_setup(Command::bitrate);
            return;
        case Command::bitrate:
            return next_setup(address_.answers ? Command::auto_poll : Command::open);
        case Command::auto_poll:
            return next_setup(Command::open);
        case Command::open:
            if (!address_.answers) return finish_setup(false, now);
            return next_setup(Command::first_flags);
        case Command::first_flags:
            return finish_setup(false, now);
        case Command::change_mode:
            if (--answers_due_ == 0 || !address_.answers) awaited_ = Command::none;
            return;
        case Command::flags:
            flags_due_ = never;
            awaited_ = Command::none;
            return;
        case Command::transmit:
            return end_transmission(true, now);
    }
}

void SlcanController::on_refused(TimePoint now) {
    switch (awaited_) {
        case Command::bitrate:
            return lose("the adapter at " + address_.device + " has no bit rate of " +
                            std::to_string(address_.bitrate) + " bit/s",
                        now);
        case Command::open:
            return lose(refused_to_open(), now);
        case Command::change_mode:
            if (answers_due_ == 1) return lose(refused_to_open(), now);
            return on_done(now);
        case Command::flags:
            return lose("the adapter at " + address_.device +
                            " has closed its channel: was it without power?",
                        now);
        case Command::transmit:
            return end_transmission(false, now);
        default:
            return on_done(now);
    }
}

std::optional<ControllerEvent> SlcanController::on_flags(std::uint8_t bits, TimePoint now) {
    if (awaited_ == Command::first_flags) finish_setup(true, now);  // they are of the past
    if (awaited_ != Command::flags) return std::nullopt;
    awaited_ = Command::none;
    last_flags_ = now;
    flags_due_ = now + flags_interval;
    if (!is_up()) return std::nullopt;
    ErrorStatus status = status_;
    status.state = (bits & slcan::Flags::error_passive) != 0 ? ControllerState::error_passive
                                                             : ControllerState::error_active;
    change_state(status, now);
    if ((bits & (slcan::Flags::receive_fifo_full | slcan::Flags::data_overrun)) == 0) {
        return std::nullopt;
    }
    return FramesLost{1, now};
}

void SlcanController::on_version(TimePoint now) {
    if (awaited_ != Command::greeting) return;
    if (greetings_left_ == greetings - 1) return next_setup(Command::bitrate);
    awaited_ = Command::settling;
    answer_by_ = now + settling_time;
}

void SlcanController::check_answer(TimePoint now) {
    if (awaited_ == Command::none || now < answer_by_) return;
    if (awaited_ == Command::settling) return next_setup(Command::bitrate);
    if (awaited_ != Command::greeting) {
        return lose(
            "the adapter at " + address_.device + " does not answer any more; it is tried again",
            now);
    }
    if (greetings_left_ > 0) return next_setup(Command::greeting);
    lose("nothing at " + address_.device +
             " answers like a LAWICEL adapter: is it another port, or another baud=? A peer "
             "that does not answer as an adapter does takes answers=no",
         now);
}

std::optional<ControllerEvent> SlcanController::next_event(TimePoint now) {
    for (int pieces = 0; pieces < pieces_per_poll; ++pieces) {
        while (!input_.empty() && own_events_.empty()) {
            const auto message = receiver_.add(input_.front());
            input_ = input_.subspan(1);
            if (!message) continue;
            if (auto event = understand(*message, now)) return event;
        }
        if (!own_events_.empty() || !port_.is_open()) break;
        const auto count = port_.read(input_buffer_);
        if (count && *count == 0) {
            check_answer(now);
            break;
        }
        if (count) {
            input_ = std::span{input_buffer_}.first(*count);
            input_time_ = now;
        } else {
            lose(gone(), now);
        }
    }
    return own_events_.pop();
}

std::optional<ControllerEvent> SlcanController::understand(const slcan::Message& message,
                                                           TimePoint now) {
    if (const auto* frame = std::get_if<Frame>(&message)) {
        const auto accepts = [&](const Filter& filter) { return filter.accepts(*frame); };
        if (!is_up() || std::none_of(filters_.begin(), filters_.end(), accepts)) {
            return std::nullopt;
        }
        return Received{*frame, input_time_};
    }
    if (const auto* status = std::get_if<ErrorStatus>(&message)) {
        if (status_.state != ControllerState::stopped) change_state(*status, now);
        return std::nullopt;
    }
    const auto* refusal = std::get_if<slcan::Refused>(&message);
    if (address_.answers) {
        if (std::holds_alternative<slcan::Done>(message)) on_done(now);
        if (std::holds_alternative<slcan::Version>(message)) on_version(now);
        if (const auto* flags = std::get_if<slcan::Flags>(&message)) {
            return on_flags(flags->bits, now);
        }
        if (refusal != nullptr) on_refused(now);
    }
    const bool lost = std::holds_alternative<slcan::Malformed>(message) ||
                      (refusal != nullptr && refusal->cut_line);
    if (!lost || !is_up()) return std::nullopt;
    return FramesLost{1, input_time_};
}

void SlcanController::set_timer() {
    TimePoint due = never;
    if (!port_.is_open()) {
        due = reopen_at_;
    } else if (awaited_ != Command::none) {
        due = answer_by_;
    } else if (is_up()) {
        due = flags_due_;
        if (mailboxes_.waits()) due = std::min(due, retry_at_);
    }
    if (due >= timer_due_) return;
    timer_due_ = due;
    timer_.set_at(due);
}

void SlcanController::update_signal() {
    const bool wanted = !own_events_.empty() || !input_.empty();
    if (wanted == signalled_) return;
    signalled_ = wanted;
    if (wanted) {
        own_signal_.raise();
    } else {
        own_signal_.clear();
    }
}

std::string SlcanController::gone() const {
    return address_.device + " is gone; plug the adapter in again";
}

std::string SlcanController::refused_to_open() const {
    return "the adapter at " + address_.device + " refuses to open its channel" +
           (listen_only_ ? " for listening only" : "");
}

}  // namespace canorb::can
