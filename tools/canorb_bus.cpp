// canorb-bus: a simulated CAN bus for the programs of this machine, behind a Unix socket.

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>

#include "orb/can/candump.hpp"
#include "orb/can/link/address.hpp"
#include "orb/can/link/bus_server.hpp"
#include "orb/can/link/link.hpp"

namespace {

using namespace canorb;

constexpr int usage_error = 2;

struct Arguments {
    std::string listen{can::default_bus_address()};
    std::string bitrate = "500000";
    bool unpaced = false;
    std::string log_file;
    bool quiet = false;
};

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

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

/// From the bus's clock to Unix time, which candump's logs have.
Duration unix_time_offset() {
    timespec time{};
    ::clock_gettime(CLOCK_REALTIME, &time);
    const Duration unix_time = std::chrono::seconds{time.tv_sec} + Duration{time.tv_nsec};
    return unix_time - can::monotonic_now().time_since_epoch();
}

int fail(const std::string& reason) {
    std::fprintf(stderr, "canorb-bus: %s\n", reason.c_str());
    return 1;
}

int serve(const Arguments& arguments) {
    const auto address = can::parse_bus_address(arguments.listen);
    if (!address) return fail(address.error());
    const auto* sim = std::get_if<can::SimAddress>(&*address);
    if (sim == nullptr) return fail("--listen takes sim:PATH, not " + arguments.listen);
    const auto bitrate = can::parse_bitrate(arguments.bitrate);
    if (!bitrate) return fail("--bitrate: " + bitrate.error());

    File log_file;
    can::BusServerOptions options;
    options.path = sim->path;
    options.bitrate = *bitrate;
    options.paced = !arguments.unpaced;
    if (!arguments.quiet) {
        options.log = [](std::string_view sentence) {
            std::fprintf(stderr, "canorb-bus: %.*s\n", static_cast<int>(sentence.size()),
                         sentence.data());
        };
    }
    if (!arguments.log_file.empty()) {
        options.trace = [&log_file,
                         offset = unix_time_offset()](const can::sim::CompletedFrame& completed) {
            const std::string line =
                can::format_candump(completed.time + offset, "can0", completed.frame) + '\n';
            std::fputs(line.c_str(), log_file.get());
        };
    }
    const auto server = can::BusServer::open(std::move(options));
    if (!server) return fail(server.error());
    // Only now: a daemon that is refused must not empty the log of the one that runs.
    if (!arguments.log_file.empty()) {
        log_file.reset(std::fopen(arguments.log_file.c_str(), "w"));
        if (!log_file) {
            return fail("cannot write " + arguments.log_file + ": " + std::strerror(errno));
        }
        std::setvbuf(log_file.get(), nullptr, _IOLBF, BUFSIZ);  // a reader sees each frame at once
    }
    stop_on_signals(**server);
    if (!arguments.quiet) {
        std::fprintf(stderr, "canorb-bus: sim:%s, %u bit/s%s\n", sim->path.c_str(), *bitrate,
                     arguments.unpaced ? ", unpaced" : "");
    }
    const std::string error = (*server)->run();
    for (const int signal : stop_signals) std::signal(signal, SIG_IGN);  // it is stopping already
    if (!error.empty()) return fail(error);
    if (log_file && std::ferror(log_file.get()) != 0) {
        return fail("could not write all of " + arguments.log_file);
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{
        "A simulated CAN bus: programs that open the same sim:PATH are nodes on it. "
        "Runs until Ctrl-C.",
        "canorb-bus"};
    app.set_version_flag("--version", std::string{"canorb-bus "} + CANORB_VERSION);
    app.add_option("--listen", arguments.listen, "address of the bus, sim:PATH of a Unix socket")
        ->capture_default_str();
    app.add_option("--bitrate", arguments.bitrate, "bit/s, 10000 to 1000000")
        ->capture_default_str();
    app.add_flag("--unpaced", arguments.unpaced,
                 "do not keep to the clock: bus time moves by frames only, as fast as they come");
    app.add_option("--log", arguments.log_file,
                   "write every frame to this file, as candump -l does; what it held is lost");
    app.add_flag("--quiet", arguments.quiet, "say nothing about clients");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : usage_error;
    }
    return serve(arguments);
}
