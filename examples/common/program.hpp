#pragma once

/// What the examples' programs have in common: options, Ctrl-C, staying on the bus.

#include <CLI/CLI.hpp>
#include <canorb/orb.hpp>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace common {

/// --version, and how the help text is set.
void set_up(CLI::App& app);

/// --bus and --node, with CANORB_BUS and CANORB_NODE behind them.
struct NodeOptions {
    std::string bus;
    int node;
};
void add_node_options(CLI::App& app, NodeOptions& options);

/// An option whose text `parse` reads; its std::invalid_argument becomes the option's error.
template <typename Value>
CLI::Option* add_parsed_option(CLI::App& app, const std::string& name, Value& value,
                               Value (*parse)(std::string_view), const std::string& description) {
    return app.add_option_function<std::string>(
        name,
        [name, &value, parse](const std::string& text) {
            try {
                value = parse(text);
            } catch (const std::exception& error) {
                throw CLI::ValidationError(name, error.what());
            }
        },
        description);
}

/// Reads the command line. Where the program is to end at once, its exit code: 0 after --help and
/// --version, 2 for wrong usage.
std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv);

/// Runs a program's work; what it throws becomes a message and the exit code 1.
int run_program(std::string_view name, const std::function<void()>& work);

/// While one exists, SIGINT, SIGTERM and SIGHUP do not kill the program: they set requested(),
/// and end the run() of the ORB, where there is one. At most one at a time.
class StopSignals {
  public:
    explicit StopSignals(canorb::Orb* orb = nullptr);
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    static bool requested();
};

/// Lets the ORB ask for its bus again, once a second, while it is off it: after bus-off, or when
/// the bus was gone.
void keep_on_bus(canorb::Orb& orb);

}  // namespace common
