#pragma once

/// Lines of the files that a virtual run writes. Integers only: the same octets on every machine.

#include <canorb/simulation.hpp>
#include <cstdint>
#include <string>
#include <string_view>

#include "display.hpp"

namespace tank {

/// The state of everything at the end of node B's slot 6.
struct RoundRecord {
    canorb::Duration time{};  ///< since the start
    std::uint64_t round = 0;
    std::chrono::milliseconds slot_length{};
    Mode mode = Mode::normal;
    int setpoint_cm = 0;
    int temperature_c = 0;
    std::uint16_t level_mm = 0;
    Valves valves{};  ///< as applied
};

inline constexpr std::string_view csv_header =
    "time_s,round,slot_ms,mode,setpoint_cm,temperature_c,level_mm,ve,vs";

/// "0.350,1,50,N,50,20,1990,0,1"
std::string csv_line(const RoundRecord& record);

/// A line as candump -l writes it: "(0.000230) can0 021#1000051234ABCD00". `time` is that of the
/// frame's end.
std::string candump_line(canorb::Duration time, const canorb::can::Frame& frame);

}  // namespace tank
