#include "orb/can/link/sharp_timers.hpp"

#include <sys/prctl.h>

namespace canorb::can {

void use_sharp_timers() {
    ::prctl(PR_SET_TIMERSLACK, 1000UL);
}

}  // namespace canorb::can
