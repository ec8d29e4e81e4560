#include "orb/can/link/socketcan_controller.hpp"

#include <linux/can/raw.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "orb/can/link/link.hpp"
#include "orb/can/link/socketcan_frame.hpp"

namespace canorb::can {
namespace {

constexpr std::size_t mailboxes = 8;
constexpr std::size_t filter_list = 64;
constexpr std::size_t max_sent_ids = CAN_RAW_FILTER_MAX;

/// A full transmit queue of the interface wakes nobody when it has room again. Ten frames, the
/// usual length of that queue, take about as long.
constexpr Duration room_interval = std::chrono::milliseconds{1};

/// A frame that an error active controller has not confirmed after so long was dropped on the way:
/// drivers do so in one-shot mode, and when they are short of memory.
constexpr Duration confirmation_limit = std::chrono::seconds{5};
constexpr Duration watch_interval = std::chrono::seconds{1};

bool is_same(const can_frame& a, const can_frame& b) {
    return a.can_id == b.can_id && a.can_dlc == b.can_dlc &&
           std::memcmp(a.data, b.data, sizeof a.data) == 0;
}

std::string why_no_socket(int error) {
    switch (error) {
        case EAFNOSUPPORT:
            return "this kernel has no CAN; load it with: modprobe can-raw; without a CAN kernel "
                   "there are sim:PATH (canorb-bus) and slcan:DEVICE";
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
    if (const int error = controller->open_sockets(); error != 0) {
        return Failure{prefix + why_no_socket(error)};
    }
    controller->follow_interface();
    // How it begins is asked for, not told.
    controller->told_state_ = controller->status_.state;
    controller->own_events_.clear();
    controller->own_signal_.clear();
    return controller;
}

SocketCanController::SocketCanController(std::string name, InterfaceMonitor monitor)
    : name_(std::move(name)), monitor_(std::move(monitor)), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
    in_flight_.reserve(mailboxes);
    watch(epoll_, monitor_.fd());
    watch(epoll_, timer_.fd());
    watch(epoll_, own_signal_.fd());
}

int SocketCanController::open_sockets() {
    const int error = try_to_open_sockets();
    if (error != 0) close_sockets();
    return error;
}

int SocketCanController::try_to_open_sockets() {
    bound_to_ = monitor_.status().index;
    echoes_ = monitor_.status().echoes;
    sent_ids_.clear();
    if (const int error = socket_.open(bound_to_); error != 0) return error;
    if (const int error = watcher_.open(bound_to_); error != 0) return error;
    if (const int error = watcher_.set_error_filter(wanted_errors); error != 0) return error;
    apply_filters();
    watch(epoll_, socket_.fd());
    watch(epoll_, watcher_.fd());
    return 0;
}

void SocketCanController::close_sockets() {
    socket_.close();
    watcher_.close();
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
    if (!is_classic(frame) || options.one_shot) return SendError::unsupported;
    if (status_.state == ControllerState::stopped) return SendError::stopped;
    if (status_.state == ControllerState::bus_off) return SendError::bus_off;
    if (in_flight_.size() >= mailboxes) return SendError::full;
    const can_frame out = to_socketcan(frame);
    if (echoes_) expect_echo(out.can_id);
    const int error = socket_.send(out);
    if (error == ENETDOWN || error == ENODEV || error == ENXIO) {
        lose_interface(error);
        return SendError::stopped;
    }
    if (error != 0) {
        // ENOBUFS: the interface's transmit queue is full, with other programs' frames perhaps.
        wait_for_room();
        return SendError::full;
    }
    const TransmitHandle handle{next_handle_++};
    const TimePoint now = monotonic_now();
    if (!echoes_) return TransmitResult{handle, TransmitOutcome::sent, now};
    in_flight_.push_back({handle, out, now});
    watch_in_flight();
    return handle;
}

void SocketCanController::wait_for_room() {
    if (waiting_for_room_) return;
    waiting_for_room_ = true;
    timer_.set_after(room_interval);
}

// The timer runs on between two transmissions: to set it for each would cost a system call.
void SocketCanController::watch_in_flight() {
    if (watching_ || waiting_for_room_ || in_flight_.empty()) return;
    watching_ = true;
    timer_.set_after(watch_interval);
}

void SocketCanController::on_timer() {
    if (!timer_.take_expiry()) return;
    waiting_for_room_ = false;
    watching_ = false;
    if (!socket_.is_open()) {
        monitor_.refresh();
        follow_interface();
    }
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
    if (socket_.is_open()) apply_filters();
    return true;
}

void SocketCanController::apply_filters() const {
    std::vector<can_filter> list;
    list.reserve(filters_.size());
    for (const Filter& filter : filters_) list.push_back(to_socketcan(filter));
    // It fails only for want of memory, as far as can be known here.
    [[maybe_unused]] const int error = socket_.set_filters(list);
}

void SocketCanController::expect_echo(std::uint32_t can_id) {
    if (std::find(sent_ids_.begin(), sent_ids_.end(), can_id) != sent_ids_.end()) return;
    if (sent_ids_.size() == max_sent_ids) {
        sent_ids_.clear();
        for (const InFlight& waiting : in_flight_) sent_ids_.push_back(waiting.frame.can_id);
    }
    sent_ids_.push_back(can_id);
    std::vector<can_filter> list;
    list.reserve(sent_ids_.size());
    for (const std::uint32_t id : sent_ids_) {
        const std::uint32_t bits = (id & CAN_EFF_FLAG) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK;
        list.push_back({id, bits | CAN_EFF_FLAG | CAN_RTR_FLAG});
    }
    [[maybe_unused]] const int error = watcher_.set_filters(list);
}

// ---- receiving

std::optional<ControllerEvent> SocketCanController::poll() {
    const std::lock_guard lock{mutex_};
    for (;;) {
        if (!own_events_.empty()) {
            ControllerEvent event = own_events_.front();
            own_events_.pop_front();
            if (own_events_.empty()) own_signal_.clear();
            if (const auto* change = std::get_if<StateChanged>(&event)) {
                told_state_ = change->status.state;
            }
            return event;
        }
        // A confirmation before the reply that it made possible.
        if (auto event = next_from_watcher()) return event;
        if (!own_events_.empty()) continue;
        if (auto event = next_from_socket()) return event;
        if (!own_events_.empty()) continue;
        if (drained_) {
            // What came since then keeps the descriptor readable: no need to ask again.
            drained_ = false;
            return std::nullopt;
        }
        ask_kernel();
    }
}

void SocketCanController::ask_kernel() {
    const bool watcher_asked = socket_.is_open() && (!in_flight_.empty() || overflow_possible_);
    if (watcher_asked) watcher_.receive();
    const int error = socket_.is_open() ? socket_.receive() : EAGAIN;
    if (error == 0) {
        overflow_possible_ = overflow_possible_ || socket_.was_full();
        // To look once more tells of losses behind the last frame.
        drained_ = !overflow_possible_;
        return;
    }
    if (error != EAGAIN) lose_interface(error);
    drained_ = true;
    if (overflow_possible_ && socket_.is_open()) {
        overflow_possible_ = false;
        if (const auto lost = socket_.find_losses(); lost > 0) {
            tell(FramesLost{lost, monotonic_now()});
        }
    }
    // No frame, so that it may be one of the others that woke the reader.
    std::array<epoll_event, 5> ready{};
    const int others = ::epoll_wait(epoll_.get(), ready.data(), ready.size(), 0);
    for (int i = 0; i < others; ++i) {
        const int fd = ready[static_cast<std::size_t>(i)].data.fd;
        if (fd == timer_.fd()) {
            on_timer();
        } else if (fd == monitor_.fd()) {
            if (monitor_.update()) follow_interface();
        } else if (fd == watcher_.fd() && !watcher_asked) {
            const int trouble = watcher_.receive();
            if (trouble != 0 && trouble != EAGAIN) lose_interface(trouble);
        }
    }
}

std::optional<ControllerEvent> SocketCanController::next_from_watcher() {
    while (const auto arrival = watcher_.next()) {
        if ((arrival->frame.can_id & CAN_ERR_FLAG) != 0) {
            take_error(arrival->frame);
            if (!own_events_.empty()) return std::nullopt;
        } else if (auto result = confirm(*arrival)) {
            return result;
        }
    }
    return std::nullopt;
}

std::optional<ControllerEvent> SocketCanController::next_from_socket() {
    const auto arrival = socket_.next();
    if (!arrival) return std::nullopt;
    const Received received{from_socketcan(arrival->frame), arrival->time};
    if (arrival->lost_before == 0) return received;
    tell(FramesLost{arrival->lost_before, arrival->time});
    tell(received);
    return std::nullopt;
}

std::optional<ControllerEvent> SocketCanController::confirm(const CanSocket::Arrival& arrival) {
    if (!arrival.from_this_host) return std::nullopt;
    // By its content: a queueing discipline may have changed the order.
    const auto found = std::find_if(
        in_flight_.begin(), in_flight_.end(),
        [&](const InFlight& transmission) { return is_same(transmission.frame, arrival.frame); });
    if (found == in_flight_.end()) return std::nullopt;
    const TransmitResult result{found->handle, TransmitOutcome::sent, arrival.time};
    in_flight_.erase(found);
    return result;
}

void SocketCanController::take_error(const can_frame& frame) {
    const ErrorReport report = parse_error(frame);
    if (report.receive_overflow) tell(FramesLost{1, monotonic_now()});
    if (report.transmit_timeout) fail_in_flight();
    if (status_.state == ControllerState::stopped) return;  // it came before that
    if (status_.state == ControllerState::bus_off && report.state && monitor_.status().errors) {
        monitor_.refresh();  // it is back when the interface is running again
        follow_interface();
        return;
    }
    ErrorStatus status = status_;
    if (report.tec) status.tec = *report.tec;
    if (report.rec) status.rec = *report.rec;
    if (report.state) status.state = *report.state;
    enter_state(status);
    // Nobody sees its error flag, so nobody repeats what it alone could not read. Told where the
    // interface reports bus errors (berr-reporting on).
    if (report.receive_error && status_.state == ControllerState::error_passive) {
        tell(FramesLost{0, monotonic_now()});
    }
}

// ---- the interface

void SocketCanController::follow_interface() {
    const InterfaceStatus& interface = monitor_.status();
    const bool replaced = interface.index != bound_to_;
    if (!interface.up || replaced) {
        enter_state({.state = ControllerState::stopped});
        if (interface.removed || replaced) close_sockets();
    }
    carrier_lost_ = interface.up && !interface.running && (carrier_lost_ || !interface.carrier);
    if (!interface.up) return;
    if (!socket_.is_open() && open_sockets() != 0) {
        timer_.set_after(watch_interval);  // to try again
        return;
    }
    ErrorStatus status = status_;
    if (interface.errors) {
        status = *interface.errors;
    } else if (status.state == ControllerState::stopped) {
        status = ErrorStatus{};
    }
    if (interface.listen_only) {
        status = {.state = ControllerState::stopped};
    } else if (carrier_lost_ && status.state != ControllerState::bus_off) {
        status.state = status_.state == ControllerState::bus_off ? ControllerState::bus_off
                                                                 : ControllerState::stopped;
    }
    enter_state(status);
}

void SocketCanController::lose_interface(int error) {
    enter_state({.state = ControllerState::stopped});
    // Sockets whose interface is only down stay bound to it. Both are told so.
    if (error == ENETDOWN) {
        socket_.forget_error();
        watcher_.forget_error();
    } else {
        close_sockets();
    }
    // It may be up again by now, and the news of that have been read.
    monitor_.refresh();
    follow_interface();
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
    // EBUSY: it is not bus-off any more; EINVAL: it restarts by itself now.
    monitor_.refresh();
    follow_interface();
    if (error == 0 || error == EBUSY || error == EINVAL) return std::nullopt;
    const std::string failure = name_ + " cannot be restarted (" + error_text(error) + ")";
    if (error != EPERM) return failure;
    return failure + ": it takes CAP_NET_ADMIN, or " + by_hand();
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
            if (interface.removed) {
                return "there is no interface " + name_ +
                       " any more; as soon as there is one, this node goes on";
            }
            if (!interface.up) {
                return name_ + " is down: ip link set " + name_ + " up, and this node goes on";
            }
            if (interface.listen_only) return name_ + " is in listen-only mode";
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
