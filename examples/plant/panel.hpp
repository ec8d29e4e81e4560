#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plant {

/// How a line is to be seen: green, red, or neither.
enum class Mark : char { none = ' ', good = '+', bad = '!' };

struct PanelLine {
    Mark mark;
    std::string text;

    bool operator==(const PanelLine&) const = default;
};

/// What a node shows.
using Panel = std::vector<PanelLine>;

/// On one line: "| 20.0 C|+ON|", with the mark in front of each.
std::string to_text(const Panel& panel);
/// What to_text() wrote; nothing where this is no panel.
std::optional<Panel> parse_panel(std::string_view text);

/// What a node says on standard output where it has no terminal: "0.250 sensor-11: text".
std::string output_line(double seconds, std::string_view name, std::string_view text);
/// The text of such a line.
std::string_view text_of_output_line(std::string_view line);

}  // namespace plant
