#include "screen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>

#include "common/terminal.hpp"

namespace plant {

namespace {

using common::Colour;
using common::colour;
using common::put;

constexpr std::size_t most_told = 200;
constexpr int box_columns = 26;
constexpr int gap_columns = 1;
constexpr int ctrl_l = 0x0C;  // draws all anew, on a terminal where others wrote

chtype look_of(Mark mark) {
    switch (mark) {
        case Mark::good:
            return colour(Colour::green);
        case Mark::bad:
            return colour(Colour::red) | A_BOLD;
        case Mark::none:
            break;
    }
    return A_NORMAL;
}

class CursesScreen final : public Screen {
  public:
    CursesScreen(std::string title, std::vector<std::string> names)
        : title_(std::move(title)),
          names_(std::move(names)),
          panels_(names_.size()),
          keys_(names_.size()) {}

    bool works() const { return terminal_.works(); }

    void show(std::size_t panel, Panel content) override { panels_.at(panel) = std::move(content); }

    void tell(std::string_view line) override {
        told_.emplace_back(line);
        if (told_.size() > most_told) told_.pop_front();
    }

    std::optional<Keys::Typed> next_command() override {
        int key = 0;
        while ((key = ::wgetch(stdscr)) != ERR) {
            if (key == ctrl_l) ::redrawwin(stdscr);
            if (key == KEY_BACKSPACE || key == 0x7F) key = Keys::backspace;
            if (key == KEY_ENTER || key == '\r') key = Keys::enter;
            if (auto typed = keys_.take(key)) return typed;
        }
        return std::nullopt;
    }

    bool quit() const override { return keys_.quit(); }

    void draw() override {
        ::werase(stdscr);
        const int rows = ::getmaxy(stdscr);
        const int columns = ::getmaxx(stdscr);
        put_line(0, 0, columns, title_, A_BOLD);
        int row = draw_box(0, 1, 0, columns);
        int column = 0;
        int row_below = row;
        for (std::size_t i = 1; i < panels_.size(); ++i) {
            if (column + box_columns > columns) {
                column = 0;
                row = row_below;
            }
            row_below = std::max(row_below, draw_box(i, row, column, box_columns));
            column += box_columns + gap_columns;
        }
        draw_told(row_below, rows - 1, columns);
        draw_bottom(rows - 1, columns);
        ::wrefresh(stdscr);
    }

  private:
    // As much of the text as there is room for.
    static void put_line(int row, int column, int width, std::string_view text, chtype look) {
        if (row >= ::getmaxy(stdscr) || width <= 0) return;
        put(row, column, text.substr(0, static_cast<std::size_t>(width)), look);
    }

    // The row below it.
    int draw_box(std::size_t panel, int row, int column, int width) const {
        const std::string name =
            fmt::format(" {} {:<{}}", panel + 1, names_[panel], std::max(0, width - 4));
        const bool selected = panel == keys_.selected() && panels_.size() > 1;
        put_line(row++, column, width, name,
                 selected ? A_REVERSE | A_BOLD | colour(Colour::cyan) : A_REVERSE);
        for (const PanelLine& line : panels_[panel])
            put_line(row++, column + 1, width - 1, line.text, look_of(line.mark));
        return row;
    }

    void draw_told(int first_row, int end_row, int columns) const {
        const auto room = static_cast<std::size_t>(std::max(0, end_row - first_row));
        const std::size_t skipped = told_.size() > room ? told_.size() - room : 0;
        int row = first_row;
        for (std::size_t i = skipped; i < told_.size(); ++i)
            put_line(row++, 0, columns, told_[i], A_DIM);
    }

    void draw_bottom(int row, int columns) const {
        if (const auto& line = keys_.line()) {
            put_line(row, 0, columns, fmt::format("{}: {}_", names_[keys_.selected()], *line),
                     A_BOLD);
            return;
        }
        put_line(
            row, 0, columns,
            fmt::format("{}t T p P l L lower, raise  j join  v leave  f forget  : type  q quit",
                        panels_.size() > 1 ? "1-9 panel  " : ""),
            A_NORMAL);
    }

    common::Terminal terminal_{std::chrono::milliseconds{0}};
    std::string title_;
    std::vector<std::string> names_;
    std::vector<Panel> panels_;
    std::deque<std::string> told_;
    Keys keys_;
};

}  // namespace

std::unique_ptr<Screen> Screen::open(std::string title, std::vector<std::string> names) {
    auto screen = std::make_unique<CursesScreen>(std::move(title), std::move(names));
    if (!screen->works()) return nullptr;
    return screen;
}

}  // namespace plant
