#include "idlc/files.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace canorb::idlc {

namespace {

namespace fs = std::filesystem;

bool is_regular(const std::string& name) {
    std::error_code ignored;
    return fs::is_regular_file(name, ignored);
}

std::string escape_for_make(const std::string& name) {
    std::string escaped;
    for (const char c : name) {
        if (c == ' ' || c == '#') escaped += '\\';
        if (c == '$') escaped += '$';
        escaped += c;
    }
    return escaped;
}

}  // namespace

std::optional<std::string> read_file(const std::string& name) {
    // A device such as /dev/zero has no end.
    if (!is_regular(name)) return std::nullopt;
    std::ifstream file{name, std::ios::binary};
    if (!file) return std::nullopt;
    return std::string{std::istreambuf_iterator<char>{file}, {}};
}

std::string write_file(const std::string& name, std::string_view content) {
    if (read_file(name) == content) return {};
    errno = 0;
    std::ofstream file{name, std::ios::binary | std::ios::trunc};
    const bool opened = file.is_open();
    file << content;
    file.close();
    if (file) return {};
    const std::string reason = errno != 0 ? std::strerror(errno) : "unknown error";
    std::error_code ignored;
    if (opened && is_regular(name)) fs::remove(name, ignored);
    return "cannot be written: " + reason;
}

std::string make_rule(const std::vector<std::string>& outputs,
                      const std::vector<std::string>& inputs) {
    std::string text;
    for (const std::string& output : outputs) {
        if (!text.empty()) text += ' ';
        text += escape_for_make(output);
    }
    text += ':';
    for (const std::string& input : inputs) text += " \\\n  " + escape_for_make(input);
    return text + '\n';
}

}  // namespace canorb::idlc
