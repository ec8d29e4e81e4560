// The controller, as a program of its own.

#include "console.hpp"
#include "controller.hpp"

int main(int argc, char** argv) {
    CLI::App app{
        "The controller of the plant: polls a group of sensors, and switches a group of actuators "
        "off\nwhile a value is over its limit.\n"
        "Commands on standard input: limit, raise, lower VARIABLE NUMBER; forget NODE; quit.",
        "plant_controller"};
    common::set_up(app);
    common::NodeOptions options{.bus{}, .node = 1};
    common::add_node_options(app, options);
    plant::Controller::Groups groups{.sensors = "corbaloc:caniop:group/2",
                                     .actuators = "corbaloc:caniop:group/1"};
    app.add_option("--sensors", groups.sensors,
                   "The sensors' group: its reference, as each sensor prints it")
        ->capture_default_str();
    app.add_option("--actuators", groups.actuators,
                   "The actuators' group: its reference, as each actuator prints it")
        ->capture_default_str();
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;

    return plant::run_node(
        "plant_controller", options, "controller", [&](canorb::Orb& orb, plant::Console& console) {
            plant::Controller controller{orb, groups,
                                         [&](std::string_view text) { console.log(text); }};
            console.run(
                {.panel = [&] { return controller.panel(); },
                 .carry_out =
                     [&](const plant::Command& command) { controller.carry_out(command); }});
        });
}
