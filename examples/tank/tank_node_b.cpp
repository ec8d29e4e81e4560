// The node at the tank, as a program of its own.

#include <canorb/orb.hpp>

#include "groups.hpp"
#include "node_b.hpp"
#include "program.hpp"
#include "schedule.hpp"

int main(int argc, char** argv) {
    CLI::App app{"Node B of the tank: measures the level and works the valves.", "tank_node_b"};
    common::set_up(app);
    common::NodeOptions options{.bus{}, .node = tank::default_node_b};
    common::add_node_options(app, options);
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;

    return common::run_program("tank_node_b", [&] {
        const auto bus = canorb::open_bus(options.bus);
        canorb::Orb orb{*bus, {.node = options.node, .name = "tank-b"}};
        tank::NodePrinter printer{orb, "B", options};
        tank::NodeB node{
            orb,
            {.display = [&](const tank::PlantStatus& s) { printer.show(tank::panel_of(s)); },
             .log = [&](std::string_view text) { printer.log(text); }}};

        tank::StepsDue steps;
        orb.every(tank::Plant::step_length,
                  [&, start = orb.now()] { node.pass_time(steps.take(orb.now() - start)); });
        common::keep_on_bus(orb);
        const common::StopSignals stop_signals{&orb};
        orb.run();
    });
}
