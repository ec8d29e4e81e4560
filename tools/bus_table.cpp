#include "tools/bus_table.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "orb/base/counted.hpp"

namespace canorb::tools {
namespace {

using Row = std::array<std::string, 8>;

std::string hundredths(std::uint64_t value, std::uint64_t of) {
    const std::uint64_t share = of == 0 ? 0 : value * 10'000 / of;
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%llu.%02llu %%",
                  static_cast<unsigned long long>(share / 100),
                  static_cast<unsigned long long>(share % 100));
    return text.data();
}

std::string seconds(std::uint64_t bits, std::uint32_t bitrate) {
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), "%llu.%06llu s",
                  static_cast<unsigned long long>(bits / bitrate),
                  static_cast<unsigned long long>(bits % bitrate * 1'000'000 / bitrate));
    return text.data();
}

/// Names and states to the left, numbers to the right.
std::string aligned(const std::vector<Row>& rows) {
    constexpr std::size_t left_columns = 2;
    std::array<std::size_t, std::tuple_size_v<Row>> widths{};
    for (const Row& row : rows) {
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    }
    std::string text;
    for (const Row& row : rows) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (i > 0) text += "  ";
            const std::string padding(widths[i] - row[i].size(), ' ');
            text += i < left_columns ? row[i] + padding : padding + row[i];
        }
        text += '\n';
    }
    return text;
}

}  // namespace

std::string bus_table(const can::BusReport& report) {
    const can::sim::BusStatus& bus = report.bus;
    std::string text = std::to_string(report.bitrate) + " bit/s, " +
                       seconds(bus.bits, report.bitrate) + ", load " +
                       hundredths(bus.busy_bits, bus.bits);
    if (bus.recent_bits < bus.bits) {
        text += ", in the last second " + hundredths(bus.recent_busy_bits, bus.recent_bits);
    }
    text += ", " + counted(bus.frames, "frame") + ", " + counted(bus.error_frames, "error frame") +
            '\n';
    if (report.nodes.empty()) return text + "no nodes\n";
    std::vector<Row> rows{
        {"node", "state", "TEC", "REC", "sent", "received", "arbitrations lost", "errors"}};
    for (const can::sim::NodeStatus& node : report.nodes) {
        rows.push_back({node.name, std::string{can::name(node.status.state)},
                        std::to_string(node.status.tec), std::to_string(node.status.rec),
                        std::to_string(node.sent), std::to_string(node.received),
                        std::to_string(node.lost_arbitrations), std::to_string(node.errors)});
    }
    return text + aligned(rows);
}

}  // namespace canorb::tools
