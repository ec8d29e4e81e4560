#pragma once

/// A bus by its address: "local:NAME" (inside this process), "sim:PATH" (a canorb-bus daemon),
/// "socketcan:IFNAME" (Linux), "slcan:DEVICE" (a serial adapter); see doc/links.md.
///
///     auto bus = canorb::open_bus("sim:/tmp/canorb-bus");
///     canorb::Orb orb{*bus, {.node = 3}};

#include <memory>
#include <string>
#include <string_view>

#include "canorb/types.hpp"
#include "orb/can/controller.hpp"

namespace canorb {

class Simulation;

/// A bus that ORBs can be attached to. It must outlive them. One Bus serves any number of ORBs:
/// each gets a controller of its own.
class Bus {
  public:
    virtual ~Bus() = default;
    Bus(const Bus&) = delete;
    Bus& operator=(const Bus&) = delete;

    /// A new controller on this bus. `name` is shown by the bus's tools. Throws COMM_FAILURE.
    virtual std::unique_ptr<can::Controller> attach(std::string_view name) = 0;

    /// The moment now, on the clock that deadlines and timers use.
    virtual TimePoint now() const = 0;

    /// The simulation that this bus is part of; null on the machine's own clock.
    virtual Simulation* simulation() { return nullptr; }

  protected:
    Bus() = default;
};

/// Opens the bus at `address`. Throws BAD_PARAM for an address that is none, COMM_FAILURE when
/// there is no bus at it; what() says which, and what to do.
std::unique_ptr<Bus> open_bus(std::string_view address);

/// The address that programs use when nobody names one: CANORB_BUS, else the default sim: path.
std::string default_bus_address();

/// `text` as a node's number. Throws BAD_PARAM, naming the value, when it is not 0..30.
int parse_node_id(std::string_view text);

}  // namespace canorb
