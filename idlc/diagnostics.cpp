#include "idlc/diagnostics.hpp"

#include <algorithm>
#include <map>
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
    last_was_dropped_ = std::any_of(all_.begin(), all_.end(), [&](const Diagnostic& earlier) {
        return earlier.where == where && earlier.text == text;
    });
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

/// White space as wide as what is before the column, tabs kept, and a caret.
std::string caret(const Position& position) {
    std::string line = position.source_line.substr(0, position.column - 1);
    for (char& c : line) {
        if (c != '\t') c = ' ';
    }
    return line + '^';
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

}  // namespace

std::string format(const Diagnostics& diagnostics, const Source& source) {
    std::string text;
    for (const Diagnostic* entry : sorted(diagnostics.all())) {
        const Diagnostic& diagnostic = *entry;
        const Position position = source.position(diagnostic.where);
        text += position.file + ':' + std::to_string(position.line) + ':' +
                std::to_string(position.column) + ": ";
        text += name(diagnostic.severity);
        text += ": " + diagnostic.text + '\n';
        text += position.source_line + '\n' + caret(position) + '\n';
    }
    if (diagnostics.full())
        text += source.main_file() + ": too many errors, the rest is left out\n";
    return text;
}

}  // namespace canorb::idlc
