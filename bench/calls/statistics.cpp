#include "statistics.hpp"

#include <algorithm>
#include <numeric>

namespace canorb::bench {
namespace {

double at(const std::vector<std::int64_t>& sorted, double part) {
    if (sorted.empty()) return 0;
    return static_cast<double>(
        sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))]);
}

}  // namespace

nlohmann::json Statistics::json() const {
    std::vector<std::int64_t> times = times_;
    std::ranges::sort(times);
    const double sum = std::accumulate(times.begin(), times.end(), 0.0);
    const double mean = times.empty() ? 0 : sum / static_cast<double>(times.size());
    return {{"min_ns", at(times, 0)},
            {"median_ns", at(times, 0.5)},
            {"p99_ns", at(times, 0.99)},
            {"p99_9_ns", at(times, 0.999)},
            {"mean_ns", mean},
            {"count", times.size()},
            {"per_second", mean > 0 ? 1e9 / mean : 0}};
}

}  // namespace canorb::bench
