#include "keyboard.hpp"

#include <unistd.h>

namespace tank {

bool has_keyboard() {
    return ::isatty(STDIN_FILENO) != 0 && ::tcgetpgrp(STDIN_FILENO) == ::getpgrp();
}

KeyboardMode::KeyboardMode() {
    termios settings{};
    if (!has_keyboard() || ::tcgetattr(STDIN_FILENO, &settings) != 0) return;
    before_ = settings;
    // Ctrl-C and its like go on making signals.
    settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    settings.c_cc[VMIN] = 1;
    settings.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &settings);
}

KeyboardMode::~KeyboardMode() {
    if (before_) ::tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
}

}  // namespace tank
