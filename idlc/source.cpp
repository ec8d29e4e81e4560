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

/// Takes the "..." from the front of `text`: its content, escapes resolved.
std::optional<std::string> take_quoted(std::string_view& text) {
    if (text.empty() || text.front() != '"') return std::nullopt;
    std::string content;
    for (std::size_t i = 1; i < text.size(); ++i) {
        if (text[i] == '"') {
            text.remove_prefix(i + 1);
            return content;
        }
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
    return take_quoted(directive);
}

struct Marker {
    std::uint32_t line;
    std::string file;
    bool enters = false;   ///< the file is included here
    bool returns = false;  ///< to the file, from one that it included
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
    directive = skip_spaces(directive.substr(consumed));
    auto file = take_quoted(directive);
    if (!file) return std::nullopt;
    marker.file = *std::move(file);
    directive = skip_spaces(directive);
    marker.enters = directive.starts_with('1');
    marker.returns = directive.starts_with('2');
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
    segments_.push_back({0, 0, 1, std::nullopt});
    scan();
}

void Source::add_original(const std::string& file, std::string_view text) {
    // A byte order mark is in no column.
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    originals_[file] = split_lines(text);
}

void Source::scan() {
    // A line that begins with # inside a comment is no directive.
    bool in_comment = false;
    std::size_t begin = 0;
    while (begin < text_.size()) {
        const std::size_t end = std::min(text_.find('\n', begin), text_.size());
        line_begins_.push_back(static_cast<std::uint32_t>(begin));
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
        if (marker->enters) open_includes_.push_back(last_include_);
        // Nothing is generated for <orb.idl>.
        const bool from_main = segments_.back().file == 0 && !includes_.empty();
        if (marker->enters && from_main && marker->file.starts_with('<')) includes_.pop_back();
        if (marker->returns && !open_includes_.empty()) open_includes_.pop_back();
        segments_.push_back(
            {next_line, file_index(marker->file), marker->line,
             open_includes_.empty() ? std::nullopt : std::optional{open_includes_.back()}});
    } else if (auto file = included_file(line)) {
        last_include_ = {static_cast<std::uint32_t>(begin)};
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

const std::string& Source::file(Location where) const {
    return files_[segment(where).file];
}

std::uint32_t Source::line(Location where) const {
    const Segment& in = segment(where);
    return in.line + static_cast<std::uint32_t>(text_line(where.offset) - text_line(in.offset));
}

std::optional<Location> Source::included_from(Location where) const {
    return segment(where).included_from;
}

std::size_t Source::text_line(std::size_t offset) const {
    const auto after = std::upper_bound(line_begins_.begin(), line_begins_.end(), offset);
    const auto lines = static_cast<std::size_t>(after - line_begins_.begin());
    // Behind the last line's end a line begins, too, that has nothing in it.
    const bool at_end = offset >= text_.size() && text_.ends_with('\n');
    return at_end ? lines + 1 : lines;
}

Position Source::position(Location where) const {
    const std::size_t offset = std::min<std::size_t>(where.offset, text_.size());
    std::size_t begin = text_.rfind('\n', offset == 0 ? 0 : offset - 1);
    begin = begin == std::string::npos || offset == 0 ? 0 : begin + 1;
    const std::size_t end = std::min(text_.find('\n', offset), text_.size());

    Position position;
    position.file = file(where);
    position.line = line(where);
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
