#include "common/program.hpp"

#include <fmt/format.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>

namespace common {

namespace {

// A signal handler has nothing but globals.
std::atomic<canorb::Orb*> orb_to_stop{nullptr};
std::atomic<bool> stop_requested{false};
static_assert(std::atomic<canorb::Orb*>::is_always_lock_free);

constexpr int stop_signals[] = {SIGINT, SIGTERM, SIGHUP};

extern "C" void on_stop_signal(int) {
    stop_requested = true;
    if (canorb::Orb* const orb = orb_to_stop) orb->shutdown();
}

void handle_stop_signals(void (*handler)(int)) {
    struct sigaction action{};
    action.sa_handler = handler;
    ::sigemptyset(&action.sa_mask);
    for (const int number : stop_signals) ::sigaction(number, &action, nullptr);
}

}  // namespace

void set_up(CLI::App& app) {
    app.set_version_flag("--version", app.get_name() + " " EXAMPLES_VERSION);
    app.get_formatter()->column_width(32);
}

void add_node_options(CLI::App& app, NodeOptions& options) {
    options.bus = canorb::default_bus_address();
    app.add_option(
           "--bus", options.bus,
           "The bus: local:NAME, sim:PATH, socketcan:IFNAME or slcan:DEVICE (else CANORB_BUS)")
        ->capture_default_str();
    add_parsed_option(app, "--node", options.node, canorb::parse_node_id,
                      "This node's number, 0 to 30 (else CANORB_NODE)")
        ->envname("CANORB_NODE")
        ->default_str(fmt::format("{}", options.node));
}

std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    return std::nullopt;
}

int run_program(std::string_view name, const std::function<void()>& work) {
    try {
        work();
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}: {}\n", name, error.what());
        return 1;
    }
}

StopSignals::StopSignals(canorb::Orb* orb) {
    orb_to_stop = orb;
    handle_stop_signals(on_stop_signal);
}

StopSignals::~StopSignals() {
    handle_stop_signals(SIG_DFL);
    orb_to_stop = nullptr;
}

bool StopSignals::requested() {
    return stop_requested;
}

void keep_on_bus(canorb::Orb& orb) {
    using canorb::can::ControllerState;
    orb.every(std::chrono::seconds{1}, [&orb] {
        const ControllerState state = orb.error_status().state;
        if (state != ControllerState::bus_off && state != ControllerState::stopped) return;
        try {
            orb.recover();
        } catch (const canorb::NO_PERMISSION&) {
            // The event about bus-off has said what its administrator can do.
        }
    });
}

}  // namespace common
