// A sensor, as a program of its own.

#include "commands.hpp"
#include "console.hpp"
#include "sensor.hpp"

int main(int argc, char** argv) {
    CLI::App app{
        "A sensor of the plant: tells its controller its values when it is polled.\n"
        "Commands on standard input: value, raise, lower VARIABLE NUMBER; join, leave GROUP; quit.",
        "plant_sensor"};
    common::set_up(app);
    common::NodeOptions options{.bus{}, .node = 11};
    common::add_node_options(app, options);
    canorb::GroupId group{2};
    common::add_parsed_option(app, "--group", group, plant::parse_group,
                              "The group to join at first, 1 to 31")
        ->default_str("2");
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;

    return plant::run_node(
        "plant_sensor", options, "sensor", [&](canorb::Orb& orb, plant::Console& console) {
            plant::Sensor sensor{orb, group, [&](std::string_view text) { console.log(text); }};
            console.run(
                {.panel = [&] { return sensor.panel(); },
                 .carry_out = [&](const plant::Command& command) { sensor.carry_out(command); }});
        });
}
