#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "orb/base/result.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::can {

struct BusServerOptions {
    std::string path;                 ///< of the Unix socket to listen at
    std::uint32_t bitrate = 500'000;  ///< 10 000 to 1 000 000 bit/s
    /// On the machine's clock. Otherwise bus time starts there and then moves by frames only, as
    /// fast as the clients keep up.
    bool paced = true;
    std::size_t max_clients = 128;
    sim::NodeOptions controller;  ///< what each client gets
    /// One sentence about a client that came, went or was thrown out.
    std::function<void(std::string_view)> log;
    /// Each frame that was sent and acknowledged, on the bus's clock.
    std::function<void(const sim::CompletedFrame&)> trace;
};

/// A simulated bus for other processes, behind a Unix socket: what canorb-bus runs
/// (doc/wire/sim-bus.md). One thread serves everything, in run().
///
/// No client can harm another: what a client has under way is bounded by its mailboxes, what it
/// has not read by its receive capacity (then it loses frames and is told so); one that sends
/// anything the protocol does not allow is disconnected. Without pacing the bus waits for a client
/// whose receive queue is full, but not longer than 100 ms until it has read everything.
class BusServer {
  public:
    /// Listens. A socket that a dead daemon left at the path is replaced; that of a live one is
    /// an error. The error is a sentence for people.
    static Result<std::unique_ptr<BusServer>, std::string> open(BusServerOptions options);

    /// Closes all connections and removes the socket.
    ~BusServer();
    BusServer(const BusServer&) = delete;
    BusServer& operator=(const BusServer&) = delete;

    /// Serves until stop(). Nothing where it ended so, else why it could not go on.
    std::string run();

    /// Ends run(), also one that has not begun. Any thread; async-signal-safe.
    void stop();

  private:
    class Server;
    explicit BusServer(std::unique_ptr<Server> server);
    std::unique_ptr<Server> server_;
};

}  // namespace canorb::can
