#include "screen.hpp"

#include <fmt/format.h>
#include <langinfo.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <string>
#include <string_view>

#include "common/program.hpp"
#include "common/terminal.hpp"
#include "display.hpp"

namespace tank {

namespace {

using Clock = std::chrono::steady_clock;
using common::Colour;
using common::colour;
using common::put;

constexpr int least_columns = 80;
constexpr int least_rows = 22;
constexpr int side_columns = 24;  // the panels, right of the plot
constexpr int station_rows = 6;   // the operator's lines, below it
constexpr int axis_columns = 5;
constexpr std::chrono::milliseconds column_length{200};
constexpr std::chrono::milliseconds frame_length{50};
constexpr std::size_t most_history = 1000;

constexpr auto level_colour = Colour::cyan;
constexpr auto setpoint_colour = Colour::yellow;
constexpr auto alarm_colour = Colour::red;
constexpr auto led_colour = Colour::green;

class View {
  public:
    explicit View(LiveTank& tank) : tank_(tank) {}

    // Takes in what is new.
    void update() {
        now_ = tank_.view();
        if (Clock::now() >= next_column_) {
            next_column_ += column_length;
            history_.push_back({now_.plant.level_mm, now_.controller.setpoint_cm * 10,
                                now_.controller.mode == Mode::alarm});
            if (history_.size() > most_history) history_.pop_front();
        }
        while (const auto line = tank_.next_line()) {
            messages_.push_back(
                fmt::format("{:>6.1f} {}: {}", seconds(), line->source, line->text));
            if (messages_.size() > station_rows) messages_.pop_front();
        }
    }

    void draw() const {
        ::werase(stdscr);
        const int rows = ::getmaxy(stdscr);
        const int columns = ::getmaxx(stdscr);
        if (rows < least_rows || columns < least_columns) {
            put(0, 0, fmt::format("The tank needs {} x {} characters.", least_columns, least_rows));
            put(1, 0, fmt::format("This terminal has {} x {}.", columns, rows));
            put(2, 0, "q quits");
        } else {
            put(0, 1, "canorb: a tank on remote objects over a CAN bus", A_BOLD);
            put(0, columns - 10, fmt::format("{:>7.1f} s", seconds()));
            const int plot_rows = rows - station_rows - 4;
            draw_plot(1, plot_rows, columns - side_columns);
            draw_panels(2, columns - side_columns + 2);
            draw_station(plot_rows + 2, columns);
            put(rows - 1, 1,
                "level a 50 b 75 c 100 d 125 cm  slot h 5 j 10 k 50 l 100 ms  + - temp.  q quit",
                A_DIM);
        }
        ::wrefresh(stdscr);
    }

  private:
    struct Column {
        int level_mm;
        int setpoint_mm;
        bool alarm;
    };

    double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

    void draw_plot(int first_row, int rows, int columns) const {
        const auto row_of = [&](int mm) {
            return first_row + rows - 1 - std::min(mm * rows / Plant::height_mm, rows - 1);
        };
        for (int cm = 0; cm <= 200; cm += 50)
            put(row_of(cm * 10), 0, fmt::format("{:>4}", cm), A_DIM);
        const auto width = static_cast<std::size_t>(columns - axis_columns);
        const std::size_t skipped = history_.size() > width ? history_.size() - width : 0;
        int column = axis_columns;
        for (std::size_t i = skipped; i < history_.size(); ++i, ++column) {
            const Column& at = history_[i];
            // A row is cut into eighths, as the glyphs are.
            const int eighths = at.level_mm * rows * 8 / Plant::height_mm;
            const int setpoint_row = row_of(at.setpoint_mm);
            const chtype look = colour(at.alarm ? alarm_colour : level_colour);
            for (int row = 0; row < rows; ++row) {
                const int y = first_row + rows - 1 - row;
                if (y == setpoint_row) {
                    put(y, column, utf8_ ? "━" : "-", colour(setpoint_colour) | A_BOLD);
                } else if (const int filled = std::clamp(eighths - row * 8, 0, 8); filled > 0) {
                    put(y, column, bar(filled), look);
                }
            }
        }
    }

    std::string_view bar(int eighths) const {
        static constexpr std::string_view bars[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
        if (utf8_) return bars[eighths - 1];
        return eighths >= 4 ? "#" : "_";
    }

    void draw_panels(int row, int column) const {
        const chtype look_of_a =
            now_.controller.mode == Mode::alarm ? colour(alarm_colour) : A_NORMAL;
        const bool trouble = now_.plant.controller_silent || now_.plant.overflowing;
        const Panel b = panel_of(now_.plant);
        draw_panel(row, column, "node A, the controller", panel_of(now_.controller), look_of_a);
        draw_panel(row + 5, column, "node B, at the tank", b,
                   trouble ? colour(alarm_colour) : A_NORMAL);
        draw_led(row + 9, column + 2, b.leds[0], "VE");
        draw_led(row + 9, column + 9, b.leds[1], "VS");
        put(row + 11, column, fmt::format("temperature {:>5} C", now_.temperature_c),
            mode_at(now_.temperature_c) == Mode::alarm ? colour(alarm_colour) | A_BOLD : A_NORMAL);
    }

    void draw_panel(int row, int column, std::string_view title, const Panel& panel,
                    chtype look) const {
        put(row, column, title, A_BOLD);
        for (int line = 0; line < 2; ++line)
            put(row + 1 + line, column, panel.lines[static_cast<std::size_t>(line)],
                A_REVERSE | look);
    }

    void draw_led(int row, int column, bool on, std::string_view name) const {
        const std::string_view glyph = on ? (utf8_ ? "●" : "*") : (utf8_ ? "○" : "o");
        put(row, column, glyph, on ? colour(led_colour) | A_BOLD : A_DIM);
        put(row, column + 2, name);
    }

    void draw_station(int row, int columns) const {
        put(row, 0, std::string(static_cast<std::size_t>(columns), '-'), A_DIM);
        put(row, 2, " operator station ", A_BOLD);
        const auto width = static_cast<std::size_t>(columns - 2);
        std::string status = status_text(now_.controller);
        ++row;
        for (std::size_t from = 0; from < status.size(); from += width)
            put(row++, 1, std::string_view{status}.substr(from, width));
        const auto room = static_cast<std::size_t>(std::max(0, ::getmaxy(stdscr) - 1 - row));
        const std::size_t skipped = messages_.size() > room ? messages_.size() - room : 0;
        for (std::size_t i = skipped; i < messages_.size(); ++i)
            put(row++, 1, std::string_view{messages_[i]}.substr(0, width), A_DIM);
    }

    LiveTank& tank_;
    LiveTank::View now_{};
    Clock::time_point start_ = Clock::now();
    Clock::time_point next_column_ = start_;
    std::deque<Column> history_;
    std::deque<std::string> messages_;
    bool utf8_ = std::string_view{::nl_langinfo(CODESET)} == "UTF-8";
};

}  // namespace

bool run_screen(LiveTank& tank, std::optional<canorb::Duration> limit) {
    const common::Terminal terminal{frame_length};
    if (!terminal.works()) return false;
    View view{tank};
    const auto start = Clock::now();
    while (!common::StopSignals::requested() && (!limit || Clock::now() - start < *limit)) {
        view.update();
        view.draw();
        const int key = ::wgetch(stdscr);
        if (key == 'q') break;
        if (key == '+') {
            tank.turn(1);
        } else if (key == '-') {
            tank.turn(-1);
        } else if (key > 0 && key < 0x80) {
            tank.type(static_cast<char>(key));
        }
    }
    return true;
}

}  // namespace tank
