#include "latency.hpp"

#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <stdexcept>
#include <system_error>

namespace peers {

namespace {

std::vector<int> allowed_cpus() {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (::sched_getaffinity(0, sizeof(set), &set) != 0) {
        throw std::system_error(errno, std::generic_category(), "sched_getaffinity");
    }
    std::vector<int> cpus;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
        if (CPU_ISSET(static_cast<std::size_t>(cpu), &set)) cpus.push_back(cpu);
    }
    return cpus;
}

nlohmann::ordered_json cpu_or_null(std::optional<int> cpu) {
    return cpu ? nlohmann::ordered_json(*cpu) : nlohmann::ordered_json(nullptr);
}

}  // namespace

RoundTrips round_trips(bool quick) {
    return quick ? RoundTrips{1'000, 4'000, 4'000} : RoundTrips{2'000, 30'000, 20'000};
}

Placement placement(const std::string& name) {
    if (name == "any") return {};
    const auto cpus = allowed_cpus();
    if (name == "one") return {cpus.at(0), cpus.at(0)};
    if (cpus.size() < 2) throw std::runtime_error("this process may run on one CPU only");
    return {cpus[0], cpus[1]};
}

void pin(std::optional<int> cpu) {
    if (!cpu) return;
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(*cpu), &set);
    if (::sched_setaffinity(0, sizeof(set), &set) != 0) {
        throw std::system_error(errno, std::generic_category(), "sched_setaffinity");
    }
}

nlohmann::ordered_json figures(LatencyResult result, const RoundTrips& counts,
                               const std::string& cpus, const Placement& place) {
    auto& times = result.times;
    if (times.empty()) throw std::runtime_error("nothing was timed");
    std::sort(times.begin(), times.end());
    // The nearest rank: so many percent of all took at most that long.
    const auto at = [&](double percent) {
        const double rank = std::ceil(percent / 100.0 * static_cast<double>(times.size()));
        const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
        return std::chrono::nanoseconds{times[index]}.count();
    };
    const double seconds = std::chrono::duration<double>{result.throughput_time}.count();
    return {{"cpus", cpus},
            {"client_cpu", cpu_or_null(place.client)},
            {"server_cpu", cpu_or_null(place.server)},
            {"round_trips", times.size()},
            {"min", at(0.0)},
            {"median", at(50.0)},
            {"p99", at(99.0)},
            {"p99_9", at(99.9)},
            {"max", at(100.0)},
            {"calls_per_second", static_cast<double>(counts.throughput) / seconds}};
}

}  // namespace peers
