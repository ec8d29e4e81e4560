#include "tests/layering/include_rules.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

namespace canorb::layering {
namespace {

/// A folder and the folders whose headers it may include. doc/architecture.md draws this table.
struct Folder {
    std::string_view name;
    std::vector<std::string_view> may_include;
    /// Neither threads, sockets, clocks nor output: time and octets are arguments and results.
    bool sans_io = false;
};

const std::vector<Folder>& folders() {
    static const std::vector<Folder> table{
        {"orb/base", {"orb/base"}, true},
        {"orb/ccdr", {"orb/ccdr", "orb/base"}, true},
        {"orb/giop", {"orb/giop", "orb/ccdr", "orb/base"}, true},
        {"orb/can", {"orb/can", "orb/base"}, true},
        {"orb/can/sim", {"orb/can/sim", "orb/can", "orb/base"}, true},
        {"orb/can/record", {"orb/can/record", "orb/can/sim", "orb/can", "orb/base"}},
        {"orb/can/link", {"orb/can/link", "orb/can/sim", "orb/can", "orb/base"}},
        {"orb/caniop", {"orb/caniop", "orb/can", "orb/base"}, true},
        {"orb/poa", {"orb/poa", "orb/giop", "orb/ccdr", "orb/base"}, true},
        {"orb/mca", {"orb/mca", "orb/poa", "orb/giop", "orb/ccdr", "orb/base"}, true},
        {"orb/core",
         {"orb/core", "orb/mca", "orb/poa", "orb/caniop", "orb/can", "orb/giop", "orb/ccdr",
          "orb/base"},
         true},
        {"orb/runtime",
         {"orb/runtime", "orb/core", "orb/mca", "orb/poa", "orb/caniop", "orb/can", "orb/can/sim",
          "orb/can/record", "orb/can/link", "orb/giop", "orb/ccdr", "orb/base", "canorb"}},
        {"orb/services",
         {"orb/services", "orb/runtime", "orb/core", "orb/mca", "orb/poa", "orb/caniop", "orb/can",
          "orb/giop", "orb/ccdr", "orb/base", "canorb"}},
        {"orb/hosted", {"orb", "canorb"}},
        {"orb/include", {"orb", "canorb"}},
        {"idlc", {"idlc"}},
        {"tools", {"tools", "orb", "canorb", "idlc"}},
        {"examples", {"examples", "canorb"}},
    };
    return table;
}

constexpr std::array<std::string_view, 27> io_headers{
    "thread",     "mutex",     "shared_mutex", "condition_variable",
    "future",     "semaphore", "latch",        "barrier",
    "stop_token", "iostream",  "fstream",      "filesystem",
    "ctime",      "time.h",    "pthread.h",    "unistd.h",
    "poll.h",     "fcntl.h",   "errno.h",      "cerrno",
    "signal.h",   "csignal",   "netdb.h",      "termios.h",
    "syslog.h",   "ifaddrs.h", "dlfcn.h"};

constexpr std::array<std::string_view, 8> io_header_folders{
    "sys/", "netinet/", "net/", "arpa/", "linux/", "asm/", "bits/", "boost/"};

constexpr std::array<std::string_view, 9> io_tokens{
    "::now(",    "sleep_for", "sleep_until", "thread_local", "random_device",
    "std::cout", "std::cerr", "std::getenv", "std::system("};

bool is_inside(std::string_view path, std::string_view folder) {
    return path.size() > folder.size() && path.starts_with(folder) && path[folder.size()] == '/';
}

/// The longest of the table's folders that holds `path`.
const Folder* folder_of(std::string_view path) {
    const Folder* result = nullptr;
    for (const Folder& folder : folders()) {
        if (is_inside(path, folder.name) &&
            (result == nullptr || folder.name.size() > result->name.size())) {
            result = &folder;
        }
    }
    return result;
}

/// The line without its comments. `in_comment` carries a /* from one line to the next.
std::string code_of(std::string_view line, bool& in_comment) {
    std::string code;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const std::string_view rest = line.substr(i);
        if (in_comment) {
            if (rest.starts_with("*/")) {
                in_comment = false;
                ++i;
            }
        } else if (rest.starts_with("//")) {
            break;
        } else if (rest.starts_with("/*")) {
            in_comment = true;
            ++i;
        } else {
            code += line[i];
        }
    }
    return code;
}

struct Include {
    std::string_view file;
    bool angled;
};

std::optional<Include> include_of(std::string_view code) {
    const auto skip_blanks = [&code] {
        code.remove_prefix(std::min(code.find_first_not_of(" \t"), code.size()));
    };
    skip_blanks();
    if (!code.starts_with('#')) return std::nullopt;
    code.remove_prefix(1);
    skip_blanks();
    if (!code.starts_with("include")) return std::nullopt;
    code.remove_prefix(std::string_view("include").size());
    skip_blanks();
    if (code.empty() || (code.front() != '"' && code.front() != '<')) return std::nullopt;
    const bool angled = code.front() == '<';
    const std::size_t end = code.find(angled ? '>' : '"', 1);
    if (end == std::string_view::npos) return std::nullopt;
    return Include{code.substr(1, end - 1), angled};
}

/// Where the house keeps an included file: a folder of the table, "canorb" for a public header,
/// nothing for the standard library, other libraries and generated headers.
std::optional<std::string_view> place_of(std::string_view file) {
    if (is_inside(file, "canorb")) return "canorb";
    if (const Folder* folder = folder_of(file)) return folder->name;
    if (is_inside(file, "orb")) return "orb";
    if (is_inside(file, "tests")) return "tests";
    return std::nullopt;
}

bool may_include(const Folder& folder, std::string_view place) {
    return std::any_of(
        folder.may_include.begin(), folder.may_include.end(), [place](std::string_view allowed) {
            // "orb" stands for everything below it; orb/can does not for orb/can/sim.
            return place == allowed || (allowed == "orb" && place.starts_with("orb/"));
        });
}

bool is_io_header(std::string_view file) {
    return std::find(io_headers.begin(), io_headers.end(), file) != io_headers.end() ||
           std::any_of(io_header_folders.begin(), io_header_folders.end(),
                       [file](std::string_view folder) { return file.starts_with(folder); });
}

}  // namespace

std::vector<std::string> violations(std::string_view path, std::string_view text) {
    const Folder* const folder = folder_of(path);
    if (folder == nullptr) return {};

    std::vector<std::string> result;
    std::size_t line_number = 0;
    const auto report = [&](const std::string& what) {
        result.push_back(std::string(path) + ':' + std::to_string(line_number) + ": " +
                         std::string(folder->name) + ' ' + what);
    };

    bool in_comment = false;
    while (!text.empty()) {
        const std::size_t length = std::min(text.find('\n'), text.size());
        const std::string code = code_of(text.substr(0, length), in_comment);
        text.remove_prefix(std::min(length + 1, text.size()));
        ++line_number;

        if (const auto include = include_of(code)) {
            const std::string file(include->file);
            if (file.find("..") != std::string::npos) {
                report("includes by a relative path: " + file);
            } else if (const auto place = place_of(file)) {
                if (!may_include(*folder, *place)) report("may not include " + file);
            } else if (folder->sans_io && include->angled && is_io_header(file)) {
                report("may do no input or output: <" + file + '>');
            }
        } else if (folder->sans_io) {
            for (const std::string_view token : io_tokens) {
                if (code.find(token) != std::string::npos) {
                    report("may not use " + std::string(token));
                }
            }
        }
    }
    return result;
}

}  // namespace canorb::layering
