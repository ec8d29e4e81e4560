#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "virtual_tank.hpp"

namespace tank::test {

/// Everything that a virtual run tells.
struct Recording {
    struct Frame {
        canorb::Duration end;
        canorb::can::Frame frame;
    };
    struct Line {
        canorb::Duration time;
        std::string node;
        std::string text;
    };

    std::vector<std::string> csv;
    std::vector<RoundRecord> rounds;
    std::vector<Frame> frames;
    std::vector<Line> lines;
    std::string terminal;

    VirtualTank::Outputs outputs() {
        return {
            .round =
                [this](const RoundRecord& record) {
                    csv.push_back(csv_line(record));
                    rounds.push_back(record);
                },
            .frame = [this](canorb::Duration end,
                            const canorb::can::Frame& frame) { frames.push_back({end, frame}); },
            .sample = {},
            .log =
                [this](canorb::Duration time, std::string_view node, std::string_view text) {
                    lines.push_back({time, std::string{node}, std::string{text}});
                },
            .terminal = [this](std::string_view text) { terminal += text; }};
    }

    /// The first line of that node from `from` on that begins so; null when there is none.
    const Line* find_line(std::string_view node, std::string_view begin,
                          canorb::Duration from = {}) const {
        const auto found = std::find_if(lines.begin(), lines.end(), [&](const Line& line) {
            return line.time >= from && line.node == node && line.text.starts_with(begin);
        });
        return found == lines.end() ? nullptr : &*found;
    }
};

}  // namespace tank::test
