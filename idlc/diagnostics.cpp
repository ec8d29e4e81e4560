#include "idlc/diagnostics.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace canorb::idlc {

void Diagnostics::error(Location where, std::string text) {
    add(Severity::error, where, std::move(text));
}

void Diagnostics::warning(Location where, std::string text) {
    add(Severity::warning, where, std::move(text));
}

void Diagnostics::note(Location where, std::string text) {
    if (!last_was_dropped_) all_.push_back({Severity::note, where, std::move(text)});
}

void Diagnostics::add(Severity severity, Location where, std::string text) {
    last_was_dropped_ = !said_.emplace(where, text).second;
    if (last_was_dropped_) return;
    if (severity == Severity::error && ++errors_ > most_errors) {
        last_was_dropped_ = true;
        return;
    }
    all_.push_back({severity, where, std::move(text)});
}

namespace {

std::string_view name(Severity severity) {
    switch (severity) {
        case Severity::error:
            return "error";
        case Severity::warning:
            return "warning";
        case Severity::note:
            break;
    }
    return "note";
}

/// The octets of UTF-8 behind a character's first.
bool continues_character(char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

bool is_control(char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
}

/// The source line and the caret below it. Of a line that is too long, what is around the caret.
std::string excerpt(const Position& position) {
    constexpr std::size_t most = 400;
    constexpr std::size_t before_caret = 200;
    std::string line = position.source_line;
    std::size_t column = position.column - 1;
    if (line.size() > most) {
        const std::size_t begin = column > before_caret ? column - before_caret : 0;
        line = (begin > 0 ? "..." : "") + line.substr(std::min(begin, line.size()), most) +
               (begin + most < line.size() ? "..." : "");
        column = column - begin + (begin > 0 ? 3 : 0);
    }
    // What a terminal would obey is not shown to it.
    for (char& c : line) {
        if (is_control(c) && c != '\t') c = ' ';
    }
    // White space as wide as what is before the caret, tabs kept.
    std::string space;
    for (const char c : line.substr(0, column)) {
        if (!continues_character(c)) space += c == '\t' ? '\t' : ' ';
    }
    return line + '\n' + space + "^\n";
}

/// In the order of the source, notes behind what they belong to: each stage goes through the
/// source from its beginning.
std::vector<const Diagnostic*> sorted(const std::vector<Diagnostic>& diagnostics) {
    std::map<Location, std::vector<const Diagnostic*>> by_place;
    Location place;
    for (const Diagnostic& diagnostic : diagnostics) {
        if (diagnostic.severity != Severity::note) place = diagnostic.where;
        by_place[place].push_back(&diagnostic);
    }
    std::vector<const Diagnostic*> result;
    for (const auto& [where, group] : by_place) {
        result.insert(result.end(), group.begin(), group.end());
    }
    return result;
}

std::string included_from(const Diagnostic& diagnostic, const Source& source) {
    std::string text;
    auto place = source.included_from(diagnostic.where);
    for (; place; place = source.included_from(*place)) {
        text += format(Severity::note, source.position(*place), "included from here");
    }
    return text;
}

}  // namespace

std::string format(Severity severity, const Position& position, std::string_view text) {
    std::string result = position.file + ':' + std::to_string(position.line) + ':' +
                         std::to_string(position.column) + ": ";
    result += name(severity);
    result += ": ";
    result += text;
    return result + '\n' + excerpt(position);
}

std::string format(const Diagnostics& diagnostics, const Source& source) {
    std::string text;
    std::set<std::string> explained;
    for (const Diagnostic* diagnostic : sorted(diagnostics.all())) {
        const Position position = source.position(diagnostic->where);
        text += format(diagnostic->severity, position, diagnostic->text);
        if (diagnostic->severity != Severity::note && explained.insert(position.file).second) {
            text += included_from(*diagnostic, source);
        }
    }
    if (diagnostics.full())
        text += source.main_file() + ": too many errors, the rest is left out\n";
    return text;
}

}  // namespace canorb::idlc
