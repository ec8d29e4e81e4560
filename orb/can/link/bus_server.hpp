#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "orb/base/result.hpp"
#include "orb/can/link/bus_report.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::can {

struct BusServerOptions {
    std::string path;                 ///< of the Unix socket to listen at
    std::uint32_t bitrate = 500'000;  ///< 5 000 to 1 000 000 bit/s
    /// On the machine's clock. Otherwise bus time starts there and then moves by frames only, as
    /// fast as the clients keep up.
    bool paced = true;
    std::size_t max_clients = 128;
    sim::NodeOptions controller;  ///< what each client gets, under the name in its hello
    /// One sentence about a client that came, went or was thrown out.
    std::function<void(std::string_view)> log;
    /// Called by run() each second while it runs, if there is one, and at its end.
    std::function<void(const BusReport&)> report;
};

/// A simulated bus for other processes, behind a Unix socket: what canorb-bus runs
/// (doc/wire/sim-bus.md). One thread serves everything, in run(). The socket file is for its user
/// only (mode 0600).
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

    /// To be told of frames and errors, to watch and to disturb it. Only before run(); what is set
    /// is called by run() and must outlive it. No node is there yet, and it is bus().now().
    sim::Bus& bus();

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
