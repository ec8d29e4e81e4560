#pragma once

#include <canorb/types.hpp>
#include <chrono>

#include "tank.hpp"

namespace tank {

/// What both nodes put into the messages of tank.idl.

inline Tank::Valve position(bool open) {
    return open ? Tank::Valve::open : Tank::Valve::closed;
}

inline std::chrono::milliseconds in_ms(canorb::Duration duration) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(duration);
}

}  // namespace tank
