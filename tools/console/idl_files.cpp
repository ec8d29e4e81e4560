#include "tools/console/idl_files.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>

#include "orb/can/link/descriptor.hpp"
#include "tools/console/node_idl.hpp"

extern char** environ;

namespace canorb::console {
namespace {

std::string error_text(int error) {
    return std::generic_category().message(error);
}

/// All that can be read; nothing on an error, which is in errno.
std::optional<std::string> read_all(int descriptor) {
    std::string text;
    std::array<char, 65536> buffer;
    while (true) {
        const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
        if (got == 0) return text;
        if (got < 0 && errno != EINTR) return std::nullopt;
        if (got > 0) text.append(buffer.data(), static_cast<std::size_t>(got));
    }
}

/// The compiler that was installed or built with this program, else the one that PATH leads to.
std::string compiler() {
    std::error_code ignored;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", ignored);
    const auto beside = self.parent_path() / "canorb-idlc";
    return ::access(beside.c_str(), X_OK) == 0 ? beside.string() : "canorb-idlc";
}

Result<std::string, std::string> compile(const std::string& file,
                                         const std::vector<std::string>& directories) {
    std::vector<std::string> arguments{compiler(), "--emit", "json"};
    for (const std::string& directory : directories) arguments.push_back("-I" + directory);
    arguments.insert(arguments.end(), {"--", file});
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);

    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) return Failure{"no pipe: " + error_text(errno)};
    const can::Descriptor input{ends[0]};
    std::optional<can::Descriptor> output{ends[1]};
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, output->get(), STDOUT_FILENO);
    pid_t process = 0;
    const int error = ::posix_spawnp(&process, argv[0], &actions, nullptr, argv.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    output.reset();
    if (error != 0) {
        return Failure{
            "cannot run " + arguments[0] + ": " + error_text(error) +
            ". It must be beside this program or in PATH; or give what its --emit json " +
            "writes with --idl-json"};
    }
    auto text = read_all(input.get());
    int status = 0;
    while (::waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
    if (!text || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
        return Failure{"canorb-idlc did not compile " + file};
    return *std::move(text);
}

Result<std::string, std::string> read_file(const std::string& path) {
    const can::Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    auto text = file.get() >= 0 ? read_all(file.get()) : std::nullopt;
    if (!text) return Failure{"cannot read " + path + ": " + error_text(errno)};
    return *std::move(text);
}

}  // namespace

Result<std::unique_ptr<Model>, std::string> load(const IdlFiles& files) {
    auto model = std::make_unique<Model>();
    if (const auto error = model->add(node_idl_json, "canorb/node.idl")) return Failure{*error};
    const auto add = [&](const Result<std::string, std::string>& json, const std::string& source) {
        return json ? model->add(*json, source) : std::optional{json.error()};
    };
    for (const std::string& path : files.json) {
        if (const auto error = add(read_file(path), path)) return Failure{*error};
    }
    for (const std::string& path : files.idl) {
        if (const auto error = add(compile(path, files.directories), path)) return Failure{*error};
    }
    return model;
}

}  // namespace canorb::console
