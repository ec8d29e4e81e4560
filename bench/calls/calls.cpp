// What a two-way call costs: in one process, in two processes over the daemon's bus without a
// clock, and on the paced bus beside bare frames. See doc/benchmarks.md.
//
//     calls [--quick] [--only in_process|processes|paced|cost]

#include "calls.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <thread>

#include "canorb/simulation.hpp"
#include "child_process.hpp"
#include "footprint.hpp"
#include "processes.hpp"

namespace canorb::bench {
namespace {

constexpr auto local_bus = "local:calls?paced=no&bitrate=1000000";

/// A tenth of the calls is made before, to warm up.
nlohmann::json ping(const ::Bench::Device& device, std::size_t calls) {
    for (std::size_t i = 0; i < calls / 10; ++i) device.ping();
    return time_calls(device, calls).json();
}

nlohmann::json over_local(std::size_t calls, bool one_cpu) {
    const auto bus = open_bus(local_bus);
    Orb server{*bus, {.node = 2}};
    DeviceImpl servant;
    server.root_poa().activate_object_with_id(1, servant);
    std::thread loop{[&] {
        pin_to(one_cpu ? 0 : 1);
        server.run();
    }};
    pin_to(0);
    Orb client{*bus, {.node = 1}};
    const auto end_loop = [&](void*) {
        server.shutdown();
        loop.join();
        pin_to(-1);
    };
    const std::unique_ptr<Orb, decltype(end_loop)> ending{&server, end_loop};
    return ping(device_at(client, 2), calls);
}

/// Both Orbs in one thread, on a bus with virtual time.
nlohmann::json in_simulation(std::size_t calls) {
    Simulation simulation;
    SimulatedBus& bus = simulation.add_bus({.bitrate = 1'000'000});
    pin_to(0);
    Orb server{bus, {.node = 2}};
    DeviceImpl servant;
    server.root_poa().activate_object_with_id(1, servant);
    Orb client{bus, {.node = 1}};
    auto result = ping(device_at(client, 2), calls);
    pin_to(-1);
    return result;
}

nlohmann::json of_own_object(std::size_t calls) {
    const auto bus = open_bus(local_bus);
    pin_to(0);
    Orb orb{*bus, {.node = 1}};
    DeviceImpl servant;
    orb.root_poa().activate_object_with_id(1, servant);
    auto result = ping(device_at(orb, 1), calls);
    pin_to(-1);
    return result;
}

nlohmann::json in_process(bool quick) {
    const std::size_t calls = quick ? 10'000 : 100'000;
    nlohmann::json result;
    progress("in one process");
    result["local_one_cpu"] = over_local(calls, true);
    result["local_two_cpus"] = over_local(calls, false);
    result["virtual_time"] = in_simulation(calls);
    result["own_object"] = of_own_object(calls);
    return result;
}

/// Daemon, server and client are processes.
nlohmann::json over_daemon(std::size_t calls, bool one_cpu) {
    const Daemon daemon{1'000'000, false, one_cpu ? 0 : 1};
    const Child server{[&] { serve_device(daemon.address(), 2, one_cpu ? 0 : 1); }};
    pin_to(0);
    const auto bus = open_bus(daemon.address());
    Orb client{*bus, {.node = 1}};
    const auto device = device_at(client, 2);
    await(device);
    auto result = ping(device, calls);
    pin_to(-1);
    return result;
}

nlohmann::json between_processes(bool quick) {
    const std::size_t calls = quick ? 3'000 : 30'000;
    nlohmann::json result;
    progress("between processes, over sim: without a clock");
    result["one_cpu"] = over_daemon(calls, true);
    result["two_cpus"] = over_daemon(calls, false);
    return result;
}

/// The size and memory of a server that has been called.
nlohmann::ordered_json cost() {
    constexpr int calls = 1'000;
    const Daemon daemon{1'000'000, false, -1};
    const peers::Child server{{peers::program_beside("minimal_server"), daemon.address(), "2"}};
    const auto bus = open_bus(daemon.address());
    Orb client{*bus, {.node = 1}};
    const auto device = device_at(client, 2);
    await(device);
    for (int i = 0; i < calls; ++i) device.ping();
    nlohmann::ordered_json result{{"calls", calls}};
    result.update(peers::footprint(server.pid(), {}));
    return result;
}

}  // namespace

::Bench::Device device_at(Orb& orb, int node) {
    return orb.string_to_object("corbaloc:caniop:" + std::to_string(node) + "/1")
        .unchecked_narrow<::Bench::Device>();
}

void await(const ::Bench::Device& device) {
    for (int attempt = 0;; ++attempt) {
        try {
            device.ping();
            return;
        } catch (const SystemException&) {
            if (attempt == 20) throw;
        }
    }
}

Statistics time_calls(const ::Bench::Device& device, std::size_t calls) {
    Statistics times{calls};
    for (std::size_t i = 0; i < calls; ++i) {
        const TimePoint begin = can::monotonic_now();
        device.ping();
        times.add(can::monotonic_now() - begin);
    }
    return times;
}

void serve_device(const std::string& address, int node, int cpu) {
    pin_to(cpu);
    const auto bus = open_bus(address);
    Orb server{*bus, {.node = node}};
    DeviceImpl servant;
    server.root_poa().activate_object_with_id(1, servant);
    server.run();
}

void progress(std::string_view what) {
    std::fprintf(stderr, "calls: %.*s\n", static_cast<int>(what.size()), what.data());
}

}  // namespace canorb::bench

int main(int argc, char** argv) {
    using namespace canorb::bench;
    CLI::App app{"What a two-way call costs; one JSON object on the standard output"};
    bool quick = false;
    std::string only;
    app.add_flag("--quick", quick, "A few seconds in place of a minute");
    app.add_option("--only", only, "A part of it")
        ->check(CLI::IsMember({"in_process", "processes", "paced", "cost"}));
    CLI11_PARSE(app, argc, argv);
    try {
        nlohmann::json result;
        result["cpus"] = cpus();
        if (only.empty() || only == "in_process") result["in_process"] = in_process(quick);
        if (only.empty() || only == "processes") result["processes"] = between_processes(quick);
        if (only.empty() || only == "paced") result["paced"] = on_the_paced_bus(quick);
        if (only == "cost") result["cost"] = cost();
        std::cout << result.dump(2) << '\n';
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "calls: %s\n", exception.what());
        return 1;
    }
}
