#include "orb/can/link/sim_link.hpp"

#include <poll.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <mutex>
#include <vector>

#include "orb/can/link/descriptor.hpp"
#include "orb/can/link/sim_socket.hpp"
#include "orb/can/sim/event_queue.hpp"
#include "orb/can/sim/protocol.hpp"

namespace canorb::can {
namespace {

constexpr int answer_timeout_ms = 5000;
constexpr Duration reconnect_interval = std::chrono::milliseconds{100};

std::string no_bus(const std::string& path, int error) {
    return "no bus at sim:" + path + " (" + error_text(error) +
           "): start one with: canorb-bus --listen sim:" + path;
}

/// A connection whose hello was answered.
struct Admission {
    Descriptor socket;
    sim::Welcome welcome;
};

bool is_absent(int error) {
    return error == ENOENT || error == ECONNREFUSED;
}

std::optional<sim::ServerPacket> receive_server_packet(const Descriptor& socket,
                                                       ReceiveOutcome& outcome) {
    std::array<std::uint8_t, sim::max_packet_size> buffer;
    std::size_t size = 0;
    outcome = receive_packet(socket, buffer, size);
    if (outcome != ReceiveOutcome::packet || size > buffer.size()) return std::nullopt;
    return sim::parse_server_packet(Bytes{buffer.data(), size});
}

std::string the_bus_at(const std::string& path) {
    return "the bus at sim:" + path;
}

/// Blocks until the daemon at `path` says something. Nothing when it is none of its packets.
Result<std::optional<sim::ServerPacket>, std::string> await_packet(const Descriptor& socket,
                                                                   const std::string& path) {
    pollfd readable{socket.get(), POLLIN, 0};
    int ready = 0;
    do {
        ready = ::poll(&readable, 1, answer_timeout_ms);
    } while (ready < 0 && errno == EINTR);
    if (ready <= 0) return Failure{the_bus_at(path) + " does not answer"};
    ReceiveOutcome outcome{};
    auto packet = receive_server_packet(socket, outcome);
    if (outcome != ReceiveOutcome::packet) {
        return Failure{the_bus_at(path) + " closed the connection"};
    }
    return packet;
}

/// Blocks until the daemon at `path` has answered.
Result<Admission, std::string> ask(Descriptor socket, const std::string& path,
                                   const sim::Hello& hello) {
    const std::string who = the_bus_at(path);
    // A daemon that refuses may have closed already: its reason is there to read all the same.
    send_packet(socket, sim::encode(hello));
    const auto answered = await_packet(socket, path);
    if (!answered) return Failure{answered.error()};
    if (const auto& answer = *answered) {
        if (const auto* refusal = std::get_if<sim::Refusal>(&*answer)) {
            return Failure{who + " refused: " + refusal->reason};
        }
        if (const auto* welcome = std::get_if<sim::Welcome>(&*answer)) {
            return Admission{std::move(socket), *welcome};
        }
    }
    return Failure{who + " answered with something that is no welcome"};
}

Result<Admission, std::string> ask(const std::string& path, const sim::Hello& hello) {
    auto socket = connect_to_bus(path);
    if (!socket) return Failure{no_bus(path, socket.error())};
    return ask(std::move(*socket), path, hello);
}

/// Invariants, all under the mutex:
/// * The epoll descriptor, which is what users wait for, holds the socket while there is one, the
///   timer, and the signal, which is raised while `own_events_` has any.
/// * `transmissions_` has each send() until poll() returned its result.
class SimController final : public Controller {
  public:
    SimController(SimAddress address, std::string name, Admission admission)
        : path_(std::move(address.path)),
          name_(std::move(name)),
          own_events_(0),
          epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
        if (!is_open()) return;
        watch(epoll_, own_signal_.fd());
        watch(epoll_, timer_.fd());
        take_socket(std::move(admission.socket));
        enter(admission.welcome);
        own_events_.pop();  // the news that it is up is for reconnections
        own_signal_.clear();
    }

    bool is_open() const { return epoll_.is_open() && timer_.is_open() && own_signal_.is_open(); }

    Capabilities capabilities() const override {
        const std::lock_guard lock{mutex_};
        return capabilities_;
    }

    [[nodiscard]] SendResult send(const Frame& frame, SendOptions options) override {
        const std::lock_guard lock{mutex_};
        if (!is_classic(frame) || listen_only_) return SendError::unsupported;
        if (status_.state == ControllerState::stopped) return SendError::stopped;
        if (status_.state == ControllerState::bus_off) return SendError::bus_off;
        if (transmissions_.size() >= capabilities_.mailboxes || !flush()) return SendError::full;
        const TransmitHandle handle{next_handle_};
        switch (send_packet(
            socket_, sim::encode(sim::SendRequest{monotonic_now(), handle, options, frame}))) {
            case SendOutcome::sent:
                break;
            case SendOutcome::would_block:
                await_room(true);  // its event says when to try again
                return SendError::full;
            case SendOutcome::gone:
                return SendError::stopped;  // poll() will find out and tell
        }
        ++next_handle_;
        transmissions_.push_back({handle, false});
        return handle;
    }

    void abort(TransmitHandle handle) override {
        const std::lock_guard lock{mutex_};
        for (Transmission& transmission : transmissions_) {
            if (transmission.handle == handle) transmission.abort_unsent = true;
        }
        flush();
    }

    [[nodiscard]] bool set_filters(std::span<const Filter> filters) override {
        const std::lock_guard lock{mutex_};
        if (filters.size() > capabilities_.filter_list) return false;
        filters_.assign(filters.begin(), filters.end());
        filters_unsent_ = true;
        flush();
        return true;
    }

    [[nodiscard]] bool set_listen_only(bool on) override {
        const std::lock_guard lock{mutex_};
        listen_only_ = on;
        listen_only_unsent_ = true;
        flush();
        return true;
    }

    ErrorStatus error_status() const override {
        const std::lock_guard lock{mutex_};
        return status_;
    }

    std::optional<std::string> recover() override {
        const std::lock_guard lock{mutex_};
        if (status_.state == ControllerState::bus_off) {
            recover_unsent_ = true;
            flush();
        } else if (status_.state == ControllerState::stopped && !reconnecting_) {
            reconnecting_ = true;
            timer_.repeat(reconnect_interval);
            reconnect();
        }
        return std::nullopt;
    }

    std::optional<ControllerEvent> poll() override {
        const std::lock_guard lock{mutex_};
        if (reconnecting_ && timer_.take_expiry()) reconnect();
        flush();
        while (true) {
            if (auto event = own_events_.pop()) {
                if (own_events_.empty()) own_signal_.clear();
                note(*event);
                return event;
            }
            if (!socket_.is_open()) return std::nullopt;
            ReceiveOutcome outcome{};
            const auto packet = receive_server_packet(socket_, outcome);
            if (outcome == ReceiveOutcome::nothing) return std::nullopt;
            if (outcome == ReceiveOutcome::gone || !packet) {
                leave();
            } else if (auto event = understand(*packet)) {
                note(*event);
                return event;
            }
        }
    }

    int event_fd() const override { return epoll_.get(); }

  private:
    struct Transmission {
        TransmitHandle handle;
        bool abort_unsent;
    };

    void await_room(bool on) {
        if (on == writable_watched_) return;
        writable_watched_ = on;
        watch_writable(epoll_, socket_.get(), on);
    }

    void take_socket(Descriptor socket) {
        socket_ = std::move(socket);
        writable_watched_ = false;
        watch(epoll_, socket_.get());
    }

    void tell(const StateChanged& change) {
        own_events_.push(change);
        own_signal_.raise();
    }

    /// The daemon made a new controller for this client.
    void enter(const sim::Welcome& welcome) {
        capabilities_.mailboxes = welcome.mailboxes;
        capabilities_.filter_list =
            std::min<std::size_t>(welcome.filter_list, sim::max_packet_filters);
        capabilities_.bitrate = welcome.bitrate;
        capabilities_.one_shot = true;
        capabilities_.listen_only = true;
        status_ = ErrorStatus{};
        timer_.stop();
        reconnecting_ = false;
        filters_unsent_ = true;
        listen_only_unsent_ = true;
        recover_unsent_ = false;
        flush();
        tell(StateChanged{status_, monotonic_now()});
    }

    /// The daemon is gone, or not to be understood.
    void leave() {
        socket_.reset();  // which takes it out of the epoll set
        if (status_.state == ControllerState::stopped) return;  // it never was up
        status_ = ErrorStatus{.state = ControllerState::stopped};
        const TimePoint now = monotonic_now();
        tell(StateChanged{status_, now});
        for (const Transmission& transmission : transmissions_) {
            own_events_.push(TransmitResult{transmission.handle, TransmitOutcome::failed, now});
        }
    }

    void reconnect() {
        if (socket_.is_open()) return;  // the answer is on its way
        auto socket = connect_to_bus(path_);
        if (!socket) return;
        take_socket(std::move(*socket));
        sim::Hello hello;
        hello.client_name = name_;
        if (send_packet(socket_, sim::encode(hello)) != SendOutcome::sent) socket_.reset();
    }

    std::optional<ControllerEvent> understand(const sim::ServerPacket& packet) {
        const bool is_up = status_.state != ControllerState::stopped;
        if (const auto* welcome = std::get_if<sim::Welcome>(&packet)) {
            if (is_up) {
                leave();
            } else {
                enter(*welcome);
            }
            return std::nullopt;
        }
        if (!is_up || std::holds_alternative<sim::Refusal>(packet)) {
            leave();
            return std::nullopt;
        }
        if (const auto* received = std::get_if<Received>(&packet)) return *received;
        if (const auto* result = std::get_if<TransmitResult>(&packet)) return *result;
        if (const auto* lost = std::get_if<FramesLost>(&packet)) return *lost;
        return std::get<StateChanged>(packet);
    }

    /// An event that poll() is about to return.
    void note(const ControllerEvent& event) {
        if (const auto* result = std::get_if<TransmitResult>(&event)) {
            std::erase_if(transmissions_, [&](const Transmission& transmission) {
                return transmission.handle == result->handle;
            });
        } else if (const auto* change = std::get_if<StateChanged>(&event)) {
            if (socket_.is_open()) status_ = change->status;
        }
    }

    /// Sends what is still to be said to the daemon. False when it has to wait: then the epoll
    /// descriptor wakes its user when there is room.
    bool flush() {
        if (status_.state == ControllerState::stopped) return true;
        bool sent = true;
        const auto try_send = [&](bool& unsent, const sim::ClientPacket& packet) {
            if (!unsent || !sent) return;
            const SendOutcome outcome = send_packet(socket_, sim::encode(packet));
            if (outcome == SendOutcome::sent) unsent = false;
            sent = outcome != SendOutcome::would_block;
        };
        if (listen_only_unsent_) {
            try_send(listen_only_unsent_, sim::ListenOnlyRequest{monotonic_now(), listen_only_});
        }
        if (filters_unsent_)
            try_send(filters_unsent_, sim::FilterRequest{monotonic_now(), filters_});
        if (recover_unsent_) try_send(recover_unsent_, sim::RecoverRequest{monotonic_now()});
        for (Transmission& transmission : transmissions_) {
            try_send(transmission.abort_unsent,
                     sim::AbortRequest{monotonic_now(), transmission.handle});
        }
        await_room(!sent);
        return sent;
    }

    const std::string path_;
    const std::string name_;
    mutable std::mutex mutex_;
    Descriptor socket_;
    Capabilities capabilities_;
    ErrorStatus status_{.state = ControllerState::stopped};
    std::vector<Transmission> transmissions_;
    std::uint64_t next_handle_ = 1;
    std::vector<Filter> filters_;
    bool listen_only_ = false;
    bool filters_unsent_ = false;
    bool listen_only_unsent_ = false;
    bool recover_unsent_ = false;
    bool reconnecting_ = false;
    bool writable_watched_ = false;
    /// Events that the daemon did not send.
    sim::EventQueue own_events_;
    Signal own_signal_;
    Descriptor epoll_;
    Timer timer_;
};

class SimLink final : public Link {
  public:
    explicit SimLink(SimAddress address) : address_(std::move(address)) {}

    Result<std::unique_ptr<Controller>, std::string> attach(std::string_view client_name) override {
        sim::Hello hello;
        hello.client_name = std::string{client_name.substr(0, sim::max_client_name)};
        auto admission = ask(address_.path, hello);
        if (!admission) return Failure{admission.error()};
        auto controller =
            std::make_unique<SimController>(address_, hello.client_name, std::move(*admission));
        if (!controller->is_open()) {
            return Failure{std::string{"no more file descriptors for a controller"}};
        }
        return std::unique_ptr<Controller>{std::move(controller)};
    }

    TimePoint now() const override { return monotonic_now(); }

  private:
    SimAddress address_;
};

}  // namespace

Result<std::unique_ptr<Link>, std::string> open_sim_link(const SimAddress& address) {
    sim::Hello hello;
    hello.wish = sim::Hello::Wish::query;
    const auto admission = ask(address.path, hello);
    if (!admission) return Failure{admission.error()};
    return std::unique_ptr<Link>{std::make_unique<SimLink>(address)};
}

Result<BusReport, NoReport> request_bus_report(const SimAddress& address) {
    const auto failure = [](std::string reason) { return Failure{NoReport{std::move(reason)}}; };
    auto socket = connect_to_bus(address.path);
    if (!socket) {
        return Failure{NoReport{no_bus(address.path, socket.error()), is_absent(socket.error())}};
    }
    sim::Hello hello;
    hello.wish = sim::Hello::Wish::status;
    const auto admission = ask(std::move(*socket), address.path, hello);
    if (!admission) return failure(admission.error());
    const std::string nonsense = the_bus_at(address.path) + " answered with something else";
    BusReport report;
    report.bitrate = admission->welcome.bitrate;
    const auto first = await_packet(admission->socket, address.path);
    if (!first) return failure(first.error());
    const auto* bus = *first ? std::get_if<sim::BusStatus>(&**first) : nullptr;
    if (bus == nullptr) return failure(nonsense);
    report.bus = *bus;
    while (report.nodes.size() < report.bus.nodes) {
        const auto next = await_packet(admission->socket, address.path);
        if (!next) return failure(next.error());
        const auto* node = *next ? std::get_if<sim::NodeStatus>(&**next) : nullptr;
        if (node == nullptr) return failure(nonsense);
        report.nodes.push_back(*node);
    }
    return report;
}

}  // namespace canorb::can
