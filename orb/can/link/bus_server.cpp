#include "orb/can/link/bus_server.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
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
};

struct Request {
    TimePoint time;
    std::size_t order;  ///< of reading, for equal times
    Client* client;
    sim::ClientPacket packet;
};

/// What identifies a file, to remove only the socket that is ours.
struct FileIdentity {
    dev_t device = 0;
    ino_t inode = 0;
    friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};

std::optional<FileIdentity> identity(const std::string& path) {
    struct stat status{};
    if (::lstat(path.c_str(), &status) != 0) return std::nullopt;
    return FileIdentity{status.st_dev, status.st_ino};
}

sim::ServerPacket to_packet(const ControllerEvent& event) {
    return std::visit([](const auto& form) { return sim::ServerPacket{form}; }, event);
}

std::string process_of(const Descriptor& socket) {
    ucred credentials{};
    socklen_t size = sizeof credentials;
    if (::getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return "?";
    return std::to_string(credentials.pid);
}

/// Makes way for a new daemon's socket. The error is a sentence.
std::optional<std::string> remove_stale_socket(const std::string& path) {
    struct stat status{};
    if (::lstat(path.c_str(), &status) != 0) return std::nullopt;  // nothing there
    if (!S_ISSOCK(status.st_mode)) return path + " exists and is not a socket";
    const auto connection = connect_to_bus(path);
    if (connection || connection.error() != ECONNREFUSED) {
        if (connection || connection.error() == EAGAIN || connection.error() == EPROTOTYPE) {
            return "a bus is already running at sim:" + path;
        }
        return "cannot tell whether a bus is running at sim:" + path + ": " +
               error_text(connection.error());
    }
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) {
        return "cannot remove the old socket " + path + ": " + error_text(errno);
    }
    return std::nullopt;
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
                if (options_.paced) bus_.advance(monotonic_now());
                tell_report();
                return {};
            }
            if ((descriptors_[listener_at].revents & POLLIN) != 0) accept_clients();
            // What all clients have asked for by now has its place in the next arbitration: all are
            // read, because ppoll() tells only what had come before it returned.
            const TimePoint now = monotonic_now();
            for (auto& client : clients_) read_from(*client, now);
            obey_requests();
            if (options_.paced) {
                bus_.advance(now);
            } else if (!stalled()) {
                bus_.advance_one();
            }
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
        return reporter_.report(nodes);
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
        descriptors_.push_back({listener_.get(), static_cast<short>(accepting_ ? POLLIN : 0), 0});
        for (const auto& client : clients_) {
            const int events = client->writable_awaited ? POLLIN | POLLOUT : POLLIN;
            descriptors_.push_back({client->socket.get(), static_cast<short>(events), 0});
        }
        std::optional<Duration> timeout = time_to_next_step();
        if (next_report_ != never) {
            const Duration to_report = std::max(next_report_ - monotonic_now(), Duration::zero());
            timeout = std::min(timeout.value_or(to_report), to_report);
        }
        if (!accepting_) timeout = std::min(timeout.value_or(accept_pause), accept_pause);
        accepting_ = true;
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
        const TimePoint next = pacer_.wake_at(bus_);
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
                    accepting_ = false;
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
            requests_.push_back(
                {client.last_request, requests_.size(), &client, std::move(*packet)});
        }
    }

    static TimePoint time_of(const sim::Hello&, TimePoint now) { return now; }
    template <typename Request>
    static TimePoint time_of(const Request& request, TimePoint) {
        return request.time;
    }

    void obey_requests() {
        std::sort(requests_.begin(), requests_.end(), [](const Request& a, const Request& b) {
            return std::tie(a.time, a.order) < std::tie(b.time, b.order);
        });
        for (const Request& request : requests_) {
            if (request.client->gone) continue;
            if (options_.paced) bus_.advance(request.time);
            std::visit([&](const auto& form) { obey(*request.client, form); }, request.packet);
        }
        requests_.clear();
        for (auto& client : clients_) {
            if (client->hung_up && !client->gone) leave(*client);
        }
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
        if (client.node) {
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
        if (hello.wish != sim::Hello::Wish::controller) {
            if (hello.wish == sim::Hello::Wish::status) send_report(client);
            client.gone = true;
            return;
        }
        client.name = hello.client_name;
        sim::NodeOptions controller = options_.controller;
        controller.name = hello.client_name;
        client.node = bus_.attach(controller);
        log(title(client) + " connected");
    }

    /// What a socket takes at once is more than that of all nodes.
    void send_report(const Client& client) const {
        const BusReport told = report();
        send_packet(client.socket, sim::encode(told.bus));
        for (const auto& node : told.nodes) send_packet(client.socket, sim::encode(node));
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
        if (client.gone || !client.node) return;
        client.writable_awaited = false;
        while (true) {
            if (!client.held) client.held = bus_.poll(*client.node);
            if (!client.held) {
                client.lagging = false;
                return;
            }
            switch (send_packet(client.socket, sim::encode(to_packet(*client.held)))) {
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
    Signal stop_;
    std::vector<std::unique_ptr<Client>> clients_;
    std::vector<Request> requests_;  ///< of this turn
    std::vector<pollfd> descriptors_;
    std::optional<TimePoint> stall_ends_;
    bool accepting_ = true;
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
