// An actuator, as a program of its own.

#include "actuator.hpp"
#include "commands.hpp"
#include "console.hpp"

int main(int argc, char** argv) {
    CLI::App app{
        "An actuator of the plant: is on or off, as its controller says.\n"
        "Commands on standard input: join, leave GROUP; quit.",
        "plant_actuator"};
    common::set_up(app);
    common::NodeOptions options{.bus{}, .node = 21};
    common::add_node_options(app, options);
    canorb::GroupId group{1};
    common::add_parsed_option(app, "--group", group, plant::parse_group,
                              "The group to join at first, 1 to 31")
        ->default_str("1");
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;

    return plant::run_node(
        "plant_actuator", options, "actuator", [&](canorb::Orb& orb, plant::Console& console) {
            plant::Actuator actuator{orb, group, [&](std::string_view text) { console.log(text); }};
            console.run(
                {.panel = [&] { return actuator.panel(); },
                 .carry_out = [&](const plant::Command& command) { actuator.carry_out(command); }});
        });
}
