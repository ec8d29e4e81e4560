#include "orb/can/link/socketcan_controller.hpp"

#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <linux/sock_diag.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "orb/can/link/link.hpp"
#include "orb/can/link/socketcan_frame.hpp"

namespace canorb::can {
namespace {

constexpr std::size_t mailboxes = 8;
constexpr std::size_t filter_list = 64;
/// CAN_RAW_FILTER_MAX is for both together.
constexpr std::size_t max_sent_ids = CAN_RAW_FILTER_MAX - filter_list;

/// More than the default, which holds some 270 frames. The kernel gives what rmem_max allows.
constexpr int receive_buffer = 1 << 20;

/// A full transmit queue of the interface wakes nobody when it has room again. Ten frames, the
/// usual length of that queue, take about as long.
constexpr Duration room_interval = std::chrono::milliseconds{1};

/// A frame that an error active controller has not confirmed after so long was dropped on the way:
/// drivers do so in one-shot mode, and when they are short of memory.
constexpr Duration confirmation_limit = std::chrono::seconds{5};
constexpr Duration watch_interval = std::chrono::seconds{1};

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

bool is_same(const can_frame& a, const can_frame& b) {
    return a.can_id == b.can_id && a.can_dlc == b.can_dlc &&
           std::memcmp(a.data, b.data, sizeof a.data) == 0;
}

void set_timer(const Descriptor& timer, Duration time) {
    itimerspec setting{};
    setting.it_value.tv_sec = static_cast<time_t>(time / std::chrono::seconds{1});
    setting.it_value.tv_nsec = static_cast<long>((time % std::chrono::seconds{1}).count());
    ::timerfd_settime(timer.get(), 0, &setting, nullptr);
}

void watch(const Descriptor& epoll, int fd) {
    epoll_event interest{};
    interest.events = EPOLLIN;
    interest.data.fd = fd;
    ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd, &interest);
}

std::string why_no_socket(int error) {
    switch (error) {
        case EAFNOSUPPORT:
            return "this kernel has no CAN; load it with: modprobe can-raw; without a CAN kernel "
                   "there are sim:PATH (canorb-bus) and slcan:TTY";
        case EPROTONOSUPPORT:
            return "this kernel has no raw CAN sockets; load them with: modprobe can-raw";
        case EPERM:
        case EACCES:
            return "this process may not open CAN sockets (" + error_text(error) +
                   "): look for a seccomp filter or a container that forbids them";
        default:
            return "no CAN socket: " + error_text(error);
    }
}

}  // namespace

SocketCanController::Batch::Batch() {
    for (std::size_t i = 0; i < batch_size; ++i) {
        vectors[i] = {&frames[i], sizeof frames[i]};
        headers[i].msg_hdr.msg_iov = &vectors[i];
        headers[i].msg_hdr.msg_iovlen = 1;
        headers[i].msg_hdr.msg_control = controls[i].octets.data();
    }
}

Result<std::unique_ptr<SocketCanController>, std::string> SocketCanController::open(
    std::string interface) {
    const std::string prefix = "socketcan:" + interface + ": ";
    // Before anything else: without CAN in the kernel there can be no interface either.
    if (!Descriptor{::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)}.is_open()) {
        return Failure{prefix + why_no_socket(errno)};
    }
    auto monitor = InterfaceMonitor::open(interface);
    if (!monitor) return Failure{prefix + "no netlink socket: " + error_text(monitor.error())};
    const InterfaceStatus& status = monitor->status();
    if (status.removed) {
        return Failure{prefix +
                       "there is no such network interface; ip link shows those there "
                       "are, and a virtual one is made with: ip link add dev " +
                       interface + " type vcan && ip link set " + interface + " up"};
    }
    if (!status.is_can) return Failure{prefix + "this network interface is none for CAN"};
    if (status.listen_only) {
        return Failure{prefix +
                       "the interface is in listen-only mode, so no node can work on it: "
                       "ip link set " +
                       interface + " down && ip link set " + interface +
                       " type can listen-only off && ip link set " + interface + " up"};
    }
    std::unique_ptr<SocketCanController> controller{
        new SocketCanController{std::move(interface), std::move(*monitor)}};
    if (!controller->epoll_.is_open() || !controller->timer_.is_open() ||
        !controller->own_signal_.is_open()) {
        return Failure{prefix + "no more file descriptors for a controller"};
    }
    if (const int error = controller->open_socket(); error != 0) {
        return Failure{prefix + why_no_socket(error)};
    }
    controller->follow_interface();
    // How it begins is asked for, not told.
    controller->told_state_ = controller->status_.state;
    controller->own_events_.clear();
    controller->signalled_ = false;
    controller->own_signal_.clear();
    return controller;
}

SocketCanController::SocketCanController(std::string name, InterfaceMonitor monitor)
    : name_(std::move(name)),
      monitor_(std::move(monitor)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {
    in_flight_.reserve(mailboxes);
    watch(epoll_, monitor_.fd());
    watch(epoll_, timer_.get());
    watch(epoll_, own_signal_.fd());
}

int SocketCanController::open_socket() {
    Descriptor socket{::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)};
    if (!socket.is_open()) return errno;
    socket_ = std::move(socket);
    dropped_ = 0;
    const int on = 1;
    // Without these two a time stamp is the moment of reading, and losses go unseen; nothing that
    // a kernel with CAN_RAW lacks.
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
    bound_to_ = monitor_.status().index;
    address.can_ifindex = bound_to_;
    confirms_ = monitor_.status().echoes;
    int error = set_option(socket_, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, confirms_ ? 1 : 0);
    if (error == 0) error = set_option(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, wanted_errors);
    if (error == 0) error = apply_filters();
    if (error == 0 &&
        ::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        error = errno;
    }
    if (error != 0) {
        socket_.reset();
        return error;
    }
    watch(epoll_, socket_.get());
    return 0;
}

// ---- sending

Capabilities SocketCanController::capabilities() const {
    const std::lock_guard lock{mutex_};
    Capabilities capabilities;
    capabilities.mailboxes = mailboxes;
    capabilities.filter_list = filter_list;
    capabilities.bitrate = monitor_.status().bitrate;
    capabilities.fifo = true;
    return capabilities;
}

SendResult SocketCanController::send(const Frame& frame, SendOptions options) {
    const std::lock_guard lock{mutex_};
    if (frame.fd || frame.error || frame.length > Frame::max_classic_payload || options.one_shot ||
        frame.id > (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK)) {
        return SendError::unsupported;
    }
    if (status_.state == ControllerState::stopped) return SendError::stopped;
    if (status_.state == ControllerState::bus_off) return SendError::bus_off;
    if (in_flight_.size() + results_ >= mailboxes) return SendError::full;
    const can_frame out = to_socketcan(frame);
    if (confirms_) expect_own(out.can_id);
    if (::write(socket_.get(), &out, sizeof out) != sizeof out) {
        const int error = errno;
        if (error != ENETDOWN && error != ENODEV && error != ENXIO) {
            // ENOBUFS: the interface's transmit queue is full, with other programs' frames perhaps.
            wait_for_room();
            return SendError::full;
        }
        lose_socket(error);
        return SendError::stopped;
    }
    const TransmitHandle handle{next_handle_++};
    const TimePoint now = monotonic_now();
    if (confirms_) {
        in_flight_.push_back({handle, out, now});
        watch_in_flight();
    } else {
        own_events_.push_back(TransmitResult{handle, TransmitOutcome::sent, now});
        ++results_;
        // Unless losses behind the last frame are still to be looked for.
        drained_ = !overflow_possible_;
    }
    return handle;
}

void SocketCanController::wait_for_room() {
    if (waiting_for_room_) return;
    waiting_for_room_ = true;
    set_timer(timer_, room_interval);
}

// The timer runs on between two transmissions: to set it for each would cost a system call.
void SocketCanController::watch_in_flight() {
    if (watching_ || waiting_for_room_ || in_flight_.empty()) return;
    watching_ = true;
    set_timer(timer_, watch_interval);
}

void SocketCanController::on_timer() {
    std::uint64_t expirations = 0;
    if (::read(timer_.get(), &expirations, sizeof expirations) <= 0) return;
    waiting_for_room_ = false;
    watching_ = false;
    if (!socket_.is_open()) follow_interface();
    // Otherwise it may wait for an acknowledgement, however long.
    if (status_.state == ControllerState::error_active) {
        const TimePoint now = monotonic_now();
        std::erase_if(in_flight_, [&](const InFlight& transmission) {
            if (now - transmission.sent < confirmation_limit) return false;
            tell(TransmitResult{transmission.handle, TransmitOutcome::failed, now});
            return true;
        });
    }
    watch_in_flight();
}

// ---- filters

bool SocketCanController::set_filters(std::span<const Filter> filters) {
    const std::lock_guard lock{mutex_};
    if (filters.size() > filter_list) return false;
    filters_.assign(filters.begin(), filters.end());
    sent_ids_.clear();
    for (const InFlight& transmission : in_flight_) sent_ids_.push_back(transmission.frame.can_id);
    apply_filters();
    return true;
}

int SocketCanController::apply_filters() {
    if (!socket_.is_open()) return 0;
    std::vector<can_filter> list;
    list.reserve(filters_.size() + sent_ids_.size());
    for (const Filter& filter : filters_) list.push_back(to_socketcan(filter));
    for (const std::uint32_t id : sent_ids_) {
        const std::uint32_t bits = (id & CAN_EFF_FLAG) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK;
        list.push_back({id, bits | CAN_EFF_FLAG | CAN_RTR_FLAG});
    }
    // An empty list, which passes nothing, has no octets.
    return ::setsockopt(socket_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, list.data(),
                        static_cast<socklen_t>(list.size() * sizeof(can_filter))) == 0
               ? 0
               : errno;
}

bool SocketCanController::passes(const Frame& frame) const {
    return std::any_of(filters_.begin(), filters_.end(),
                       [&](const Filter& filter) { return filter.accepts(frame); });
}

void SocketCanController::expect_own(std::uint32_t can_id) {
    if (std::find(sent_ids_.begin(), sent_ids_.end(), can_id) != sent_ids_.end()) return;
    can_frame probe{};
    probe.can_id = can_id;
    if (passes(from_socketcan(probe))) return;
    if (sent_ids_.size() >= max_sent_ids) {
        sent_ids_.clear();
        for (const InFlight& waiting : in_flight_) sent_ids_.push_back(waiting.frame.can_id);
    }
    sent_ids_.push_back(can_id);
    apply_filters();
}

// ---- receiving

std::optional<ControllerEvent> SocketCanController::poll() {
    const std::lock_guard lock{mutex_};
    for (;;) {
        if (!own_events_.empty()) {
            ControllerEvent event = own_events_.front();
            own_events_.pop_front();
            if (std::holds_alternative<TransmitResult>(event)) --results_;
            if (const auto* change = std::get_if<StateChanged>(&event)) {
                told_state_ = change->status.state;
            }
            if (own_events_.empty() && signalled_) {
                signalled_ = false;
                own_signal_.clear();
            }
            return event;
        }
        if (next_ < received_) {
            if (auto event = understand(batch_.headers[next_], batch_.frames[next_])) return event;
        } else if (drained_) {
            // What came since then keeps the descriptor readable: no need to ask again.
            drained_ = false;
            return std::nullopt;
        } else {
            receive();
        }
    }
}

void SocketCanController::receive() {
    received_ = 0;
    next_ = 0;
    int count = -1;
    if (socket_.is_open()) {
        for (mmsghdr& header : batch_.headers) {
            header.msg_hdr.msg_controllen = sizeof(Batch::Control);
        }
        do {
            count = ::recvmmsg(socket_.get(), batch_.headers.data(), batch_size, 0, nullptr);
        } while (count < 0 && errno == EINTR);
        if (count < 0 && errno != EAGAIN) lose_socket(errno);
    }
    present_ = look_at_clocks();
    if (count > 0) {
        received_ = static_cast<std::size_t>(count);
        overflow_possible_ = overflow_possible_ || received_ == batch_size;
        // To look once more tells of losses behind the last frame.
        drained_ = !overflow_possible_;
        return;
    }
    drained_ = true;
    if (overflow_possible_) find_losses_at_end();
    // No frame, so that it may be one of the others that woke the reader.
    std::array<epoll_event, 4> ready{};
    const int others = ::epoll_wait(epoll_.get(), ready.data(), ready.size(), 0);
    for (int i = 0; i < others; ++i) {
        if (ready[static_cast<std::size_t>(i)].data.fd == monitor_.fd()) follow_interface();
        if (ready[static_cast<std::size_t>(i)].data.fd == timer_.get()) on_timer();
    }
}

// The count of losses comes with the next frame, and there may be none.
void SocketCanController::find_losses_at_end() {
    overflow_possible_ = false;
    std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
    socklen_t size = sizeof memory;
    if (socket_.is_open() &&
        ::getsockopt(socket_.get(), SOL_SOCKET, SO_MEMINFO, memory.data(), &size) == 0) {
        if (const auto lost = note_dropped(memory[SK_MEMINFO_DROPS])) tell(*lost);
    }
}

std::optional<ControllerEvent> SocketCanController::understand(const mmsghdr& header,
                                                               const can_frame& frame) {
    const Stamps stamps = stamps_of(header.msg_hdr);
    if (stamps.dropped) {
        // The same frame is looked at again after that.
        if (const auto lost = note_dropped(*stamps.dropped)) return *lost;
    }
    ++next_;
    const TimePoint time = clock_.time_of(stamps.software, stamps.hardware, present_);
    if ((frame.can_id & CAN_ERR_FLAG) != 0) {
        take_error(frame, time);
        return std::nullopt;
    }
    if ((header.msg_hdr.msg_flags & MSG_CONFIRM) != 0) return confirm(frame, time);
    const Received received{from_socketcan(frame), time};
    if (!sent_ids_.empty() && !passes(received.frame)) return std::nullopt;
    return received;
}

SocketCanController::Stamps SocketCanController::stamps_of(const msghdr& message) {
    Stamps stamps;
    msghdr copy = message;  // CMSG_NXTHDR wants one that is not const
    for (cmsghdr* control = CMSG_FIRSTHDR(&copy); control != nullptr;
         control = CMSG_NXTHDR(&copy, control)) {
        if (control->cmsg_level != SOL_SOCKET) continue;
        if (control->cmsg_type == SO_TIMESTAMPING) {
            scm_timestamping times{};
            std::memcpy(&times, CMSG_DATA(control), sizeof times);
            // Zero is "none".
            if (const auto time = to_duration(times.ts[0]); time != Duration::zero()) {
                stamps.software = time;
            }
            if (const auto time = to_duration(times.ts[2]); time != Duration::zero()) {
                stamps.hardware = time;
            }
        } else if (control->cmsg_type == SO_RXQ_OVFL) {
            std::uint32_t dropped = 0;
            std::memcpy(&dropped, CMSG_DATA(control), sizeof dropped);
            stamps.dropped = dropped;
        }
    }
    return stamps;
}

std::optional<FramesLost> SocketCanController::note_dropped(std::uint32_t dropped) {
    const std::uint32_t more = dropped - dropped_;  // it wraps around
    if (more == 0) return std::nullopt;
    dropped_ = dropped;
    return FramesLost{more, present_.now};
}

std::optional<ControllerEvent> SocketCanController::confirm(const can_frame& frame,
                                                            TimePoint time) {
    // By its content: a queueing discipline may have changed the order.
    const auto found = std::find_if(
        in_flight_.begin(), in_flight_.end(),
        [&](const InFlight& transmission) { return is_same(transmission.frame, frame); });
    if (found == in_flight_.end()) return std::nullopt;
    const TransmitResult result{found->handle, TransmitOutcome::sent, time};
    in_flight_.erase(found);
    return result;
}

void SocketCanController::take_error(const can_frame& frame, TimePoint time) {
    const ErrorReport report = parse_error(frame);
    if (report.receive_overflow) tell(FramesLost{1, time});
    if (report.transmit_timeout) fail_in_flight();
    if (status_.state == ControllerState::stopped) return;  // it came before that
    if (status_.state == ControllerState::bus_off && report.state && monitor_.status().errors) {
        monitor_.refresh();  // it is back when the interface is running again
        return;
    }
    ErrorStatus status = status_;
    if (report.tec) status.tec = *report.tec;
    if (report.rec) status.rec = *report.rec;
    if (report.state) status.state = *report.state;
    enter_state(status);
}

// ---- the interface

void SocketCanController::follow_interface() {
    monitor_.update();
    const InterfaceStatus& interface = monitor_.status();
    if (!interface.up || interface.index != bound_to_) {
        enter_state({.state = ControllerState::stopped});
        if (interface.removed || interface.index != bound_to_) socket_.reset();
    }
    carrier_lost_ = interface.up && !interface.running && (carrier_lost_ || !interface.carrier);
    if (!interface.up) return;
    if (!socket_.is_open() && open_socket() != 0) {
        set_timer(timer_, watch_interval);  // to try again
        return;
    }
    ErrorStatus status = status_;
    if (interface.errors) {
        status = *interface.errors;
    } else if (status.state == ControllerState::stopped) {
        status = ErrorStatus{};
    }
    if (carrier_lost_ && status.state != ControllerState::bus_off) {
        status.state = status_.state == ControllerState::bus_off ? ControllerState::bus_off
                                                                 : ControllerState::stopped;
    }
    enter_state(status);
}

void SocketCanController::lose_socket(int error) {
    enter_state({.state = ControllerState::stopped});
    // One whose interface is only down stays bound to it.
    if (error != ENETDOWN) socket_.reset();
    // It may be up again by now, and the news of that have been read.
    monitor_.refresh();
}

void SocketCanController::enter_state(ErrorStatus status) {
    const bool changed = status.state != status_.state;
    status_ = status;
    if (!changed) return;
    tell(StateChanged{status, monotonic_now()});
    if (status.state == ControllerState::stopped || status.state == ControllerState::bus_off) {
        fail_in_flight();
    }
}

void SocketCanController::fail_in_flight() {
    const TimePoint now = monotonic_now();
    for (const InFlight& transmission : in_flight_) {
        tell(TransmitResult{transmission.handle, TransmitOutcome::failed, now});
    }
    in_flight_.clear();
}

void SocketCanController::tell(const ControllerEvent& event) {
    own_events_.push_back(event);
    if (std::holds_alternative<TransmitResult>(event)) ++results_;
    signalled_ = true;
    own_signal_.raise();
}

ErrorStatus SocketCanController::error_status() const {
    const std::lock_guard lock{mutex_};
    // Not ahead of the events: who has not taken them yet is not in the new state.
    ErrorStatus status = status_;
    status.state = told_state_;
    return status;
}

std::optional<std::string> SocketCanController::recover() {
    const std::lock_guard lock{mutex_};
    // A stopped one comes back with its interface.
    if (status_.state != ControllerState::bus_off) return std::nullopt;
    const InterfaceStatus& interface = monitor_.status();
    if (!interface.errors) {
        enter_state(ErrorStatus{});  // a virtual interface has nothing to restart
        return std::nullopt;
    }
    if (interface.restarts_itself) return std::nullopt;
    const int error = restart_interface(interface.index);
    // EBUSY: it is not bus-off any more, and the answer to this tells.
    monitor_.refresh();
    if (error == 0 || error == EBUSY) return std::nullopt;
    return name_ + " cannot be restarted (" + error_text(error) + "): it takes CAP_NET_ADMIN, or " +
           by_hand();
}

std::string SocketCanController::by_hand() const {
    return "ip link set " + name_ + " type can restart; ip link set " + name_ +
           " type can restart-ms 100 makes it restart by itself";
}

std::string SocketCanController::explanation() const {
    const std::lock_guard lock{mutex_};
    const InterfaceStatus& interface = monitor_.status();
    switch (status_.state) {
        case ControllerState::stopped:
            if (interface.removed) return "there is no interface " + name_ + " any more";
            if (!interface.up) return name_ + " is down: ip link set " + name_ + " up";
            if (carrier_lost_) return name_ + " has no carrier: is its other end up?";
            return {};
        case ControllerState::bus_off:
            if (!interface.errors) return {};
            if (interface.restarts_itself) return name_ + " restarts by itself";
            return name_ + " does not restart by itself: " + by_hand();
        default:
            return {};
    }
}

}  // namespace canorb::can
