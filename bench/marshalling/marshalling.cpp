// What it costs to encode and to decode the argument lists of bench/operations.idl: in canorb,
// which uses CCDR, in omniORB and in Fast CDR. Same values, same loop, round robin on one CPU.
//
//     marshalling [--quick] [--cpu N] [--list NAME]
//
// Prints JSON; progress goes to standard error.

#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "codec.hpp"

namespace {

using Json = nlohmann::ordered_json;

struct Options {
    bool quick = false;
    int cpu = -1;      ///< -1: the last one that this process may use
    std::string list;  ///< empty: all
};

/// One of encode and decode, and what each round took.
struct Series {
    const std::function<Timing(std::size_t)>* run;
    std::size_t repetitions = 0;      ///< in a round
    std::vector<double> nanoseconds;  ///< for one
    std::vector<double> ticks;
};

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double minimum(const std::vector<double>& values) {
    return *std::min_element(values.begin(), values.end());
}

/// In the order in which all sides add them.
const std::vector<std::string> list_names = {"set_attribute_ul",
                                             "read",
                                             "push",
                                             "level",
                                             "status",
                                             "rename_64",
                                             "load_256",
                                             "limits",
                                             "user_exception",
                                             "system_exception",
                                             "attach_nil",
                                             "attach_reference"};

struct Side {
    std::string name;
    Codecs codecs;
    std::vector<Series> encode;  ///< for each list
    std::vector<Series> decode;
};

/// Keeps this process on one CPU; which.
int pin(int wanted) {
    cpu_set_t allowed;
    if (::sched_getaffinity(0, sizeof allowed, &allowed) != 0)
        throw std::runtime_error{"the CPUs of this process cannot be asked for"};
    int cpu = wanted;
    for (int i = 0; wanted < 0 && i < CPU_SETSIZE; ++i) {
        if (CPU_ISSET(static_cast<std::size_t>(i), &allowed)) cpu = i;
    }
    cpu_set_t one;
    CPU_ZERO(&one);
    if (cpu < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(cpu), &one);
    if (::sched_setaffinity(0, sizeof one, &one) != 0)
        throw std::runtime_error{"this process may not use CPU " + std::to_string(cpu)};
    return cpu;
}

std::string cpu_model() {
    std::ifstream in{"/proc/cpuinfo"};
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    }
    return "unknown";
}

/// Counts of both clocks over everything that was timed.
struct Clocks {
    double nanoseconds = 0;
    double ticks = 0;
};

/// How many repetitions take about so long.
std::size_t calibrate(const std::function<Timing(std::size_t)>& run, double nanoseconds) {
    std::size_t repetitions = 64;
    while (true) {
        const double taken = run(repetitions).nanoseconds;
        if (taken > nanoseconds / 4)
            return static_cast<std::size_t>(
                std::ceil(static_cast<double>(repetitions) * nanoseconds / taken));
        repetitions *= 2;
    }
}

void run_round(Series& series, Clocks& clocks) {
    const Timing timing = (*series.run)(series.repetitions);
    const auto repetitions = static_cast<double>(series.repetitions);
    series.nanoseconds.push_back(timing.nanoseconds / repetitions);
    series.ticks.push_back(static_cast<double>(timing.ticks) / repetitions);
    clocks.nanoseconds += timing.nanoseconds;
    clocks.ticks += static_cast<double>(timing.ticks);
}

void put(Json& json, const std::string& what, const Series& series, bool ticks) {
    json[what + "_ns"] = median(series.nanoseconds);
    json[what + "_ns_minimum"] = minimum(series.nanoseconds);
    json[what + "_cycles"] = ticks ? Json(median(series.ticks)) : Json(nullptr);
    json[what + "_cycles_minimum"] = ticks ? Json(minimum(series.ticks)) : Json(nullptr);
}

/// Canorb's time over that of the faster of the others.
double ratio(const Json& list, const std::string& suffix) {
    const auto both = [&](const char* side) {
        return list[side]["encode_ns" + suffix].get<double>() +
               list[side]["decode_ns" + suffix].get<double>();
    };
    return both("canorb") / std::min(both("omniorb"), both("fast_cdr"));
}

Json method(std::size_t rounds, double round_nanoseconds, int cpu, const Clocks& clocks) {
    Json json;
    json["loop"] =
        "The same template loop for all; the values and all memory are hidden from the optimizer "
        "in each repetition. In each round canorb, omniORB and Fast CDR take turns for each list, "
        "encode then decode. Median and minimum of the rounds; ratio: canorb's median encode plus "
        "decode over that of the faster of the others.";
    json["rounds"] = rounds;
    json["nanoseconds_of_a_round"] = round_nanoseconds;
    json["cpu"] = cpu;
    json["cycles"] = clocks.ticks > 0 ? "of the time stamp counter (rdtsc), not of the core"
                                      : "not measured: no time stamp counter";
    json["tsc_hertz"] = clocks.ticks > 0 ? Json(clocks.ticks / clocks.nanoseconds * 1e9) : Json();
    json["canorb"] =
        "What a generated stub and skeleton do: encode() of each argument, error(); decode() into "
        "new variables, finished(). The Encoder and Decoder are reset by a copy of one at the "
        "beginning of the message. "
        "Validation is on: NUL octets, bounds, shortest form.";
    json["omniorb"] =
        "What omniidl's marshalArguments and unmarshalArguments do on a cdrMemoryStream in native "
        "octet order that is rewound. Decoded into new variables: String_var, Block_var, "
        "Device_var. "
        "Exceptions as in its run-time library, the id of a system exception compared in its "
        "order. "
        "attach_reference: an IOR with an IIOP profile, of an object of this process.";
    json["fast_cdr"] =
        "What fastddsgen makes: members of a struct, on a Cdr in native octet order over a "
        "FastBuffer of fixed size that is reset, without encapsulation header. Decoded into the "
        "same "
        "struct again, as a DDS reader may. It has no references: attach_nil is an empty string, "
        "attach_reference canorb's stringified reference, which it does not parse. An exception's "
        "id "
        "stays a string.";
    json["check"] = "What each side decodes was compared with the values before timing.";
    return json;
}

/// The indices of the lists to measure.
std::vector<std::size_t> chosen_lists(const Codecs& codecs, const std::string& name) {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < codecs.all().size(); ++i) {
        if (name.empty() || codecs.all()[i].list == name) indices.push_back(i);
    }
    return indices;
}

Json measure(const Options& options) {
    const int cpu = pin(options.cpu);
    // Many short rounds: where others use the CPU, too, few of them are interrupted.
    const std::size_t rounds = options.quick ? 101 : 701;
    const double round_nanoseconds = 2e5;

    Values values;
    std::vector<Side> sides;
    sides.push_back({"canorb", canorb_codecs(values), {}, {}});
    sides.push_back({"omniorb", omniorb_codecs(values), {}, {}});
    sides.push_back({"fast_cdr", fast_cdr_codecs(values), {}, {}});
    for (Side& side : sides) {
        if (!std::ranges::equal(side.codecs.all(), list_names, {}, &Codec::list))
            throw std::runtime_error{side.name + " does not have the lists of the others"};
        for (const Codec& codec : side.codecs.all()) {
            side.encode.push_back(
                {&codec.encode, calibrate(codec.encode, round_nanoseconds), {}, {}});
            side.decode.push_back(
                {&codec.decode, calibrate(codec.decode, round_nanoseconds), {}, {}});
        }
    }

    Clocks clocks;
    const std::vector<std::size_t> lists = chosen_lists(sides.front().codecs, options.list);
    for (std::size_t round = 0; round < rounds; ++round) {
        if (round % 50 == 0) std::fprintf(stderr, "round %zu of %zu\n", round + 1, rounds);
        for (const std::size_t list : lists) {
            for (Side& side : sides) run_round(side.encode[list], clocks);
            for (Side& side : sides) run_round(side.decode[list], clocks);
        }
    }

    Json result;
    for (const std::size_t i : lists) {
        Json list;
        for (const Side& side : sides) {
            const Codec& codec = side.codecs.all()[i];
            Json& of_side = list[side.name];
            of_side["octets"] = codec.octets;
            put(of_side, "encode", side.encode[i], clocks.ticks > 0);
            put(of_side, "decode", side.decode[i], clocks.ticks > 0);
        }
        list["ratio"] = ratio(list, "");
        list["ratio_of_minimums"] = ratio(list, "_minimum");
        result["lists"][sides.front().codecs.all()[i].list] = std::move(list);
    }
    result["method"] = method(rounds, round_nanoseconds, cpu, clocks);
    result["versions"] = {{"canorb", CANORB_VERSION},
                          {"omniorb", omniorb_version()},
                          {"fast_cdr", fast_cdr_version()},
                          {"compiler", __VERSION__},
                          {"cpu", cpu_model()}};
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Time of encoding and decoding argument lists: canorb, omniORB, Fast CDR"};
    Options options;
    app.add_flag("--quick", options.quick, "a short run");
    app.add_option("--cpu", options.cpu, "the CPU to run on (default: the last one)")
        ->check(CLI::Range(0, CPU_SETSIZE - 1));
    app.add_option("--list", options.list, "only this list, for a profile (default: all)")
        ->check(CLI::IsMember(list_names));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        std::cout << measure(options).dump(2) << std::endl;
    } catch (const std::exception& error) {
        std::cerr << "marshalling: " << error.what() << '\n';
        return 1;
    }
    return 0;
}
