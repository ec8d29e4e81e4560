#include "serial_terminal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace tank {

namespace {

int checked(int result, const char* what) {
    if (result < 0) throw std::system_error(errno, std::generic_category(), what);
    return result;
}

}  // namespace

FileDescriptor::~FileDescriptor() {
    if (number_ >= 0) ::close(number_);
}

void set_raw_115200_8n1(int file_descriptor) {
    termios settings{};
    checked(::tcgetattr(file_descriptor, &settings), "reading the line's settings");
    ::cfmakeraw(&settings);
    settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB);
    settings.c_cflag |= CLOCAL | CREAD;
    checked(::cfsetspeed(&settings, B115200), "setting the line's speed");
    checked(::tcsetattr(file_descriptor, TCSANOW, &settings), "setting up the line");
}

SerialTerminal::SerialTerminal()
    : master_(checked(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC),
                      "opening a pseudo-terminal")) {
    checked(::grantpt(master_.number()), "opening a pseudo-terminal");
    checked(::unlockpt(master_.number()), "opening a pseudo-terminal");
    char path[64];
    if (const int error = ::ptsname_r(master_.number(), path, sizeof path); error != 0)
        throw std::system_error(error, std::generic_category(), "naming the pseudo-terminal");
    path_ = path;
    // Opened and closed once: from now on the master tells whether there is anybody.
    const FileDescriptor slave{checked(::open(path, O_RDWR | O_NOCTTY | O_CLOEXEC), path)};
    set_raw_115200_8n1(slave.number());
}

std::optional<char> SerialTerminal::read() {
    char character = 0;
    // It fails while nobody has the line open, once everything that came before is read.
    if (::read(master_.number(), &character, 1) == 1) return character;
    return std::nullopt;
}

void SerialTerminal::write(std::string_view text) {
    // Kept for nobody, old text would be the first that the next reader sees.
    pollfd state{.fd = master_.number(), .events = POLLOUT, .revents = 0};
    if (::poll(&state, 1, 0) < 0 || (state.revents & POLLHUP) != 0) return;
    if (line_broken_ && ::write(master_.number(), "\r\n", 2) != 2) return;
    const ssize_t written = ::write(master_.number(), text.data(), text.size());
    line_broken_ = written != static_cast<ssize_t>(text.size());
}

}  // namespace tank
