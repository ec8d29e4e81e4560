#pragma once

#include <string>

#include "orb/can/link/bus_report.hpp"

namespace canorb::tools {

/// How a bus and its nodes are, for people: a line for the bus, and one for each node. Loads are
/// rounded down, so that 100.00 % is a bus without an idle bit.
std::string bus_table(const can::BusReport& report);

}  // namespace canorb::tools
