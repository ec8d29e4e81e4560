// canorb-bus: a simulated CAN bus for the programs of this machine, behind a Unix socket; or one in
// virtual time, that plays a scenario.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "orb/can/link/address.hpp"
#include "orb/can/link/bus_server.hpp"
#include "orb/can/link/link.hpp"
#include "orb/can/link/sim_link.hpp"
#include "orb/can/sim/fault_injector.hpp"
#include "orb/can/sim/fault_script.hpp"
#include "tools/bus_table.hpp"
#include "tools/patient_output.hpp"
#include "tools/recordings.hpp"
#include "tools/scenario.hpp"

namespace {

using namespace canorb;

constexpr int failure = 1;
constexpr int usage_error = 2;
/// At its end, for a reader of its output.
constexpr Duration last_patience = std::chrono::milliseconds{500};

struct Arguments {
    std::string listen{can::default_bus_address()};
    std::string bitrate = "500000";
    bool unpaced = false;
    bool recover_automatically = false;
    std::string fault_file;
    tools::RecordingFiles recordings;
    bool status = false;
    bool quiet = false;
    std::string scenario_file;
    std::vector<std::string> nodes;
    std::string length;
    /// Some option is for a bus of its own: it is not only asked about the one that runs.
    bool wants_bus = false;
};

void say(const std::string& sentence) {
    std::fprintf(stderr, "canorb-bus: %s\n", sentence.c_str());
}

int fail(const std::string& reason, int exit_code = failure) {
    say(reason);
    return exit_code;
}

/// Everything that is on standard output so far is to be seen. The exit code; what could not be
/// written was said.
int print(const std::string& text) {
    const bool written = std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0 &&
                         std::ferror(stdout) == 0;
    if (written) return 0;
    return fail("cannot write all of standard output: " + std::generic_category().message(errno));
}

constexpr int stop_signals[] = {SIGINT, SIGTERM, SIGHUP};

/// A signal handler reaches the server only through something that is always there.
can::BusServer* running_server = nullptr;

void stop_running_server(int) {
    running_server->stop();
}

void stop_on_signals(can::BusServer& server) {
    running_server = &server;
    struct sigaction action{};
    action.sa_handler = stop_running_server;
    for (const int signal : stop_signals) ::sigaction(signal, &action, nullptr);
}

/// From the bus's clock to Unix time, which recordings have.
Duration unix_time_offset() {
    timespec time{};
    ::clock_gettime(CLOCK_REALTIME, &time);
    const Duration unix_time = std::chrono::seconds{time.tv_sec} + Duration{time.tv_nsec};
    return unix_time - can::monotonic_now().time_since_epoch();
}

Result<std::string, std::string> read_file(const std::string& path) {
    std::string text;
    std::FILE* const file = std::fopen(path.c_str(), "rb");
    bool whole = file != nullptr;
    if (whole) {
        std::array<char, 4096> buffer;
        while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), file)) {
            text.append(buffer.data(), got);
        }
        whole = std::ferror(file) == 0;
    }
    const int error = errno;
    if (file != nullptr) std::fclose(file);
    if (whole) return text;
    return Failure{"cannot read " + path + ": " + std::generic_category().message(error)};
}

/// The script of --fault, an empty one without; or the exit code, when what is wrong was said.
Result<can::sim::FaultScript, int> load_faults(const std::string& path) {
    if (path.empty()) return can::sim::FaultScript{};
    const auto text = read_file(path);
    if (!text) return Failure{fail(text.error())};
    auto script = can::sim::parse_fault_script(*text);
    if (script) return std::move(*script);
    for (const auto& error : script.error()) {
        std::fprintf(stderr, "%s:%s\n", path.c_str(), can::sim::format(error).c_str());
    }
    return Failure{usage_error};
}

/// What of a script had no effect may be a mistake in it.
void tell_unused(const std::string& path, const can::sim::FaultInjector& injector,
                 const std::function<void(const std::string&)>& tell) {
    for (const can::sim::Fault* fault : injector.unused()) {
        tell(path + ":" + std::to_string(fault->line) + ": this fault never acted");
    }
    for (const std::string& name : injector.absent_names()) {
        tell(path + ": no node was called \"" + name + "\"");
    }
}

int serve(const Arguments& arguments, const can::SimAddress& address, std::uint32_t bitrate) {
    auto script = load_faults(arguments.fault_file);
    if (!script) return script.error();
    tools::PatientOutput status{STDOUT_FILENO, "canorb-bus"};
    tools::PatientOutput messages{STDERR_FILENO, "canorb-bus"};
    const auto tell = [&](std::string_view sentence) {
        messages.write("canorb-bus: " + std::string{sentence} + '\n');
    };
    // It outlives the bus, which is in the server.
    std::optional<can::sim::FaultInjector> injector;
    std::unique_ptr<can::BusServer> server;
    std::unique_ptr<tools::Recordings> recordings;  // takes itself from the bus
    tools::RecordingFiles files = arguments.recordings;
    files.log_interface = tools::bus_interface;
    can::BusServerOptions options;
    options.path = address.path;
    options.bitrate = bitrate;
    options.paced = !arguments.unpaced;
    options.controller.automatic_recovery = arguments.recover_automatically;
    if (!arguments.quiet) options.log = tell;
    options.report = [&](const can::BusReport& report) {
        if (arguments.status) status.write(tools::bus_table(report) + '\n');
        messages.flush();
        recordings->flush();
    };
    auto opened = can::BusServer::open(std::move(options));
    if (!opened) return fail(opened.error());
    server = std::move(*opened);
    can::sim::Bus& bus = server->bus();
    injector.emplace(std::move(*script), bitrate, bus.now());
    if (!arguments.fault_file.empty()) bus.set_disturbance(&*injector);
    // Only now: a daemon that is refused must not empty the files of the one that runs.
    auto started = tools::Recordings::start(bus, files, unix_time_offset(), tell);
    if (!started) return fail(started.error());
    recordings = std::move(*started);
    if (arguments.recordings.any()) {
        bus.set_trace([&](const can::sim::CompletedFrame& frame) { recordings->frame(frame); });
    }
    // While somebody wants to know of errors, each repetition of a frame that nobody acknowledges
    // costs time.
    if (!arguments.recordings.pcapng.empty()) {
        bus.set_error_trace([&](const can::sim::NodeError& error) { recordings->error(error); });
    }

    stop_on_signals(*server);
    // Whoever reads the status may go, and a file may be as large as it may be: no reason to die.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    if (!arguments.quiet) {
        tell("sim:" + address.path + ", " + std::to_string(bitrate) + " bit/s" +
             (arguments.unpaced ? ", unpaced" : ""));
    }
    const std::string error = server->run();
    for (const int signal : stop_signals) std::signal(signal, SIG_IGN);  // it is stopping already
    recordings->flush();
    const bool recorded = !recordings->failed();
    tell_unused(arguments.fault_file, *injector, tell);
    if (!error.empty()) tell(error);
    for (tools::PatientOutput* const output : {&status, &messages}) output->finish(last_patience);
    return error.empty() && recorded ? 0 : failure;
}

int play(const Arguments& arguments, std::uint32_t bitrate) {
    tools::PlayOptions options;
    for (const std::string& name : arguments.nodes) {
        if (name.empty()) return fail("--nodes takes names, and none is empty", usage_error);
        if (std::count(arguments.nodes.begin(), arguments.nodes.end(), name) > 1) {
            return fail("--nodes has " + name + " twice", usage_error);
        }
    }
    options.listeners = arguments.nodes;
    options.advise = say;
    options.automatic_recovery = arguments.recover_automatically;
    if (!arguments.length.empty()) {
        options.length = tools::parse_duration(arguments.length);
        if (!options.length) {
            return fail("--for takes a time such as 20ms or 1.5s, at most 1000000s, not " +
                            arguments.length,
                        usage_error);
        }
    }
    const auto text = read_file(arguments.scenario_file);
    if (!text) return fail(text.error());
    const auto scenario = tools::parse_scenario(*text);
    if (!scenario) {
        for (const std::string& error : scenario.error()) {
            std::fprintf(stderr, "%s:%s\n", arguments.scenario_file.c_str(), error.c_str());
        }
        return usage_error;
    }
    auto script = load_faults(arguments.fault_file);
    if (!script) return script.error();

    can::sim::FaultInjector injector{std::move(*script), bitrate};  // outlives the bus
    can::sim::Bus bus{bitrate};
    if (!arguments.fault_file.empty()) bus.set_disturbance(&injector);
    std::signal(SIGXFSZ, SIG_IGN);
    const auto recordings = tools::Recordings::start(bus, arguments.recordings, Duration{0}, say);
    if (!recordings) return fail(recordings.error());
    options.trace = [&](const auto& frame) { (*recordings)->frame(frame); };
    options.error_trace = [&](const auto& error) { (*recordings)->error(error); };
    const can::BusReport report = tools::play(*scenario, options, bus, [](const std::string& line) {
        std::fputs((line + '\n').c_str(), stdout);
    });
    const int printed = print('\n' + tools::bus_table(report));
    (*recordings)->flush();
    if (!arguments.fault_file.empty()) tell_unused(arguments.fault_file, injector, say);
    return (*recordings)->failed() ? failure : printed;
}

int run(const Arguments& arguments) {
    const auto bitrate = can::parse_bitrate(arguments.bitrate);
    if (!bitrate) return fail("--bitrate: " + bitrate.error(), usage_error);
    const auto conflict =
        arguments.recordings.conflict({arguments.scenario_file, arguments.fault_file});
    if (conflict) return fail(*conflict, usage_error);
    if (!arguments.scenario_file.empty()) return play(arguments, *bitrate);
    const auto address = can::parse_bus_address(arguments.listen);
    if (!address) return fail(address.error(), usage_error);
    const auto* sim = std::get_if<can::SimAddress>(&*address);
    if (sim == nullptr) {
        return fail("--listen takes sim:PATH, not " + arguments.listen, usage_error);
    }
    if (arguments.status && !arguments.wants_bus) {
        const auto report = can::request_bus_report(*sim);
        if (report) return print(tools::bus_table(*report));
        if (!report.error().nobody_listens) return fail(report.error().reason);
        if (!arguments.quiet) say("no bus runs at sim:" + sim->path + ": starting one");
    }
    return serve(arguments, *sim, *bitrate);
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{
        "A simulated CAN bus: programs that open the same sim:PATH are nodes on it. "
        "Runs until Ctrl-C.",
        "canorb-bus"};
    app.set_version_flag("--version", std::string{"canorb-bus "} + CANORB_VERSION);
    auto* const listen = app.add_option("--listen", arguments.listen,
                                        "address of the bus, sim:PATH of a Unix socket")
                             ->capture_default_str();
    app.add_option("--bitrate", arguments.bitrate, "bit/s, 5000 to 1000000")->capture_default_str();
    auto* const unpaced = app.add_flag(
        "--unpaced", arguments.unpaced,
        "do not keep to the clock: bus time moves by frames only, as fast as they come");
    app.add_flag("--recover-automatically", arguments.recover_automatically,
                 "controllers leave bus-off by themselves, after 128 times 11 recessive bits");
    app.add_option("--fault", arguments.fault_file, "script of what goes wrong on the bus");
    app.add_option("--log", arguments.recordings.log,
                   "write every frame to this file, as candump -l does, with --play so that it "
                   "can be played again; what it held is lost");
    app.add_option("--vcd", arguments.recordings.vcd,
                   "the same with every bit, for PulseView, GTKWave and sigrok-cli");
    app.add_option("--pcapng", arguments.recordings.pcapng,
                   "the same with frames and errors, for Wireshark and tshark");
    auto* const status =
        app.add_flag("--status", arguments.status,
                     "print bus load and nodes each second; with no option but --listen beside it, "
                     "of the bus that runs there, once; where none runs, one is started");
    app.add_flag("--quiet", arguments.quiet, "say nothing about clients");
    auto* const scenario = app.add_option(
        "--play", arguments.scenario_file,
        "play this candump log, with a sender's name in place of the interface, on a bus of its "
        "own in virtual time; prints what happens, and ends");
    scenario->excludes(listen)->excludes(unpaced)->excludes(status);
    app.add_option("--nodes", arguments.nodes, "with --play: names of nodes that only receive")
        ->delimiter(',')
        ->needs(scenario);
    app.add_option("--for", arguments.length,
                   "with --play: bus time after which it ends, such as 20ms; without, when the bus "
                   "is quiet, or 1 s after the last line")
        ->needs(scenario);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : usage_error;
    }
    for (const CLI::Option* option : app.get_options()) {
        const std::string name = option->get_name();
        if (option->count() > 0 && name != "--listen" && name != "--status" && name != "--quiet") {
            arguments.wants_bus = true;
        }
    }
    return run(arguments);
}
