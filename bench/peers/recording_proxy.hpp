// A relay between a client that speaks GIOP over TCP and a server on a Unix socket. It keeps every
// octet that it passes on.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "octets.hpp"

namespace peers {

class RecordingProxy {
  public:
    explicit RecordingProxy(std::string server_path);
    ~RecordingProxy();
    RecordingProxy(const RecordingProxy&) = delete;
    RecordingProxy& operator=(const RecordingProxy&) = delete;

    /// Of 127.0.0.1, where clients connect to.
    std::uint16_t port() const { return port_; }

    /// GIOP messages, in the order of the wire.
    struct Recording {
        std::vector<Octets> to_server;
        std::vector<Octets> to_client;
    };
    /// What came since the last time. Throws where it is not GIOP, or not whole messages.
    Recording take();

  private:
    void relay();
    void pass(int client, int server);

    std::string server_path_;
    std::uint16_t port_ = 0;
    int listener_;
    std::atomic<bool> ending_{false};
    std::mutex mutex_;
    Octets to_server_;
    Octets to_client_;
    std::thread thread_;
};

/// The type of a GIOP message by its name in the specification.
std::string message_type(const Octets& message);

}  // namespace peers
