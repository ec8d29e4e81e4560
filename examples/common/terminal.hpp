#pragma once

/// A whole terminal to draw on, with ncurses.

#define NCURSES_NOMACROS
#include <curses.h>

#include <chrono>
#include <string_view>

namespace common {

enum class Colour : short { cyan = 1, yellow, red, green };

/// What put() takes; nothing where the terminal has no colours.
chtype colour(Colour pair);

/// The terminal while ncurses has it: given back however this ends. Keys come one by one, and are
/// not shown.
class Terminal {
  public:
    /// `patience` is how long wgetch() waits for a key; 0: not at all.
    explicit Terminal(std::chrono::milliseconds patience);
    ~Terminal();
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    /// False: this terminal cannot be drawn on, and nothing was done.
    bool works() const { return screen_ != nullptr; }

  private:
    SCREEN* screen_;
};

void put(int row, int column, std::string_view text, chtype attributes = A_NORMAL);

}  // namespace common
