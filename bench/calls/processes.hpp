#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>

namespace canorb::bench {

/// A child process, which ends with this object, or with its parent.
class Child {
  public:
    /// Runs `body` there, and nothing after it.
    explicit Child(const std::function<void()>& body);
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    bool is_running() const;

  private:
    pid_t pid_;
};

/// A daemon's bus, in a process of its own and with a socket of its own.
class Daemon {
  public:
    /// `cpu`: as pin_to(). Throws when it does not come up.
    Daemon(std::uint32_t bitrate, bool paced, int cpu);
    ~Daemon();
    Daemon(const Daemon&) = delete;
    Daemon& operator=(const Daemon&) = delete;

    const std::string& path() const { return path_; }
    std::string address() const { return "sim:" + path_; }

  private:
    const std::string path_;
    Child child_;
};

/// The calling thread, and all that it begins, run on this CPU of those that this process may use,
/// counted from 0, as far as there are so many; below 0: on any.
void pin_to(int cpu);
/// How many there are.
int cpus();

}  // namespace canorb::bench
