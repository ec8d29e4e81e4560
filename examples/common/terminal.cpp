#include "common/terminal.hpp"

#include <clocale>
#include <cstdio>

namespace common {

Terminal::Terminal(std::chrono::milliseconds patience) {
    // For the terminal's characters only: numbers stay as they are.
    std::setlocale(LC_CTYPE, "");
    screen_ = ::newterm(nullptr, stdout, stdin);
    if (screen_ == nullptr) return;
    ::cbreak();
    ::noecho();
    ::keypad(stdscr, true);
    ::curs_set(0);
    ::wtimeout(stdscr, static_cast<int>(patience.count()));
    if (::has_colors()) {
        ::start_color();
        ::use_default_colors();
        const auto on_background = [](Colour name, short number) {
            ::init_pair(static_cast<short>(name), number, -1);
        };
        on_background(Colour::cyan, COLOR_CYAN);
        on_background(Colour::yellow, COLOR_YELLOW);
        on_background(Colour::red, COLOR_RED);
        on_background(Colour::green, COLOR_GREEN);
    }
}

Terminal::~Terminal() {
    if (screen_ == nullptr) return;
    ::endwin();
    ::delscreen(screen_);
}

void put(int row, int column, std::string_view text, chtype attributes) {
    ::wattron(stdscr, static_cast<int>(attributes));
    ::wmove(stdscr, row, column);
    ::waddnstr(stdscr, text.data(), static_cast<int>(text.size()));
    ::wattroff(stdscr, static_cast<int>(attributes));
}

chtype colour(Colour pair) {
    return static_cast<chtype>(COLOR_PAIR(static_cast<short>(pair)));
}

}  // namespace common
