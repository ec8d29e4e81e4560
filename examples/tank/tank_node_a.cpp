// The controller, as a program of its own.

#include <poll.h>
#include <unistd.h>
#include <canorb/orb.hpp>

#include <algorithm>

#include "groups.hpp"
#include "keyboard.hpp"
#include "node_a.hpp"
#include "program.hpp"
#include "schedule.hpp"
#include "serial_terminal.hpp"

namespace {

/// The temperature sensor: + and - on the keyboard turn it.
class Potentiometer {
  public:
    int celsius() const { return celsius_; }

    /// Reads what was typed since.
    void turn() {
        pollfd keyboard{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        while (open_ && ::poll(&keyboard, 1, 0) > 0) {
            char key = 0;
            open_ = ::read(STDIN_FILENO, &key, 1) == 1;
            if (key == '+') celsius_ += tank::temperature_step;
            if (key == '-') celsius_ -= tank::temperature_step;
            celsius_ = std::clamp(celsius_, -tank::highest_temperature, tank::highest_temperature);
        }
    }

  private:
    int celsius_ = 20;
    // A terminal's keys may be another program's.
    bool open_ = ::isatty(STDIN_FILENO) == 0 || tank::has_keyboard();
};

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "Node A of the tank: decides what the valves do, and serves the operator on a\n"
        "pseudo-terminal, whose path it prints. + and - turn the temperature.",
        "tank_node_a"};
    common::set_up(app);
    common::NodeOptions options{.bus{}, .node = tank::default_node_a};
    common::add_node_options(app, options);
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;

    return common::run_program("tank_node_a", [&] {
        const auto bus = canorb::open_bus(options.bus);
        canorb::Orb orb{*bus, {.node = options.node, .name = "tank-a"}};
        tank::NodePrinter printer{orb, "A", options};
        tank::SerialTerminal line;
        printer.log("operator station at " + line.path());
        tank::NodeA node{
            orb,
            line,
            {.display = [&](const tank::ControllerStatus& s) { printer.show(tank::panel_of(s)); },
             .log = [&](std::string_view text) { printer.log(text); }}};

        const tank::KeyboardMode keyboard;
        Potentiometer temperature;
        orb.every(tank::Plant::step_length, [&] {
            temperature.turn();
            node.set_temperature(temperature.celsius());
        });
        common::keep_on_bus(orb);
        const common::StopSignals stop_signals{&orb};
        orb.run();
    });
}
