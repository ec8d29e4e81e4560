#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "orb/base/result.hpp"
#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"

namespace canorb::can {

/// An opened bus. Each ORB on it has a controller of its own; they keep working when the Link is
/// gone. All functions, the controllers' too, may be called from any thread.
class Link {
  public:
    virtual ~Link() = default;
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    /// A new controller on the bus. `client_name` is what the bus calls it in its messages (cut
    /// after 32 characters). May block for some seconds where a daemon does not answer; the error
    /// is a sentence for people.
    virtual Result<std::unique_ptr<Controller>, std::string> attach(
        std::string_view client_name) = 0;

    /// The clock that deadlines are measured on: CLOCK_MONOTONIC. The time stamps of frames are
    /// on it too, except on a bus that is not paced by a clock (doc/links.md).
    virtual TimePoint now() const = 0;

  protected:
    Link() = default;
};

/// CLOCK_MONOTONIC.
TimePoint monotonic_now();

/// The address used where nobody names one: "sim:/tmp/canorb-bus0".
std::string_view default_bus_address();

/// Opens a bus by its address (doc/links.md):
///
/// * `local:NAME`, `local:NAME?bitrate=250000`: a simulated bus inside this process, for everyone
///   who opens the same name. 500 kbit/s where the first does not say.
/// * `sim:PATH`: the bus of a canorb-bus daemon that listens on the Unix socket PATH.
/// * `socketcan:IFNAME`: a CAN interface of Linux.
/// * `slcan:DEVICE`, `slcan:DEVICE?bitrate=250000`: a serial adapter. 500 kbit/s where it does not
///   say.
///
/// The error is a sentence for people that says what to do.
Result<std::unique_ptr<Link>, std::string> open_link(std::string_view address);

}  // namespace canorb::can
