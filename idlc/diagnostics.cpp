#include "idlc/diagnostics.hpp"

#include <algorithm>
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
    struct Entry {
        Location group;
        const Diagnostic* diagnostic;
    };
    std::vector<Entry> entries;
    for (const Diagnostic& diagnostic : diagnostics) {
        const bool is_note = diagnostic.severity == Severity::note && !entries.empty();
        entries.push_back({is_note ? entries.back().group : diagnostic.where, &diagnostic});
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.group < b.group; });
    std::vector<const Diagnostic*> result;
    for (const Entry& entry : entries) result.push_back(entry.diagnostic);
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
