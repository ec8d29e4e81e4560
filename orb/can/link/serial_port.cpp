#include "orb/can/link/serial_port.hpp"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

namespace canorb::can {
namespace {

constexpr std::array<std::pair<std::uint32_t, speed_t>, 19> speeds{{
    {2400, B2400},       {4800, B4800},       {9600, B9600},       {19200, B19200},
    {38400, B38400},     {57600, B57600},     {115200, B115200},   {230400, B230400},
    {460800, B460800},   {500000, B500000},   {576000, B576000},   {921600, B921600},
    {1000000, B1000000}, {1500000, B1500000}, {2000000, B2000000}, {2500000, B2500000},
    {3000000, B3000000}, {3500000, B3500000}, {4000000, B4000000},
}};

std::optional<speed_t> speed_of(std::uint32_t baud) {
    for (const auto& [rate, speed] : speeds) {
        if (rate == baud) return speed;
    }
    return std::nullopt;
}

std::string no_permission(const std::string& device) {
    const std::string problem = "no permission to use " + device + ": ";
    struct stat status{};
    if (::stat(device.c_str(), &status) != 0) return problem + error_text(errno);
    std::array<char, 4096> buffer;
    constexpr mode_t group_may = S_IRGRP | S_IWGRP;
    if ((status.st_mode & group_may) == group_may) {
        group entry{};
        group* found = nullptr;
        ::getgrgid_r(status.st_gid, &entry, buffer.data(), buffer.size(), &found);
        const std::string name = found != nullptr ? found->gr_name : std::to_string(status.st_gid);
        return problem + "add yourself to the group " + name + " (usermod -aG " + name +
               " USER) and log in again";
    }
    passwd entry{};
    passwd* found = nullptr;
    ::getpwuid_r(status.st_uid, &entry, buffer.data(), buffer.size(), &found);
    return problem + "it is for the user " +
           (found != nullptr ? found->pw_name : std::to_string(status.st_uid)) + " only";
}

std::string cannot_open(const std::string& device, int error) {
    switch (error) {
        case ENOENT:
            return "there is no " + device + ": is the adapter plugged in, is that its name?";
        case EACCES:
        case EPERM:
            return no_permission(device);
        case EBUSY:
        case EWOULDBLOCK:
            return device + " is in use by another program";
        default:
            return "cannot open " + device + ": " + error_text(error);
    }
}

}  // namespace

bool is_baud(std::uint32_t baud) {
    return speed_of(baud).has_value();
}

Result<SerialPort, std::string> SerialPort::open(const std::string& device, std::uint32_t baud) {
    Descriptor descriptor{::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (!descriptor.is_open()) return Failure{cannot_open(device, errno)};
    termios before{};
    if (::tcgetattr(descriptor.get(), &before) != 0) {
        return Failure{device +
                       " is not a terminal: slcan: takes a serial port such as "
                       "/dev/ttyACM0"};
    }
    // The lock also keeps out the superuser, whom TIOCEXCL lets pass.
    if (::flock(descriptor.get(), LOCK_EX | LOCK_NB) != 0) {
        return Failure{cannot_open(device, errno)};
    }
    ::ioctl(descriptor.get(), TIOCEXCL);
    SerialPort port{std::move(descriptor), before};

    termios raw = before;
    ::cfmakeraw(&raw);
    raw.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
    raw.c_cflag |= CLOCAL | CREAD;
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    const speed_t speed = speed_of(baud).value_or(B115200);
    if (::cfsetispeed(&raw, speed) != 0 || ::cfsetospeed(&raw, speed) != 0 ||
        ::tcsetattr(port.fd(), TCSANOW, &raw) != 0) {
        return Failure{device + " cannot be set to " + std::to_string(baud) +
                       " baud, 8N1: " + error_text(errno)};
    }
    ::tcflush(port.fd(), TCIFLUSH);
    return port;
}

SerialPort& SerialPort::operator=(SerialPort&& other) noexcept {
    if (this != &other) {
        close();
        descriptor_ = std::move(other.descriptor_);
        before_ = other.before_;
    }
    return *this;
}

std::optional<std::size_t> SerialPort::read(std::span<char> buffer) const {
    while (true) {
        const ssize_t count = ::read(fd(), buffer.data(), buffer.size());
        if (count > 0) return static_cast<std::size_t>(count);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno == EAGAIN) return 0;
        return std::nullopt;  // the end of file of a terminal is its removal
    }
}

std::optional<std::size_t> SerialPort::write(std::string_view octets) const {
    while (true) {
        const ssize_t count = ::write(fd(), octets.data(), octets.size());
        if (count >= 0) return static_cast<std::size_t>(count);
        if (errno == EINTR) continue;
        if (errno == EAGAIN) return 0;
        return std::nullopt;
    }
}

int SerialPort::unsent() const {
    int octets = 0;
    return ::ioctl(fd(), TIOCOUTQ, &octets) == 0 ? octets : 0;
}

void SerialPort::drain() const {
    // tcdrain() need not end with a device that takes nothing.
    for (int waited = 0; unsent() > 0 && waited < 100; ++waited) {
        std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
}

void SerialPort::close() {
    if (!is_open()) return;
    // Else the kernel waits for the device up to 30 s.
    if (unsent() > 0) ::tcflush(fd(), TCOFLUSH);
    ::tcsetattr(fd(), TCSANOW, &before_);
    ::ioctl(fd(), TIOCNXCL);
    descriptor_.reset();
}

}  // namespace canorb::can
