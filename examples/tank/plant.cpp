#include "plant.hpp"

#include <algorithm>

namespace tank {

void Plant::step() {
    // Per step: 400 l/s are 2 mm, 200 l/s are 1 mm.
    const int change_mm = (valves_.inlet_open ? 2 : 0) - (valves_.outlet_open ? 1 : 0);
    const int level_mm = level_mm_ + change_mm;
    overflowing_ = level_mm > height_mm;
    level_mm_ = static_cast<std::uint16_t>(std::clamp<int>(level_mm, 0, height_mm));
}

}  // namespace tank
