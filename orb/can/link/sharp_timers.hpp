#pragma once

namespace canorb::can {

/// Makes timed waits of the calling thread end to the microsecond: Linux's default slack of 50 us
/// is half a frame.
void use_sharp_timers();

}  // namespace canorb::can
