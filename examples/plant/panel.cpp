#include "panel.hpp"

#include <fmt/format.h>

namespace plant {

std::string to_text(const Panel& panel) {
    std::string text = "|";
    for (const PanelLine& line : panel) {
        text += static_cast<char>(line.mark);
        text += line.text;
        text += '|';
    }
    return text;
}

std::optional<Panel> parse_panel(std::string_view text) {
    if (text.size() < 2 || text.front() != '|' || text.back() != '|') return std::nullopt;
    text.remove_prefix(1);
    Panel panel;
    while (!text.empty()) {
        const std::size_t end = text.find('|');
        const std::string_view line = text.substr(0, end);
        if (line.empty() || std::string_view{" +!"}.find(line.front()) == std::string_view::npos)
            return std::nullopt;
        panel.push_back({Mark{line.front()}, std::string{line.substr(1)}});
        text.remove_prefix(end + 1);
    }
    return panel;
}

std::string output_line(double seconds, std::string_view name, std::string_view text) {
    return fmt::format("{:.3f} {}: {}", seconds, name, text);
}

std::string_view text_of_output_line(std::string_view line) {
    const std::size_t colon = line.find(": ");
    return colon == std::string_view::npos ? line : line.substr(colon + 2);
}

}  // namespace plant
