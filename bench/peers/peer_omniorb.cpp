// omniORB, measured as canorb is: the octets of its calls, how long they take, how much software
// it is. Prints one JSON object, times in nanoseconds.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "child_process.hpp"
#include "ending_signals.hpp"
#include "footprint.hpp"
#include "latency.hpp"
#include "omniorb_device.hpp"
#include "omniorb_sizes.hpp"
#include "program.hpp"

namespace {

using namespace peers;
using namespace std::chrono_literals;
using nlohmann::ordered_json;

struct Arguments {
    std::vector<std::string> endpoints;
    std::string publish;
    std::string giop;
    std::string transport = "unix";
    std::string cpus = "any";
    bool quick = false;
};

ordered_json serve(const Arguments& arguments) {
    OmniOrb::Options options;
    for (const auto& each : arguments.endpoints) options.emplace_back("endPoint", each);
    if (!arguments.publish.empty()) options.emplace_back("endPointPublish", arguments.publish);
    if (!arguments.giop.empty()) options.emplace_back("maxGIOPVersion", arguments.giop);
    serve_until_signal(options);
    return nullptr;
}

/// A process has one omniORB, with one version of GIOP: each version is measured by a child.
ordered_json sizes(const Arguments& arguments) {
    ordered_json result{{"peer", "omniORB"}, {"version", omniORB::versionString()}};
    const auto key = [](std::string version) {
        version[1] = '_';
        return "giop_" + version;
    };
    if (!arguments.giop.empty()) {
        result[key(arguments.giop)] = giop_sizes(arguments.giop);
        return result;
    }
    for (const std::string version : {"1.0", "1.2"}) {
        Child child{{own_program(), "sizes", "--giop", version}};
        const auto part = ordered_json::parse(child.finish(60s));
        result[key(version)] = part.at(key(version));
    }
    return result;
}

std::string endpoint(const std::string& transport, const TemporaryDirectory& directory) {
    if (transport == "tcp") return "giop:tcp:127.0.0.1:";
    return "giop:unix:" + (directory.path() / "server").string();
}

ordered_json latency(const Arguments& arguments) {
    const Placement place = placement(arguments.cpus);
    const RoundTrips counts = round_trips(arguments.quick);
    const TemporaryDirectory directory;
    Child server{{program_beside("peer_omniorb_server"), endpoint(arguments.transport, directory)},
                 place.server};
    pin(place.client);
    OmniOrb orb{{}};
    const Bench::Device_var device = orb.device(server.read_line());

    LatencyResult measured;
    measured.times.reserve(counts.timed);
    for (std::size_t i = 0; i < counts.warm_up; ++i) device->ping();
    for (std::size_t i = 0; i < counts.timed; ++i) {
        throw_if_interrupted();
        const auto begin = Clock::now();
        device->ping();
        measured.times.push_back(Clock::now() - begin);
    }
    const auto begin = Clock::now();
    for (std::size_t i = 0; i < counts.throughput; ++i) {
        throw_if_interrupted();
        device->ping();
    }
    measured.throughput_time = Clock::now() - begin;

    ordered_json result{{"peer", "omniORB"},
                        {"version", omniORB::versionString()},
                        {"transport", arguments.transport}};
    result.update(figures(std::move(measured), counts, arguments.cpus, place));
    return result;
}

ordered_json cost(const Arguments& arguments) {
    constexpr int calls = 1'000;
    const TemporaryDirectory directory;
    Child server{{program_beside("peer_omniorb_server"), endpoint(arguments.transport, directory)}};
    OmniOrb orb{{}};
    const Bench::Device_var device = orb.device(server.read_line());
    for (int i = 0; i < calls; ++i) device->ping();
    ordered_json result{{"peer", "omniORB"},
                        {"version", omniORB::versionString()},
                        {"transport", arguments.transport},
                        {"calls", calls}};
    result.update(footprint(server.pid(), {"libomniORB4.", "libomnithread."}));
    return result;
}

/// What omniORB throws, as the exceptions that all programs report.
template <typename Run>
ordered_json translate(Run run, const Arguments& arguments) {
    try {
        return run(arguments);
    } catch (const CORBA::SystemException& error) {
        const char* minor = error.NP_minorString();
        throw std::runtime_error(std::string{"CORBA::"} + error._name() + " " +
                                 (minor != nullptr ? minor : ""));
    } catch (const CORBA::Exception& error) {
        throw std::runtime_error(error._name());
    } catch (const omniORB::fatalException& error) {
        throw std::runtime_error(error.errmsg());
    }
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{"Measures omniORB"};
    app.name("peer_omniorb");
    app.require_subcommand(1);
    const auto add_transport = [&](CLI::App* command) {
        command->add_option("--transport", arguments.transport, "unix or tcp")
            ->check(CLI::IsMember({"unix", "tcp"}));
    };
    const auto add_giop = [&](CLI::App* command, const char* what) {
        command->add_option("--giop", arguments.giop, what)->check(CLI::IsMember({"1.0", "1.2"}));
    };

    auto* serve_command = app.add_subcommand("server", "Serves a device, prints its reference");
    serve_command
        ->add_option("--endpoint", arguments.endpoints, "giop:unix:PATH or giop:tcp:HOST:PORT")
        ->required();
    serve_command->add_option("--publish", arguments.publish, "Another endpoint to tell clients");
    add_giop(serve_command, "Highest version of GIOP");
    auto* sizes_command = app.add_subcommand("sizes", "Records the octets of each operation");
    add_giop(sizes_command, "One version of GIOP instead of both");
    auto* latency_command = app.add_subcommand("latency", "Times ping() to another process");
    add_transport(latency_command);
    latency_command->add_option("--cpus", arguments.cpus, "one, two or any")
        ->check(CLI::IsMember({"one", "two", "any"}));
    auto* cost_command = app.add_subcommand("cost", "Size and memory of a minimal server");
    add_transport(cost_command);
    for (auto* command : {sizes_command, latency_command, cost_command}) {
        command->add_flag("--quick", arguments.quick, "Fewer calls, where there are many");
    }

    return run_program(app, argc, argv, [&]() -> ordered_json {
        if (serve_command->parsed()) {
            block_ending_signals();
            return translate(serve, arguments);
        }
        handle_signals();
        if (sizes_command->parsed()) return translate(sizes, arguments);
        if (latency_command->parsed()) return translate(latency, arguments);
        return translate(cost, arguments);
    });
}
