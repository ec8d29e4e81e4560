#pragma once

/// What generated types and their codec need: identifiers, CCDR, bounded strings and sequences,
/// fixed, any, maps, bitmasks, unions, printing, user exceptions.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "canorb/exceptions.hpp"
#include "canorb/union.hpp"
#include "orb/base/ids.hpp"
#include "orb/base/interface_info.hpp"
#include "orb/base/time.hpp"
#include "orb/ccdr/any.hpp"
#include "orb/ccdr/bitmask.hpp"
#include "orb/ccdr/bounded.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
#include "orb/ccdr/fixed.hpp"
#include "orb/ccdr/map.hpp"
#include "orb/ccdr/nesting.hpp"
#include "orb/ccdr/print.hpp"
#include "orb/ccdr/type_code.hpp"
