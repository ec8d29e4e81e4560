#pragma once

#include <string>
#include <utility>

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

/// What `error` (an errno) means, in words.
std::string error_text(int error);

}  // namespace canorb::can
