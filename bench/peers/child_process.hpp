// Programs started for a measurement, and what makes sure that none of them outlives it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace peers {

/// The user ended the measurement.
class Interrupted : public std::runtime_error {
  public:
    Interrupted() : std::runtime_error("interrupted") {}
};

/// To be called first in main(), before there are other threads: SIGINT, SIGTERM and SIGHUP no
/// longer end the process, but make throw_if_interrupted() throw. A process that does not end
/// within two seconds is ended, with its children and temporary directories.
void handle_signals();
void throw_if_interrupted();

/// Another program, or this one again. What it prints is for the parent, and it dies with it.
class Child {
  public:
    /// Pinned to one CPU, if one is given, before it runs.
    explicit Child(const std::vector<std::string>& command, std::optional<int> cpu = {});
    ~Child() { stop(); }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    pid_t pid() const { return pid_; }
    /// The next line it prints, without its end.
    std::string read_line(std::chrono::milliseconds timeout = std::chrono::seconds{20});
    /// Waits for its end, which must be a successful one. Returns what else it printed.
    std::string finish(std::chrono::milliseconds timeout);

  private:
    void stop();
    bool read_some(std::chrono::steady_clock::time_point deadline);

    std::string name_;
    pid_t pid_ = -1;
    int output_ = -1;
    std::string text_;
};

class TemporaryDirectory {
  public:
    TemporaryDirectory();
    ~TemporaryDirectory();
    TemporaryDirectory(const TemporaryDirectory&) = delete;
    TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// The file of this program, to start it again.
std::string own_program();
/// A program that was built beside this one.
std::string program_beside(const std::string& name);

}  // namespace peers
