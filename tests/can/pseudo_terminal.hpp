#pragma once

#include <poll.h>
#include <pty.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
#include <string_view>

#include "orb/can/link/descriptor.hpp"

namespace canorb::can::test {

/// A serial line: what is tested opens device(), and the peer is this end of it.
class PseudoTerminal {
  public:
    PseudoTerminal() {
        int peer = -1;
        int device = -1;
        std::string name(64, '\0');
        termios raw{};
        ::cfmakeraw(&raw);
        raw.c_cflag |= CREAD;
        ::cfsetspeed(&raw, B9600);
        if (::openpty(&peer, &device, name.data(), &raw, nullptr) != 0) {
            throw std::runtime_error("no pseudo-terminal");
        }
        name.resize(name.find('\0'));
        name_ = name;
        peer_ = Descriptor{peer};
        device_ = Descriptor{device};
    }

    const std::string& device() const { return name_; }
    int peer() const { return peer_.get(); }

    void write(std::string_view octets) const {
        while (!octets.empty()) {
            const ssize_t count = ::write(peer(), octets.data(), octets.size());
            if (count < 0 && errno != EINTR) throw std::runtime_error("the line does not take it");
            if (count > 0) octets.remove_prefix(static_cast<std::size_t>(count));
        }
    }

    /// The next `count` octets; fewer when they do not come in time.
    std::string read(std::size_t count, int patience_ms = 20'000) const {
        std::string octets;
        pollfd readable{peer(), POLLIN, 0};
        while (octets.size() < count && ::poll(&readable, 1, patience_ms) == 1) {
            std::string piece(count - octets.size(), '\0');
            const ssize_t got = ::read(peer(), piece.data(), piece.size());
            if (got <= 0) break;
            octets.append(piece, 0, static_cast<std::size_t>(got));
        }
        return octets;
    }

    /// Whether somebody has the device for himself.
    bool is_in_use() const {
        if (::flock(device_.get(), LOCK_EX | LOCK_NB) != 0) return true;
        ::flock(device_.get(), LOCK_UN);
        return false;
    }

    termios settings() const {
        termios result{};
        ::tcgetattr(device_.get(), &result);
        return result;
    }

    /// Whoever has it open sees it go.
    void unplug() {
        device_.reset();
        peer_.reset();
    }

  private:
    std::string name_;
    Descriptor peer_;
    Descriptor device_;  ///< keeps the line alive while nobody else has it open
};

}  // namespace canorb::can::test
