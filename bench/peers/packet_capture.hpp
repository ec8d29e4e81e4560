// The UDP datagrams that pass the loopback interface, as tcpdump would capture them.
#pragma once

#include <vector>

#include "octets.hpp"

namespace peers {

class PacketCapture {
  public:
    /// Throws Skipped where this process may not capture.
    PacketCapture();
    ~PacketCapture();
    PacketCapture(const PacketCapture&) = delete;
    PacketCapture& operator=(const PacketCapture&) = delete;

    /// The contents of all datagrams since the last time, in order.
    std::vector<Octets> take();

  private:
    int socket_;
};

}  // namespace peers
