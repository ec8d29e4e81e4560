#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "orb/base/time.hpp"
#include "orb/can/sim/node_index.hpp"

namespace canorb::can::sim {

/// One bit time on a bus. 0 is dominant, 1 recessive. The spans have an element for each NodeIndex
/// up to the highest attached; an index without a node is recessive.
struct BusBit {
    TimePoint start;
    TimePoint end;
    std::uint8_t bus = 1;                    ///< the wire: all that nodes drive, and faults of it
    std::span<const std::uint8_t> driven{};  ///< what each node sends
    std::span<const std::uint8_t> seen{};    ///< what each node samples
};

/// Sees a bus bit by bit. While a Bus has one, it simulates every frame in bits. Between frames,
/// when all is recessive, time may pass without a call. It must not call the bus.
class BitObserver {
  public:
    virtual ~BitObserver() = default;
    virtual void node_attached(NodeIndex node, std::string_view name) = 0;
    virtual void node_detached(NodeIndex node) = 0;
    /// At the bit's end, in order of time.
    virtual void bit(const BusBit& bit) = 0;
};

}  // namespace canorb::can::sim
