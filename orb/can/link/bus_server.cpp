#include "orb/can/link/bus_server.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "orb/can/link/link.hpp"
#include "orb/can/link/pacer.hpp"
#include "orb/can/link/sharp_timers.hpp"
#include "orb/can/link/sim_socket.hpp"
#include "orb/can/sim/protocol.hpp"

namespace canorb::can {
namespace {

using namespace std::chrono_literals;

constexpr Duration longest_stall = 100ms;
/// Without descriptors left for new clients, the time until the next try.
constexpr Duration accept_pause = 1s;
constexpr Duration report_interval = 1s;
/// So long the bus may be worked on until sockets, a stop and the status have their turn.
constexpr Duration work_per_turn = 5ms;
constexpr Duration complaint_interval = 10s;
/// More than a well-behaved client has to say at once; a flooding one waits for its next turn.
constexpr int packets_per_turn = 64;
constexpr int max_accepted_in_a_row = 32;

struct Client {
    Descriptor socket;
    std::string name;
    std::optional<sim::NodeIndex> node;  ///< once its hello was accepted
    /// Taken from the bus, but the socket was full.
    std::optional<ControllerEvent> held;
    bool writable_awaited = false;
    bool lagging = false;  ///< an unpaced bus waited for it in vain, and does not again
    bool hung_up = false;  ///< there is no more to read
    bool gone = false;
    TimePoint last_request;
    std::size_t waiting_requests = 0;  ///< read, but of a time that the bus has not reached
    std::vector<sim::Packet> answer;   ///< to its wish for the status
    std::size_t answered = 0;          ///< packets of it
};

struct Request {
    TimePoint time;       ///< on the machine's clock
    std::uint64_t order;  ///< of reading, for equal times
    Client* client;
    sim::ClientPacket packet;
};

sim::ServerPacket to_packet(const ControllerEvent& event) {
    return std::visit([](const auto& form) { return sim::ServerPacket{form}; }, event);
}

}  // namespace

class BusServer::Server {
  public:
    Server(BusServerOptions options, Descriptor listener)
        : options_(std::move(options)),
          listener_(std::move(listener)),
          socket_file_(identity(options_.path)),
          bus_(options_.bitrate, monotonic_now()),
          reporter_(bus_),
          next_report_(options_.report ? bus_.now() + report_interval : never) {}

    ~Server() {
        if (socket_file_ && identity(options_.path) == socket_file_) {
            ::unlink(options_.path.c_str());
        }
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    bool is_open() const { return stop_.is_open(); }
    void stop() const { stop_.raise(); }
    sim::Bus& bus() { return bus_; }

    std::string run() {
        use_sharp_timers();
        while (true) {
            if (const int error = wait(); error != 0) {
                return "waiting for clients failed: " + error_text(error);
            }
            if (stop_requested()) {
                keep_pace(monotonic_now());
                tell_report();
                return {};
            }
            if ((descriptors_[listener_at].revents & POLLIN) != 0) accept_clients();
            // What all clients have asked for by now has its place in the next arbitration: all are
            // read, because ppoll() tells only what had come before it returned.
            const TimePoint now = monotonic_now();
            for (auto& client : clients_) read_from(*client, now);
            keep_pace(now);
            if (!options_.paced && !stalled()) bus_.advance_one();
            reporter_.sample();
            if (now >= next_report_) {
                next_report_ += report_interval * (1 + (now - next_report_) / report_interval);
                tell_report();
            }
            for (auto& client : clients_) write_to(*client);
            remove_gone();
        }
    }

  private:
    static constexpr std::size_t stop_at = 0;
    static constexpr std::size_t listener_at = 1;

    BusReport report() const {
        std::vector<sim::NodeIndex> nodes;
        for (const auto& client : clients_) {
            if (!client->gone && client->node) nodes.push_back(*client->node);
        }
        BusReport report = reporter_.report(nodes);
        report.bus.time = clock_.machine_time(report.bus.time);
        return report;
    }

    void tell_report() const {
        if (options_.report) options_.report(report());
    }

    void log(const std::string& sentence) const {
        if (options_.log) options_.log(sentence);
    }

    /// Returns an errno or 0.
    int wait() {
        descriptors_.clear();
        descriptors_.push_back({stop_.fd(), POLLIN, 0});
        const TimePoint begin = monotonic_now();
        const bool accepting = begin >= accept_again_;
        descriptors_.push_back({listener_.get(), static_cast<short>(accepting ? POLLIN : 0), 0});
        for (const auto& client : clients_) {
            const int events = client->writable_awaited ? POLLIN | POLLOUT : POLLIN;
            descriptors_.push_back({client->socket.get(), static_cast<short>(events), 0});
        }
        std::optional<Duration> timeout = time_to_next_step();
        if (next_report_ != never) {
            const Duration to_report = std::max(next_report_ - begin, Duration::zero());
            timeout = std::min(timeout.value_or(to_report), to_report);
        }
        if (!accepting) {
            const Duration pause = accept_again_ - begin;
            timeout = std::min(timeout.value_or(pause), pause);
        }
        timespec time{};
        if (timeout) {
            time.tv_sec = static_cast<time_t>(timeout->count() / 1'000'000'000);
            time.tv_nsec = static_cast<long>(timeout->count() % 1'000'000'000);
        }
        const int ready =
            ::ppoll(descriptors_.data(), descriptors_.size(), timeout ? &time : nullptr, nullptr);
        if (ready >= 0) return 0;
        return errno == EINTR ? 0 : errno;
    }

    bool stop_requested() const { return (descriptors_[stop_at].revents & POLLIN) != 0; }

    std::optional<Duration> time_to_next_step() {
        if (!options_.paced) {
            if (bus_.is_quiet()) return std::nullopt;
            if (!stall_ends_) return Duration::zero();
            return std::max(*stall_ends_ - monotonic_now(), Duration::zero());
        }
        if (behind_) return Duration::zero();
        const TimePoint next = clock_.machine_time(pacer_.wake_at(bus_));
        if (next == never) return std::nullopt;
        return std::max(next - monotonic_now(), Duration::zero());
    }

    /// Whether an unpaced bus has to wait for a reader, so that it does not lose frames only
    /// because the bus is faster than any real one.
    bool stalled() {
        const auto is_full = [&](const auto& client) {
            return !client->gone && client->node && !client->lagging &&
                   bus_.events(*client->node).receive_full();
        };
        if (std::none_of(clients_.begin(), clients_.end(), is_full)) {
            stall_ends_.reset();
            return false;
        }
        const TimePoint now = monotonic_now();
        if (!stall_ends_) stall_ends_ = now + longest_stall;
        if (now < *stall_ends_) return true;
        stall_ends_.reset();
        for (auto& client : clients_) {
            if (is_full(client)) client->lagging = true;
        }
        return false;
    }

    void accept_clients() {
        // A few at a time: who connects without end must not keep the bus from the others.
        for (int accepted = 0; accepted < max_accepted_in_a_row; ++accepted) {
            Descriptor socket{
                ::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)};
            if (!socket.is_open()) {
                if (errno == EINTR || errno == ECONNABORTED) continue;
                if (errno != EAGAIN) {
                    log("cannot accept a client: " + error_text(errno));
                    accept_again_ = monotonic_now() + accept_pause;
                }
                return;
            }
            make_room_for_newcomer();
            auto client = std::make_unique<Client>();
            client->socket = std::move(socket);
            clients_.push_back(std::move(client));
        }
    }

    /// Connections that never said hello must not keep others out: the oldest of them goes.
    void make_room_for_newcomer() {
        const auto is_silent = [](const auto& client) { return !client->gone && !client->node; };
        const auto silent = std::count_if(clients_.begin(), clients_.end(), is_silent);
        if (static_cast<std::size_t>(silent) < options_.max_clients) return;
        (*std::find_if(clients_.begin(), clients_.end(), is_silent))->gone = true;
    }

    void read_from(Client& client, TimePoint now) {
        if (client.waiting_requests > 0) return;  // so that what is read here stays bounded
        std::array<std::uint8_t, sim::max_packet_size> buffer;
        for (int i = 0; i < packets_per_turn && !client.gone; ++i) {
            std::size_t size = 0;
            switch (receive_packet(client.socket, buffer, size)) {
                case ReceiveOutcome::nothing:
                    return;
                case ReceiveOutcome::gone:
                    client.hung_up = true;
                    return;
                case ReceiveOutcome::packet:
                    break;
            }
            auto packet = size <= buffer.size()
                              ? sim::parse_client_packet(Bytes{buffer.data(), size})
                              : std::nullopt;
            if (!packet) {
                throw_out(client, "sent a packet that is none of the protocol's");
                return;
            }
            // Neither into the future nor out of the client's own order.
            const TimePoint asked =
                std::visit([&](const auto& form) { return time_of(form, now); }, *packet);
            client.last_request = std::clamp(asked, std::min(client.last_request, now), now);
            requests_.push_back({client.last_request, next_order_++, &client, std::move(*packet)});
            ++client.waiting_requests;
        }
    }

    /// Who comes, or wants to know how the bus is, need not wait until it has caught up.
    TimePoint time_of(const sim::Hello&, TimePoint now) const {
        return behind_ ? clock_.machine_time(bus_.now()) : now;
    }
    template <typename Request>
    TimePoint time_of(const Request& request, TimePoint) const {
        return request.time;
    }

    /// Does what was asked for, and moves a paced bus up to `now`; or part of it, when that takes
    /// long.
    void keep_pace(TimePoint now) {
        const TimePoint deadline = monotonic_now() + work_per_turn;
        behind_ = !obey_requests(deadline);
        if (!options_.paced) return;
        behind_ = behind_ || !clock_.advance(bus_, now, deadline);
        if (!behind_ || !clock_.slip(bus_, now) || now < next_complaint_) return;
        next_complaint_ = now + complaint_interval;
        log("the bus cannot keep up with the clock: it has slipped " +
            std::to_string(clock_.slipped() / 1ms) + " ms behind so far");
    }

    /// Whether all of them were; else the bus has not reached the others' time.
    bool obey_requests(TimePoint deadline) {
        std::sort(requests_.begin(), requests_.end(), [](const Request& a, const Request& b) {
            return std::tie(a.time, a.order) < std::tie(b.time, b.order);
        });
        auto next = requests_.begin();
        for (; next != requests_.end(); ++next) {
            Client& client = *next->client;
            if (options_.paced && !is_reached(next->time, deadline)) break;
            --client.waiting_requests;
            if (client.gone) continue;
            std::visit([&](const auto& form) { obey(client, form); }, next->packet);
        }
        requests_.erase(requests_.begin(), next);
        for (auto& client : clients_) {
            if (client->hung_up && !client->gone && client->waiting_requests == 0) leave(*client);
        }
        return requests_.empty();
    }

    bool is_reached(TimePoint time, TimePoint deadline) {
        if (clock_.machine_time(bus_.now()) >= time) return true;
        return monotonic_now() < deadline && clock_.advance(bus_, time, deadline);
    }

    void leave(Client& client) {
        if (client.node) log(title(client) + " disconnected");
        client.gone = true;
    }

    std::string title(const Client& client) const {
        return (client.node ? "client \"" + client.name + "\"" : std::string{"a connection"}) +
               " (process " + process_of(client.socket) + ")";
    }

    void throw_out(Client& client, const std::string& offence) {
        log(title(client) + " " + offence + "; disconnected it");
        client.gone = true;
    }

    void refuse(Client& client, const std::string& reason) {
        log("refused a client (process " + process_of(client.socket) + "): " + reason);
        send_packet(client.socket, sim::encode(sim::Refusal{sim::protocol_version, reason}));
        client.gone = true;
    }

    void obey(Client& client, const sim::Hello& hello) {
        if (client.node || !client.answer.empty()) {
            throw_out(client, "said hello twice");
            return;
        }
        if (hello.version != sim::protocol_version) {
            refuse(client, "this bus speaks version " + std::to_string(sim::protocol_version) +
                               " of its protocol, the client version " +
                               std::to_string(hello.version));
            return;
        }
        const auto admitted = std::count_if(
            clients_.begin(), clients_.end(),
            [](const auto& other) { return !other->gone && other->node.has_value(); });
        if (hello.wish != sim::Hello::Wish::status &&
            static_cast<std::size_t>(admitted) >= options_.max_clients) {
            refuse(client,
                   "the bus has its " + std::to_string(options_.max_clients) + " clients already");
            return;
        }
        sim::Welcome welcome;
        welcome.paced = options_.paced;
        welcome.bitrate = options_.bitrate;
        welcome.mailboxes = static_cast<std::uint16_t>(options_.controller.mailboxes);
        welcome.filter_list = static_cast<std::uint16_t>(options_.controller.filter_list);
        send_packet(client.socket, sim::encode(welcome));
        if (hello.wish == sim::Hello::Wish::status) {
            prepare_report(client);
            return;
        }
        if (hello.wish == sim::Hello::Wish::query) {
            client.gone = true;
            return;
        }
        client.name = hello.client_name;
        sim::NodeOptions controller = options_.controller;
        controller.name = hello.client_name;
        client.node = bus_.attach(controller);
        log(title(client) + " connected");
    }

    void prepare_report(Client& client) const {
        const BusReport told = report();
        client.answer.push_back(sim::encode(told.bus));
        for (const auto& node : told.nodes) client.answer.push_back(sim::encode(node));
    }

    /// It goes when it has everything.
    static void answer(Client& client) {
        client.writable_awaited = false;
        while (client.answered < client.answer.size()) {
            switch (send_packet(client.socket, client.answer[client.answered])) {
                case SendOutcome::sent:
                    ++client.answered;
                    break;
                case SendOutcome::would_block:
                    client.writable_awaited = true;
                    return;
                case SendOutcome::gone:
                    client.gone = true;
                    return;
            }
        }
        client.gone = true;
    }

    void obey(Client& client, const sim::SendRequest& request) {
        if (!is_admitted(client)) return;
        const auto error =
            bus_.submit(*client.node, request.frame, request.handle, request.options);
        // In bus-off or listen-only mode the client may not know yet that it is.
        if (error && (*error == SendError::full || !bus_.fail(*client.node, request.handle))) {
            throw_out(client, "sent more frames than it has mailboxes");
        }
    }

    void obey(Client& client, const sim::AbortRequest& request) {
        if (is_admitted(client)) bus_.abort(*client.node, request.handle);
    }

    void obey(Client& client, const sim::FilterRequest& request) {
        if (!is_admitted(client)) return;
        if (!bus_.set_filters(*client.node, request.filters)) {
            throw_out(client, "set more filters than it was told that it has");
        }
    }

    void obey(Client& client, const sim::ListenOnlyRequest& request) {
        if (is_admitted(client)) bus_.set_listen_only(*client.node, request.on);
    }

    void obey(Client& client, const sim::RecoverRequest&) {
        if (is_admitted(client)) bus_.recover(*client.node);
    }

    bool is_admitted(Client& client) {
        if (!client.node) throw_out(client, "did not say hello first");
        return client.node.has_value();
    }

    void write_to(Client& client) {
        if (client.gone) return;
        if (!client.answer.empty()) answer(client);
        if (!client.node) return;
        client.writable_awaited = false;
        while (true) {
            if (!client.held) client.held = bus_.poll(*client.node);
            if (!client.held) {
                client.lagging = false;
                return;
            }
            const auto packet = to_packet(clock_.machine_time(*client.held));
            switch (send_packet(client.socket, sim::encode(packet))) {
                case SendOutcome::sent:
                    client.held.reset();
                    break;
                case SendOutcome::would_block:
                    client.writable_awaited = true;
                    return;
                case SendOutcome::gone:
                    leave(client);
                    return;
            }
        }
    }

    void remove_gone() {
        std::erase_if(requests_, [](const Request& request) { return request.client->gone; });
        for (auto& client : clients_) {
            if (client->gone && client->node) bus_.detach(*client->node);
        }
        std::erase_if(clients_, [](const auto& client) { return client->gone; });
    }

    BusServerOptions options_;
    Descriptor listener_;
    std::optional<FileIdentity> socket_file_;
    sim::Bus bus_;
    BusReporter reporter_;
    TimePoint next_report_;
    Pacer pacer_;
    PacedClock clock_;  ///< stands still on an unpaced bus
    bool behind_ = false;
    TimePoint next_complaint_;
    Signal stop_;
    std::vector<std::unique_ptr<Client>> clients_;
    std::vector<Request> requests_;  ///< read, and still to be obeyed
    std::uint64_t next_order_ = 0;
    std::vector<pollfd> descriptors_;
    std::optional<TimePoint> stall_ends_;
    TimePoint accept_again_;  ///< not before
};

Result<std::unique_ptr<BusServer>, std::string> BusServer::open(BusServerOptions options) {
    if (const auto error = remove_stale_socket(options.path)) return Failure{*error};
    auto listener = listen_at(options.path);
    if (!listener) {
        const std::string why = listener.error() == ENOENT ? "its directory does not exist"
                                                           : error_text(listener.error());
        return Failure{"cannot listen at sim:" + options.path + ": " + why};
    }
    auto server = std::make_unique<Server>(std::move(options), std::move(*listener));
    if (!server->is_open()) return Failure{std::string{"no more file descriptors"}};
    return std::unique_ptr<BusServer>{new BusServer{std::move(server)}};
}

BusServer::BusServer(std::unique_ptr<Server> server) : server_(std::move(server)) {}

BusServer::~BusServer() = default;

sim::Bus& BusServer::bus() {
    return server_->bus();
}

std::string BusServer::run() {
    return server_->run();
}

void BusServer::stop() {
    server_->stop();
}

}  // namespace canorb::can
