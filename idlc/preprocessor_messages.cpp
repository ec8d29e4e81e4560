#include "idlc/preprocessor_messages.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "idlc/diagnostics.hpp"
#include "idlc/files.hpp"

namespace canorb::idlc {

namespace {

namespace fs = std::filesystem;

struct Message {
    Severity severity;
    Position position;
    std::string text;
};

struct SeverityWord {
    std::string_view word;
    Severity severity;
};

constexpr SeverityWord severity_words[] = {
    {": fatal error: ", Severity::error},
    {": error: ", Severity::error},
    {": warning: ", Severity::warning},
    {": note: ", Severity::note},
};

/// Takes ":number" from the back of `text`.
std::optional<std::uint32_t> take_number(std::string_view& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string_view::npos) return std::nullopt;
    std::uint32_t number = 0;
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, number);
    if (error != std::errc{} || rest != end) return std::nullopt;
    text = text.substr(0, colon);
    return number;
}

std::string source_line(const std::string& file, std::uint32_t number) {
    const std::string text = read_file(file).value_or("");
    std::size_t begin = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
    for (std::uint32_t line = 1; line < number; ++line) {
        const std::size_t end = text.find('\n', begin);
        if (end == std::string::npos) return {};
        begin = end + 1;
    }
    std::string line = text.substr(begin, text.find('\n', begin) - begin);
    if (line.ends_with('\r')) line.pop_back();
    return line;
}

/// "file:line:column", the column may lack.
std::optional<Position> position(std::string_view text) {
    const auto last = take_number(text);
    if (!last) return std::nullopt;
    const auto line = take_number(text);
    Position position;
    position.file = text;
    position.line = line.value_or(*last);
    position.source_line = source_line(position.file, position.line);
    position.column = line ? std::max(*last, 1U) : 1;
    if (!line) {
        const std::size_t text_begin = position.source_line.find_first_not_of(" \t");
        if (text_begin != std::string::npos) {
            position.column = static_cast<std::uint32_t>(text_begin + 1);
        }
    }
    return position;
}

std::optional<Message> message(std::string_view line) {
    for (const auto& [word, severity] : severity_words) {
        const std::size_t at = line.find(word);
        if (at == std::string_view::npos) continue;
        auto where = position(line.substr(0, at));
        if (!where) return std::nullopt;
        std::string text{line.substr(at + word.size())};
        // "[-Wcpp]" is an option of the preprocessor, not of this program.
        if (const std::size_t option = text.rfind(" [-W"); option != std::string::npos) {
            text.resize(option);
        }
        return Message{severity, *std::move(where), std::move(text)};
    }
    return std::nullopt;
}

/// "In file included from main.idl:1:" and the "from" lines below it.
std::optional<Position> including_place(std::string_view line) {
    constexpr std::string_view from = "from ";
    const std::size_t at = line.find(from);
    if (at == std::string_view::npos) return std::nullopt;
    const std::string_view before = line.substr(0, at);
    if (before != "In file included " && before.find_first_not_of(' ') != std::string_view::npos) {
        return std::nullopt;
    }
    line.remove_prefix(at + from.size());
    while (line.ends_with(',') || line.ends_with(':')) line.remove_suffix(1);
    return position(line);
}

bool is_of_no_use(const Message& message) {
    if (message.severity != Severity::warning) return false;
    // The lexer says of a literal without end what is wrong; #endif NAME is an old custom.
    for (const char* text : {"missing terminating", "#pragma once in main file",
                             "extra tokens at end of #endif", "extra tokens at end of #else"}) {
        if (message.text.starts_with(text)) return true;
    }
    return false;
}

/// The name that an #include line has, with its quotes or angle brackets, and where that begins.
struct IncludedName {
    std::string text;
    std::size_t at;
};

std::optional<IncludedName> included_name(const std::string& line) {
    const std::size_t keyword = line.find("include");
    if (keyword == std::string::npos) return std::nullopt;
    const std::size_t open = line.find_first_of("\"<", keyword);
    if (open == std::string::npos) return std::nullopt;
    const std::size_t close = line.find(line[open] == '<' ? '>' : '"', open + 1);
    if (close == std::string::npos) return std::nullopt;
    return IncludedName{line.substr(open, close - open + 1), open};
}

bool is_missing_file(const Message& message) {
    return message.severity == Severity::error &&
           (message.text.ends_with(": No such file or directory") ||
            message.text.ends_with("file not found") ||
            message.text.starts_with("no include path in which to search for "));
}

/// `file` in `directory`, which is what `why` names.
std::string tried(const fs::path& directory, const std::string& file, const std::string& why) {
    std::error_code ignored;
    const bool exists = directory.empty() || fs::is_directory(directory, ignored);
    return "  " + (directory / file).string() + "  (" + why +
           (exists ? "" : ", which does not exist") + ")\n";
}

/// Where the preprocessor looks, in its order.
std::string paths_tried(const std::string& name, const Position& position,
                        const std::vector<std::string>& include_directories) {
    const std::string file = name.substr(1, name.size() - 2);
    const bool quoted = name.front() == '"';
    if (fs::path{file}.is_absolute()) return "tried:\n" + tried({}, file, "as written");
    std::string text;
    if (quoted) {
        text += tried(fs::path{position.file}.parent_path(), file,
                      "the directory of the including file");
    }
    for (const std::string& directory : include_directories) {
        text += tried(directory, file, "-I " + directory);
    }
    if (text.empty()) {
        return "tried: nothing. <> looks in the directories of -I only, and none is given\n";
    }
    return "tried, in this order:\n" + text;
}

std::string missing_file(Message message, const std::vector<std::string>& include_directories) {
    Position& position = message.position;
    const auto name = included_name(position.source_line);
    // The name comes from a macro: all there is to say is what the preprocessor says.
    if (!name) return format(message.severity, position, message.text);
    position.column = static_cast<std::uint32_t>(name->at + 1);
    return format(Severity::error, position, "cannot find the included file " + name->text) +
           paths_tried(name->text, position, include_directories) +
           "(-I DIRECTORY names one more directory to look in)\n";
}

std::string formatted(Message message, const std::vector<std::string>& include_directories) {
    if (is_missing_file(message)) return missing_file(std::move(message), include_directories);
    if (message.text.starts_with("#include nested depth")) {
        message.text =
            "#include goes too deep: does a file include itself? #ifndef, #define and "
            "#endif around its content prevent that";
    }
    return format(message.severity, message.position, message.text);
}

}  // namespace

std::string preprocessor_messages(std::string_view written,
                                  const std::vector<std::string>& include_directories) {
    constexpr std::size_t most_including_places = 3;
    std::string text;
    std::vector<Position> from;
    std::string not_understood;
    std::size_t errors = 0;
    bool understood = false;
    while (!written.empty()) {
        const std::size_t end = std::min(written.find('\n'), written.size());
        const std::string_view line = written.substr(0, end);
        written.remove_prefix(std::min(end + 1, written.size()));
        if (auto place = including_place(line)) {
            from.push_back(*std::move(place));
            continue;
        }
        auto found = message(line);
        if (!found) {
            // "cpp: error: ...", "<command-line>: error: ..."
            const bool is_error = line.find("error: ") != std::string_view::npos;
            (is_error ? text : not_understood).append(line).append("\n");
            understood = understood || is_error;
            continue;
        }
        understood = true;
        if (!is_of_no_use(*found)) {
            if (found->severity == Severity::error) ++errors;
            if (errors > Diagnostics::most_errors)
                return text + "too many errors, the rest is left out\n";
            text += formatted(*std::move(found), include_directories);
            for (std::size_t i = 0; i < from.size() && i < most_including_places; ++i) {
                text += format(Severity::note, from[i], "included from here");
            }
        }
        from.clear();
    }
    // Beside messages these are excerpts of the source, which are in them already.
    return understood ? text : not_understood;
}

}  // namespace canorb::idlc
