#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace canorb::test {

struct ShellResult {
    int exit_code = 0;
    std::string output;
};

/// Runs a command of the shell to its end. "2>&1" in it for the errors, too.
inline ShellResult shell(const std::string& command) {
    std::FILE* const pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) throw std::runtime_error("no shell");
    ShellResult result;
    std::array<char, 4096> buffer;
    while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
        result.output.append(buffer.data(), got);
    }
    const int status = ::pclose(pipe);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

inline bool has_program(const std::string& name) {
    return shell("command -v " + name).exit_code == 0;
}

}  // namespace canorb::test
