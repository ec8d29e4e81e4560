#include "tools/bus_table.hpp"

#include <gtest/gtest.h>

namespace canorb::tools {
namespace {

can::BusReport report(std::uint64_t bits, std::uint64_t busy_bits) {
    can::BusReport report;
    report.bitrate = 500'000;
    report.bus.bits = bits;
    report.bus.busy_bits = busy_bits;
    report.bus.recent_bits = std::min<std::uint64_t>(bits, 500'000);
    return report;
}

std::string first_line(const can::BusReport& report) {
    const std::string text = bus_table(report);
    return text.substr(0, text.find('\n'));
}

TEST(BusTable, AlignsItsColumns) {
    can::BusReport bus = report(1'000'000, 451'000);
    bus.bus.recent_busy_bits = 486'550;
    bus.bus.frames = 3820;
    bus.bus.error_frames = 1;
    bus.nodes.push_back({{}, 3820, 0, 12, 0, "pump-3"});
    bus.nodes.push_back({{can::ControllerState::error_passive, 136, 7}, 0, 3820, 0, 17, "valve"});
    EXPECT_EQ(bus_table(bus),
              "500000 bit/s, 2.000000 s, load 45.10 %, in the last second 97.31 %, 3820 frames, "
              "1 error frame\n"
              "node    state          TEC  REC  sent  received  arbitrations lost  errors\n"
              "pump-3  error active     0    0  3820         0                 12       0\n"
              "valve   error passive  136    7     0      3820                  0      17\n");
}

TEST(BusTable, RoundsLoadsDown) {
    EXPECT_EQ(first_line(report(400'000, 399'999)),
              "500000 bit/s, 0.800000 s, load 99.99 %, 0 frames, 0 error frames");
    EXPECT_EQ(first_line(report(400'000, 400'000)),
              "500000 bit/s, 0.800000 s, load 100.00 %, 0 frames, 0 error frames");
    EXPECT_EQ(first_line(report(0, 0)),
              "500000 bit/s, 0.000000 s, load 0.00 %, 0 frames, 0 error frames");
}

TEST(BusTable, HoldsYears) {
    // 30 years of 500 000 bits a second.
    EXPECT_EQ(
        first_line(report(473'040'000'000'000, 236'520'000'000'001)),
        "500000 bit/s, 946080000.000000 s, load 50.00 %, in the last second 0.00 %, 0 frames, "
        "0 error frames");
}

}  // namespace
}  // namespace canorb::tools
