#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/result.hpp"
#include "orb/base/time.hpp"
#include "orb/can/frame.hpp"
#include "orb/can/link/bus_report.hpp"
#include "orb/can/sim/bus.hpp"

namespace canorb::tools {

/// Who sends what when. Lines are in order of time, equal ones as they were written.
struct Scenario {
    struct Line {
        TimePoint time;  ///< since the start of the bus
        std::string node;
        can::Frame frame;
    };
    std::vector<Line> lines;
};

/// Reads lines of candump's log format, `(0.001000) pump-3 123#DEADBEEF`, with the name of the node
/// that sends in place of the interface. Empty lines and such that begin with '#' say nothing. Or
/// all errors, each as "LINE: what is wrong".
Result<Scenario, std::vector<std::string>> parse_scenario(std::string_view text);

/// A time span such as 20ms, 1.5s, 300us or 4000ns, at most 1000000s; nothing where it is none.
std::optional<Duration> parse_duration(std::string_view text);

struct PlayOptions {
    /// Nodes that are there besides those that send.
    std::vector<std::string> listeners;
    bool automatic_recovery = false;
    /// When to stop. Without, it is over when the bus is quiet, or 1 s after the last line.
    std::optional<Duration> length;
    /// Is told, in a sentence for people, how to have what the scenario lacks.
    std::function<void(const std::string&)> advise;
    /// What else wants to know of frames and errors.
    std::function<void(const can::sim::CompletedFrame&)> trace;
    std::function<void(const can::sim::NodeError&)> error_trace;
};

/// Plays a scenario on a bus, on which nothing has happened yet, in its own time, every bit of it.
/// What happens is told line by line, in order of time; the same each time. Each node has 32
/// mailboxes and receives all frames. The bus is left without nodes and traces. Returns how it was
/// at the end.
can::BusReport play(const Scenario& scenario, const PlayOptions& options, can::sim::Bus& bus,
                    const std::function<void(const std::string&)>& tell);

}  // namespace canorb::tools
