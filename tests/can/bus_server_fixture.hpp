#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "orb/can/link/bus_server.hpp"
#include "orb/can/link/link.hpp"
#include "orb/can/link/sim_socket.hpp"
#include "orb/can/sim/protocol.hpp"
#include "tests/can/temporary_directory.hpp"

namespace canorb::can::test {

inline constexpr int patience_ms = 20'000;
inline constexpr std::array<Filter, 1> accept_all{Filter{}};

inline bool readable(int fd) {
    pollfd descriptor{fd, POLLIN, 0};
    return ::poll(&descriptor, 1, patience_ms) == 1;
}

/// A bus daemon in a thread.
class RunningServer {
  public:
    using SetUpBus = std::function<void(sim::Bus&)>;

    explicit RunningServer(BusServerOptions options, const SetUpBus& set_up = {}) {
        options.log = [this](std::string_view sentence) {
            const std::lock_guard lock{mutex_};
            log_ += std::string{sentence} + '\n';
        };
        auto server = BusServer::open(std::move(options));
        EXPECT_TRUE(server) << server.error();
        server_ = std::move(*server);
        if (set_up) set_up(server_->bus());
        thread_ = std::thread{[this] { EXPECT_EQ(server_->run(), ""); }};
    }
    ~RunningServer() {
        server_->stop();
        thread_.join();
    }
    RunningServer(const RunningServer&) = delete;
    RunningServer& operator=(const RunningServer&) = delete;

    std::string log() const {
        const std::lock_guard lock{mutex_};
        return log_;
    }

  private:
    mutable std::mutex mutex_;
    std::string log_;
    std::unique_ptr<BusServer> server_;
    std::thread thread_;
};

/// A client that says whatever a test wants it to say.
class RawClient {
  public:
    explicit RawClient(const std::string& path) {
        auto socket = connect_to_bus(path);
        EXPECT_TRUE(socket) << error_text(socket.error());
        if (socket) socket_ = std::move(*socket);
    }

    const Descriptor& socket() const { return socket_; }

    SendOutcome say(const sim::ClientPacket& packet) {
        return send_packet(socket_, sim::encode(packet));
    }
    SendOutcome say(const std::vector<std::uint8_t>& octets) {
        const auto sent = ::send(socket_.get(), octets.data(), octets.size(), MSG_NOSIGNAL);
        return sent >= 0 ? SendOutcome::sent : SendOutcome::gone;
    }

    /// The next packet; nothing when the daemon has closed the connection.
    std::optional<sim::ServerPacket> hear() {
        std::array<std::uint8_t, sim::max_packet_size> buffer;
        while (true) {
            std::size_t size = 0;
            switch (receive_packet(socket_, buffer, size)) {
                case ReceiveOutcome::packet:
                    return sim::parse_server_packet(Bytes{buffer.data(), size});
                case ReceiveOutcome::gone:
                    return std::nullopt;
                case ReceiveOutcome::nothing:
                    if (!readable(socket_.get())) {
                        ADD_FAILURE() << "the daemon says nothing";
                        return std::nullopt;
                    }
            }
        }
    }

    /// Hears everything until the daemon closes the connection.
    void expect_disconnection() {
        while (hear()) {
        }
    }

    void enter() {
        sim::Hello hello;
        hello.client_name = "raw";
        say(hello);
        const auto answer = hear();
        EXPECT_TRUE(answer && std::holds_alternative<sim::Welcome>(*answer));
    }

  private:
    Descriptor socket_;
};

class BusServerTest : public testing::Test {
  protected:
    BusServerOptions options(bool paced = true) const {
        BusServerOptions result;
        result.path = directory_.path() + "/bus";
        result.paced = paced;
        return result;
    }
    void start(BusServerOptions with, const RunningServer::SetUpBus& set_up = {}) {
        server_.emplace(std::move(with), set_up);
    }
    void start() { start(options()); }

    std::string path() const { return directory_.path() + "/bus"; }
    std::string address() const { return "sim:" + path(); }

    std::unique_ptr<Controller> attach(std::string_view client_name = "test") {
        auto link = open_link(address());
        EXPECT_TRUE(link) << link.error();
        if (!link) return nullptr;
        auto controller = (*link)->attach(client_name);
        EXPECT_TRUE(controller) << controller.error();
        if (!controller) return nullptr;
        EXPECT_TRUE((*controller)->set_filters(accept_all));
        return std::move(*controller);
    }

    /// The next event of the kind; others before it are dropped.
    template <typename Event>
    std::optional<Event> next(Controller& controller) {
        while (true) {
            while (const auto event = controller.poll()) {
                if (const auto* wanted = std::get_if<Event>(&*event)) return *wanted;
            }
            if (!readable(controller.event_fd())) return std::nullopt;
        }
    }

    /// Two clients talk: the bus is as it should be.
    void expect_working_bus() {
        const auto sender = attach("good sender");
        const auto receiver = attach("good receiver");
        ASSERT_TRUE(sender && receiver);
        const SendResult sent = sender->send(Frame::standard(0x7A5, {}));
        ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sent));
        while (const auto received = next<Received>(*receiver)) {
            if (received->frame.id == 0x7A5) return;
        }
        ADD_FAILURE() << "the frame did not arrive";
    }

    TemporaryDirectory directory_;
    std::optional<RunningServer> server_;
};

}  // namespace canorb::can::test
