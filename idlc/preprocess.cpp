#include "idlc/preprocess.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

extern char** environ;

namespace canorb::idlc {

namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using TemporaryFile = std::unique_ptr<std::FILE, CloseFile>;

std::string content(std::FILE* file) {
    std::string text;
    std::array<char, 65536> buffer{};
    std::rewind(file);
    while (const std::size_t read = std::fread(buffer.data(), 1, buffer.size(), file)) {
        text.append(buffer.data(), read);
    }
    return text;
}

std::vector<std::string> command(const std::string& file, const PreprocessorOptions& options) {
    // -undef: `linux` and `unix` are good names in IDL. -dI: keeps the #include lines, which say
    // how a file is spelled.
    std::vector<std::string> words{"cpp", "-x", "c", "-C", "-undef", "-nostdinc", "-dI"};
    for (const std::string& directory : options.include_directories) {
        words.push_back("-I");
        words.push_back(directory);
    }
    for (const std::string& macro : options.macros) {
        words.push_back("-D");
        words.push_back(macro);
    }
    // A file called -x is a file.
    words.push_back(file.starts_with('-') ? "./" + file : file);
    return words;
}

/// Runs the command with standard output and error into the files; its exit code, or -errno.
int run(std::vector<std::string> words, std::FILE* output, std::FILE* errors) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(output), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(errors), STDERR_FILENO);
    pid_t child = 0;
    const int failed =
        posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) return -failed;

    int status = 0;
    while (waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) return -errno;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

}  // namespace

Preprocessed preprocess(const std::string& file, const PreprocessorOptions& options) {
    Preprocessed result;
    // Files, not pipes: two pipes would need two readers at once.
    const TemporaryFile output{std::tmpfile()};
    const TemporaryFile errors{std::tmpfile()};
    if (!output || !errors) {
        result.message =
            std::string{"cannot make a temporary file: "} + std::strerror(errno) + '\n';
        return result;
    }
    const int code = run(command(file, options), output.get(), errors.get());
    if (code < 0) {
        result.message = std::string{"cannot run the C preprocessor 'cpp': "} +
                         std::strerror(-code) + " (on Debian: apt install cpp)\n";
        return result;
    }
    result.ok = code == 0;
    result.text = content(output.get());
    result.message = content(errors.get());
    if (!result.ok && result.message.empty()) result.message = "the C preprocessor failed\n";
    return result;
}

}  // namespace canorb::idlc
