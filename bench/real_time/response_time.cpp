// How long messages take from being handed to the ORB to the end of their last bit on a simulated
// bus, against what "Controller Area Network (CAN) schedulability analysis: Refuted, revisited and
// revised" (Davis, Burns, Bril, Lukkien 2007) allows. One JSON object on standard output.
//
//     response_time [--quick] [--messages N] [--bitrate N] [--seed N] [--self-test]
//
// Exit code 1: a bound was exceeded, or the self-test failed.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>

#include "orb/can/sim/bus.hpp"
#include "scenarios.hpp"
#include "self_test.hpp"

namespace {

using namespace canorb::bench;
using nlohmann::ordered_json;

ordered_json assumptions() {
    return ordered_json::array(
        {"No errors on the bus: the analysis is used without an error model.",
         "Response time runs from the call of the stub (periodic sets: from the event, before the "
         "jitter, as R does) to the end of the last bit of EOF. The bound's C has the 3 bits of "
         "intermission after it as well, so bound_ns is 3 bits more than could be measured; "
         "reachable_bound_ns leaves them out.",
         "Software takes no time in a simulation: the call's frame is in the controller at the "
         "moment of the call.",
         "Times are whole nanoseconds. Frames begin and end on a grid of bit times, which are "
         "whole "
         "nanoseconds at 125, 500 and 1000 kbit/s; at other rates bounds are rounded up. Calls "
         "come "
         "at any nanosecond.",
         "bound_ns takes the longest frame by the paper's formula, 55 + 10 s bits with an 11-bit "
         "identifier (paper_example: the longest there is). reachable_bound_ns takes the longest "
         "frames that were sent; most of the others' and of the periodic sets' are the longest "
         "that exist with their identifier and length, given the fixed bits and the CRC.",
         "At each SOF a simulated controller offers the lowest identifier in its mailboxes, as the "
         "analysis assumes, and the lowest of all nodes wins.",
         "An ORB keeps frames_in_controller frames in its controller, 2 by default, hands over the "
         "most urgent first, and takes none back. While these are less urgent frames of its own, "
         "an "
         "urgent message waits for one of them to be sent: then the analysis does not apply, and "
         "shared_controller and periodic_set_of_calls_2_frames show what happens. It applies where "
         "the node sends nothing else (group_under_load) or has no more streams than "
         "frames_in_controller (periodic_set_of_calls_8_frames)."});
}

int measure(const RunOptions& options, bool only_self_test) {
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [begin] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    ordered_json json;
    json["benchmark"] = "response_time";
    json["quick"] = options.quick;
    json["seed"] = options.seed;
    std::fputs("self_test ...\n", stderr);
    const LongestFrame longest;
    json["self_test"] = self_test(longest);
    bool holds = json["self_test"]["passed"];
    if (!holds) std::fputs("response_time: the self-test failed\n", stderr);
    if (holds && !only_self_test) {
        json["what"] =
            "urgent_messages counts calls of group 1 by an ORB on node 0 that were seen at the end "
            "of their frame, each of one frame of 8 octets, under 100 % load of 3 other nodes; "
            "frames of these are not counted";
        json["assumptions"] = assumptions();
        ordered_json& scenarios = json["scenarios"];
        const auto add = [&](const char* name, Outcome outcome) {
            outcome.json["required_bounds_hold"] = outcome.holds;
            if (!outcome.holds) std::fprintf(stderr, "response_time: %s: exceeded\n", name);
            holds = holds && outcome.holds;
            scenarios[name] = std::move(outcome.json);
        };
        add("group_under_load", group_under_load(options, longest));
        json["urgent_messages"] = scenarios["group_under_load"]["messages"];
        add("periodic_set", periodic_set(options, longest));
        add("paper_example", paper_example(options, longest));
        add("periodic_set_of_calls_8_frames", periodic_set_of_calls(options, 8));
        add("periodic_set_of_calls_2_frames", periodic_set_of_calls(options, 2));
        add("shared_controller", shared_controller(options, longest));
    }
    json["required_bounds_hold"] = holds;
    json["seconds"] = seconds();
    std::cout << json.dump() << std::endl;
    return holds && std::cout ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Response times on a simulated CAN bus against their analytic worst case"};
    RunOptions options;
    bool only_self_test = false;
    std::uint64_t messages = 0;
    app.add_flag("--quick", options.quick, "200 000 urgent messages instead of 10 million");
    app.add_flag("--self-test", only_self_test, "Check the analysis and measure nothing");
    app.add_option("--messages", messages, "Urgent messages")->check(CLI::PositiveNumber);
    app.add_option("--bitrate", options.bitrate, "bit/s, but for the periodic sets")
        ->check(CLI::Range(canorb::can::sim::Bus::lowest_bitrate,
                           canorb::can::sim::Bus::highest_bitrate));
    app.add_option("--seed", options.seed, "Of all that is random");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    if (options.quick) options.messages = 200'000;
    if (messages != 0) options.messages = messages;
    try {
        return measure(options, only_self_test);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "response_time: %s\n", error.what());
        return 1;
    }
}
