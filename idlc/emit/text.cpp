#include "idlc/emit/text.hpp"

#include <algorithm>

namespace canorb::idlc::emit {

namespace {

std::string_view value_of(std::string_view name, std::initializer_list<Slot> slots) {
    for (const auto& [slot, value] : slots) {
        if (slot == name) return value;
    }
    return {};
}

std::string fill_line(std::string_view line, std::initializer_list<Slot> slots) {
    const std::size_t text_begin = std::min(line.find_first_not_of(' '), line.size());
    const std::string margin(text_begin, ' ');
    std::string filled;
    while (true) {
        const std::size_t open = line.find('$');
        const std::size_t close = open == std::string_view::npos ? open : line.find('$', open + 1);
        if (close == std::string_view::npos) break;
        filled += line.substr(0, open);
        std::string_view value = value_of(line.substr(open + 1, close - open - 1), slots);
        line.remove_prefix(close + 1);
        // The line has an end of its own.
        if (line.empty() && value.ends_with('\n')) value.remove_suffix(1);
        for (const char c : value) {
            filled += c;
            if (c == '\n') filled += margin;
        }
    }
    filled += line;
    return filled;
}

bool is_blank(std::string_view line) {
    return line.find_first_not_of(' ') == std::string_view::npos;
}

}  // namespace

std::string fill(std::string_view piece, std::initializer_list<Slot> slots) {
    if (piece.starts_with('\n')) piece.remove_prefix(1);
    std::string text;
    while (!piece.empty()) {
        const std::size_t end = std::min(piece.find('\n'), piece.size());
        const std::string_view line = piece.substr(0, end);
        std::string filled = fill_line(line, slots);
        if (!is_blank(filled)) {
            text += filled;
        } else if (!is_blank(line)) {
            piece.remove_prefix(std::min(end + 1, piece.size()));
            continue;
        }
        if (end < piece.size()) text += '\n';
        piece.remove_prefix(std::min(end + 1, piece.size()));
    }
    // Margins that stand before nothing.
    for (std::size_t at = 0; (at = text.find(" \n", at)) != std::string::npos;) {
        text.erase(at, 1);
        if (at > 0) --at;
    }
    return text;
}

std::string indent(std::string_view text, std::size_t levels) {
    std::string result;
    bool line_begins = true;
    for (const char c : text) {
        if (line_begins && c != '\n') result.append(4 * levels, ' ');
        result += c;
        line_begins = c == '\n';
    }
    return result;
}

std::string wrap(std::string_view begin, std::string_view end) {
    const bool fits = begin.size() + end.size() <= line_width;
    return std::string{begin} + (fits ? "" : "\n    ") + std::string{end};
}

std::string remarked(std::string_view declaration, std::string_view remark) {
    const std::string comment = "// " + std::string{remark};
    const std::string line{declaration};
    if (line.size() + 2 + comment.size() <= line_width) return line + "  " + comment + '\n';
    return comment + '\n' + line + '\n';
}

std::string hexadecimal(std::uint32_t value) {
    std::string text{"0x"};
    for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789ABCDEF"[(value >> shift) & 15];
    return text;
}

std::string join(const std::vector<std::string>& parts, std::string_view separator) {
    std::string text;
    for (const std::string& part : parts) {
        if (&part != &parts.front()) text += separator;
        text += part;
    }
    return text;
}

}  // namespace canorb::idlc::emit
