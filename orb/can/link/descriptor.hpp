#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "orb/base/time.hpp"

namespace canorb::can {

/// A file descriptor that closes itself. -1 is none.
class Descriptor {
  public:
    Descriptor() = default;
    explicit Descriptor(int fd) : fd_(fd) {}
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        if (this != &other) {
            reset();
            fd_ = std::exchange(other.fd_, -1);
        }
        return *this;
    }
    ~Descriptor() { reset(); }

    int get() const { return fd_; }
    bool is_open() const { return fd_ >= 0; }
    void reset();

  private:
    int fd_ = -1;
};

/// A descriptor that is readable from raise() until clear(): wakes who waits in poll(). Any
/// thread, and raise() from a signal handler too.
class Signal {
  public:
    Signal();

    bool is_open() const { return fd_.is_open(); }
    int fd() const { return fd_.get(); }
    void raise() const;
    void clear() const;

  private:
    Descriptor fd_;
};

/// A descriptor that is readable when its time has come, on CLOCK_MONOTONIC. For one thread at a
/// time.
class Timer {
  public:
    Timer();

    bool is_open() const { return fd_.is_open(); }
    int fd() const { return fd_.get(); }
    /// In place of what was set before. `due` is after the clock's start.
    void set_at(TimePoint due) const;
    /// After `delay`, which is more than 0.
    void set_after(Duration delay) const;
    /// After `interval`, and again after each.
    void repeat(Duration interval) const;
    void stop() const;
    /// Whether its time has come; then the descriptor is readable no more.
    bool take_expiry() const;

  private:
    Descriptor fd_;
};

/// Adds `fd` to an epoll set: wakes who waits for `epoll` when it is readable.
void watch(const Descriptor& epoll, int fd);

/// Whether a descriptor that is in the set wakes also when it is writable.
void watch_writable(const Descriptor& epoll, int fd, bool on);

/// What `error` (an errno) means, in words.
std::string error_text(int error);

}  // namespace canorb::can
