// Fast DDS, measured as canorb is, with a sample for each request and one for each reply: their
// octets, how long they take, how much software it is. Prints one JSON object, times in
// nanoseconds.

#include <fastrtps/config.h>
#include <CLI/CLI.hpp>
#include <string>

#include "child_process.hpp"
#include "ending_signals.hpp"
#include "fastdds_client.hpp"
#include "fastdds_latency.hpp"
#include "fastdds_sizes.hpp"
#include "footprint.hpp"
#include "latency.hpp"
#include "program.hpp"

namespace {

using namespace peers;
using nlohmann::ordered_json;

struct Arguments {
    std::string transport = "udp";
    std::string reliability = "reliable";
    std::string wait = "listener";
    std::string cpus = "any";
    std::string domain;
    std::string name;
    bool quick = false;
};

ordered_json about(const Arguments& arguments) {
    return {{"peer", "Fast DDS"},
            {"version", FASTRTPS_VERSION_STR},
            {"transport", arguments.transport},
            {"reliability", arguments.reliability}};
}

ordered_json sizes() {
    ordered_json result{{"peer", "Fast DDS"}, {"version", FASTRTPS_VERSION_STR}};
    for (const std::string reliability : {"best_effort", "reliable"}) {
        std::fprintf(stderr, "peer_fastdds: capturing, %s\n", reliability.c_str());
        result[reliability]["operations"] = rtps_sizes(reliability);
    }
    return result;
}

std::vector<std::string> minimal_server(const Network& network) {
    return {program_beside("peer_fastdds_server"), network.transport, network.reliability,
            std::to_string(network.domain), network.name};
}

ordered_json latency(const Arguments& arguments) {
    const Placement place = placement(arguments.cpus);
    const RoundTrips counts = round_trips(arguments.quick);
    const Network network = private_network(arguments.transport, arguments.reliability);
    Child server{minimal_server(network), place.server};
    pin(place.client);
    Caller caller{{"ping", nothing(), nothing()}};
    Participant participant{network};
    caller.start(participant);
    caller.wait_until_ready();
    server.read_line();

    ordered_json result = about(arguments);
    result["wait"] = arguments.wait;
    result.update(figures(measure_round_trips(caller, arguments.wait, counts), counts,
                          arguments.cpus, place));
    return result;
}

ordered_json cost(const Arguments& arguments) {
    constexpr std::size_t calls = 1'000;
    const Network network = private_network(arguments.transport, arguments.reliability);
    Child server{minimal_server(network)};
    Caller caller{{"ping", nothing(), nothing()}};
    Participant participant{network};
    caller.start(participant);
    caller.wait_until_ready();
    server.read_line();
    measure_round_trips(caller, "listener", {0, calls, 0});

    ordered_json result = about(arguments);
    result["calls"] = calls;
    result.update(footprint(server.pid(), {"libfastrtps.", "libfastcdr."}));
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{"Measures Fast DDS"};
    app.name("peer_fastdds");
    app.require_subcommand(1);
    const auto add_choice = [](CLI::App* command, const char* option, std::string& value,
                               const std::vector<std::string>& choices) {
        std::string all;
        for (const auto& choice : choices) all += (all.empty() ? "" : ", ") + choice;
        command->add_option(option, value, all)->check(CLI::IsMember(choices));
    };
    const std::vector<std::string> reliabilities{"best_effort", "reliable"};

    auto* answer_command = app.add_subcommand("answer", "Answers the requests of sizes");
    add_choice(answer_command, "--reliability", arguments.reliability, reliabilities);
    answer_command->add_option("--domain", arguments.domain, "Domain of DDS")->required();
    answer_command->add_option("--name", arguments.name, "Begin of all topics")->required();
    auto* sizes_command = app.add_subcommand("sizes", "Captures the octets of each operation");
    auto* latency_command = app.add_subcommand("latency", "Times samples to a process and back");
    add_choice(latency_command, "--cpus", arguments.cpus, {"one", "two", "any"});
    add_choice(latency_command, "--wait", arguments.wait, {"listener", "caller"});
    auto* cost_command = app.add_subcommand("cost", "Size and memory of a minimal server");
    for (auto* command : {latency_command, cost_command}) {
        add_choice(command, "--transport", arguments.transport, {"udp", "shm", "data_sharing"});
        add_choice(command, "--reliability", arguments.reliability, reliabilities);
    }
    for (auto* command : {sizes_command, latency_command, cost_command}) {
        command->add_flag("--quick", arguments.quick, "Fewer samples, where there are many");
    }

    return run_program(app, argc, argv, [&]() -> ordered_json {
        if (answer_command->parsed()) {
            block_ending_signals();
            answer_all(arguments.reliability, arguments.domain, arguments.name);
            return nullptr;
        }
        handle_signals();
        if (sizes_command->parsed()) return sizes();
        if (latency_command->parsed()) return latency(arguments);
        return cost(arguments);
    });
}
