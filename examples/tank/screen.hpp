#pragma once

#include <canorb/types.hpp>
#include <optional>

#include "live_tank.hpp"

namespace tank {

/// Shows the tank on the whole terminal, and takes keys, until q, a signal of StopSignals, or
/// `limit`. False: this terminal cannot show it, and nothing was done.
bool run_screen(LiveTank& tank, std::optional<canorb::Duration> limit);

}  // namespace tank
