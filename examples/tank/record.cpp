#include "record.hpp"

#include <fmt/format.h>

namespace tank {

std::string csv_line(const RoundRecord& record) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(record.time).count();
    return fmt::format("{}.{:03},{},{},{},{},{},{},{:d},{:d}", ms / 1000, ms % 1000, record.round,
                       record.slot_length.count(), record.mode == Mode::normal ? 'N' : 'A',
                       record.setpoint_cm, record.temperature_c, record.level_mm,
                       record.valves.inlet_open, record.valves.outlet_open);
}

std::string candump_line(canorb::Duration time, const canorb::can::Frame& frame) {
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(time).count();
    std::string line =
        fmt::format("({}.{:06}) can0 {:03X}#", us / 1'000'000, us % 1'000'000, frame.id);
    for (const std::uint8_t octet : frame.payload()) line += fmt::format("{:02X}", octet);
    return line;
}

}  // namespace tank
