#pragma once

#include <memory>
#include <string>

#include "orb/base/result.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/link.hpp"

namespace canorb::can {

/// A bus behind a serial adapter that speaks the LAWICEL protocol (doc/wire/slcan.md,
/// doc/links.md). Looks at the terminal at once, so that one that cannot be opened is an error
/// here and now; the adapter itself is asked by attach(), and it has one controller only.
///
/// A controller whose adapter goes is `stopped` and its transmissions have failed. It looks for
/// the adapter by itself, while somebody polls it, and comes back with the same filters.
Result<std::unique_ptr<Link>, std::string> open_slcan_link(const SlcanAddress& address);

}  // namespace canorb::can
