#pragma once

/// What generated types and their codec need: identifiers, CCDR, bounded strings and sequences,
/// user exceptions.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "canorb/exceptions.hpp"
#include "orb/base/ids.hpp"
#include "orb/base/interface_info.hpp"
#include "orb/base/time.hpp"
#include "orb/ccdr/bounded.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
