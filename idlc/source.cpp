#include "idlc/source.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

namespace canorb::idlc {

namespace {

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

std::string_view skip_spaces(std::string_view text) {
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    return text;
}

/// The content of the "..." at the front of `text`, escapes resolved.
std::optional<std::string> quoted(std::string_view text) {
    if (text.empty() || text.front() != '"') return std::nullopt;
    std::string content;
    for (std::size_t i = 1; i < text.size(); ++i) {
        if (text[i] == '"') return content;
        if (text[i] == '\\' && i + 1 < text.size()) ++i;
        content.push_back(text[i]);
    }
    return std::nullopt;
}

/// What a line `#include "x"` or `#include <x>` names.
std::optional<std::string> included_file(std::string_view directive) {
    constexpr std::string_view keyword = "include";
    if (!directive.starts_with(keyword)) return std::nullopt;
    directive = skip_spaces(directive.substr(keyword.size()));
    if (directive.starts_with('<')) {
        const std::size_t close = directive.find('>');
        if (close == std::string_view::npos) return std::nullopt;
        return std::string{directive.substr(1, close - 1)};
    }
    return quoted(directive);
}

struct Marker {
    std::uint32_t line;
    std::string file;
};

/// `12 "file" flags` or `line 12 "file"`: what follows the # of a linemarker.
std::optional<Marker> linemarker(std::string_view directive) {
    constexpr std::string_view keyword = "line";
    if (directive.starts_with(keyword)) directive = skip_spaces(directive.substr(keyword.size()));
    Marker marker{};
    const char* end = directive.data() + directive.size();
    const auto [rest, error] = std::from_chars(directive.data(), end, marker.line);
    if (error != std::errc{}) return std::nullopt;
    const auto consumed = static_cast<std::size_t>(rest - directive.data());
    auto file = quoted(skip_spaces(directive.substr(consumed)));
    if (!file) return std::nullopt;
    marker.file = *std::move(file);
    return marker;
}

/// The column in `original` of what is at `column` in `folded`, the same line after the
/// preprocessor folded its white space; `column` itself where a macro changed what is before it.
std::size_t unfolded_column(std::string_view folded, std::string_view original,
                            std::size_t column) {
    std::size_t at = 0;
    for (std::size_t i = 0; i < column && i < folded.size(); ++i) {
        if (is_space(folded[i])) continue;
        while (at < original.size() && is_space(original[at])) ++at;
        if (at == original.size() || original[at] != folded[i]) return column;
        ++at;
    }
    if (column < folded.size() && !is_space(folded[column])) {
        while (at < original.size() && is_space(original[at])) ++at;
        if (at == original.size() || original[at] != folded[column]) return column;
    }
    return at;
}

std::vector<std::string> split_lines(std::string_view text) {
    std::vector<std::string> lines;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        lines.emplace_back(text.substr(0, end));
        if (!lines.back().empty() && lines.back().back() == '\r') lines.back().pop_back();
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return lines;
}

}  // namespace

Source::Source(std::string main_file, std::string preprocessed) : text_(std::move(preprocessed)) {
    files_.push_back(std::move(main_file));
    segments_.push_back({0, 0, 1});
    scan();
}

void Source::add_original(const std::string& file, std::string_view text) {
    originals_[file] = split_lines(text);
}

void Source::scan() {
    // A line that begins with # inside a comment is no directive.
    bool in_comment = false;
    std::size_t begin = 0;
    while (begin < text_.size()) {
        const std::size_t end = std::min(text_.find('\n', begin), text_.size());
        if (in_comment || !take_directive(begin, end)) {
            char quote = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const char c = text_[i];
                const char next = i + 1 < end ? text_[i + 1] : '\n';
                if (in_comment) {
                    if (c == '*' && next == '/') {
                        in_comment = false;
                        ++i;
                    }
                } else if (quote != 0) {
                    if (c == '\\') {
                        ++i;
                    } else if (c == quote) {
                        quote = 0;
                    }
                } else if (c == '"' || c == '\'') {
                    quote = c;
                } else if (c == '/' && next == '/') {
                    break;
                } else if (c == '/' && next == '*') {
                    in_comment = true;
                    ++i;
                }
            }
        }
        begin = end + 1;
    }
}

bool Source::take_directive(std::size_t begin, std::size_t end) {
    std::string_view line = skip_spaces(std::string_view{text_}.substr(begin, end - begin));
    if (!line.starts_with('#')) return false;
    line = skip_spaces(line.substr(1));
    if (auto marker = linemarker(line)) {
        const auto next_line = static_cast<std::uint32_t>(std::min(end + 1, text_.size()));
        segments_.push_back({next_line, file_index(marker->file), marker->line});
    } else if (auto file = included_file(line)) {
        if (segments_.back().file == 0) includes_.push_back(*std::move(file));
    } else {
        return false;
    }
    std::fill(text_.begin() + static_cast<std::ptrdiff_t>(begin),
              text_.begin() + static_cast<std::ptrdiff_t>(end), ' ');
    return true;
}

std::uint32_t Source::file_index(std::string_view name) {
    const auto found = std::find(files_.begin(), files_.end(), name);
    if (found == files_.end()) {
        files_.emplace_back(name);
        return static_cast<std::uint32_t>(files_.size() - 1);
    }
    return static_cast<std::uint32_t>(found - files_.begin());
}

const Source::Segment& Source::segment(Location where) const {
    const auto after = std::upper_bound(
        segments_.begin(), segments_.end(), where.offset,
        [](std::uint32_t offset, const Segment& segment) { return offset < segment.offset; });
    return *std::prev(after);
}

bool Source::in_main_file(Location where) const {
    return segment(where).file == 0;
}

Position Source::position(Location where) const {
    const Segment& in = segment(where);
    const std::size_t offset = std::min<std::size_t>(where.offset, text_.size());
    std::size_t begin = text_.rfind('\n', offset == 0 ? 0 : offset - 1);
    begin = begin == std::string::npos || offset == 0 ? 0 : begin + 1;
    const std::size_t end = std::min(text_.find('\n', offset), text_.size());

    Position position;
    position.file = files_[in.file];
    position.line =
        in.line +
        static_cast<std::uint32_t>(std::count(
            text_.begin() + static_cast<std::ptrdiff_t>(in.offset),
            text_.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(offset, in.offset)),
            '\n'));
    position.source_line = text_.substr(begin, end - begin);
    std::size_t column = offset - begin;
    const auto original = originals_.find(position.file);
    if (original != originals_.end() && position.line >= 1 &&
        position.line <= original->second.size()) {
        const std::string& line = original->second[position.line - 1];
        column = unfolded_column(position.source_line, line, column);
        position.source_line = line;
    }
    position.column = static_cast<std::uint32_t>(column + 1);
    return position;
}

}  // namespace canorb::idlc
