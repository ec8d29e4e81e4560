#pragma once

#include <termios.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "orb/base/result.hpp"
#include "orb/can/link/descriptor.hpp"

namespace canorb::can {

/// Whether Linux has this speed of serial lines, in bit/s.
bool is_baud(std::uint32_t baud);

/// A terminal that carries octets: raw, 8 data bits, no parity, 1 stop bit, no flow control.
/// Nobody else can open it, and it gets its settings back when it is closed. Only drain() blocks.
class SerialPort {
  public:
    /// None.
    SerialPort() = default;
    SerialPort(SerialPort&&) = default;
    SerialPort& operator=(SerialPort&& other) noexcept;
    ~SerialPort() { close(); }

    /// `baud`: is_baud(). The error is a sentence for people.
    static Result<SerialPort, std::string> open(const std::string& device, std::uint32_t baud);

    bool is_open() const { return descriptor_.is_open(); }
    int fd() const { return descriptor_.get(); }

    /// How many octets it read; 0 when there are none now, nothing when the terminal is gone.
    std::optional<std::size_t> read(std::span<char> buffer) const;
    /// How many octets it took; 0 when there is no room now, nothing when the terminal is gone.
    std::optional<std::size_t> write(std::string_view octets) const;

    /// Waits until what was written is sent, 100 ms at most.
    void drain() const;

    /// What is not sent by now is lost.
    void close();

  private:
    SerialPort(Descriptor descriptor, const termios& before)
        : descriptor_(std::move(descriptor)), before_(before) {}

    /// Octets that are written but not sent.
    int unsent() const;

    Descriptor descriptor_;
    termios before_{};
};

}  // namespace canorb::can
