#pragma once

#include <memory>
#include <string>

#include "orb/base/result.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/bus_report.hpp"
#include "orb/can/link/link.hpp"

namespace canorb::can {

/// The bus of a canorb-bus daemon. Asks the daemon at once, so that no daemon, or one that refuses
/// this client, is an error here and now.
///
/// A controller whose daemon goes is `stopped` and its transmissions have failed. recover() then
/// connects again, at once or as soon as there is a daemon, with the same filters.
Result<std::unique_ptr<Link>, std::string> open_sim_link(const SimAddress& address);

/// Why there is no report.
struct NoReport {
    std::string reason;           ///< a sentence for people
    bool nobody_listens = false;  ///< else there is something that does not answer as a bus does
};

/// How the bus of a canorb-bus daemon is.
Result<BusReport, NoReport> request_bus_report(const SimAddress& address);

}  // namespace canorb::can
