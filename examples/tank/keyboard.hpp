#pragma once

#include <termios.h>

#include <optional>

namespace tank {

/// Whether keys that are typed come to this program: its standard input is a terminal, and it is
/// not in the background.
bool has_keyboard();

/// While one exists, keys come one by one and are not shown; then as before. It changes nothing
/// where there is no keyboard.
class KeyboardMode {
  public:
    KeyboardMode();
    ~KeyboardMode();
    KeyboardMode(const KeyboardMode&) = delete;
    KeyboardMode& operator=(const KeyboardMode&) = delete;

  private:
    std::optional<termios> before_;
};

}  // namespace tank
