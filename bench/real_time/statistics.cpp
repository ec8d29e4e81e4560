#include "statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace canorb::bench {

using nlohmann::ordered_json;

std::uint64_t Responses::above(Duration bound) const {
    return static_cast<std::uint64_t>(std::count_if(
        times_.begin(), times_.end(), [bound](std::int64_t time) { return time > bound.count(); }));
}

Duration Responses::longest() const {
    return Duration{times_.empty() ? 0 : *std::max_element(times_.begin(), times_.end())};
}

ordered_json Responses::summary(std::optional<Duration> bound) {
    ordered_json json;
    json["messages"] = times_.size();
    if (times_.empty()) return json;
    std::sort(times_.begin(), times_.end());
    // The least value that at least this part of all do not exceed.
    const auto quantile = [this](double part) {
        const auto rank = std::ceil(part * static_cast<double>(times_.size()));
        return times_[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
    };
    json["min_ns"] = times_.front();
    json["median_ns"] = quantile(0.5);
    json["p99_ns"] = quantile(0.99);
    json["p999_ns"] = quantile(0.999);
    json["max_ns"] = times_.back();
    if (bound) {
        json["bound_ns"] = bound->count();
        json["exceeded"] = above(*bound);
    }
    return json;
}

ordered_json Responses::histogram(Duration bucket) const {
    std::vector<std::uint64_t> counts(
        times_.empty() ? 0 : static_cast<std::size_t>(longest() / bucket) + 1);
    for (const std::int64_t time : times_) {
        ++counts[static_cast<std::size_t>(time / bucket.count())];
    }
    return {{"bucket_ns", bucket.count()}, {"counts", counts}};
}

double load_percent(const can::sim::BusStatistics& statistics) {
    return 100 * static_cast<double>(statistics.busy_bits) /
           static_cast<double>(std::max<std::uint64_t>(statistics.elapsed_bits, 1));
}

void check_undisturbed(const can::sim::BusStatistics& statistics) {
    if (statistics.error_frames != 0) throw std::runtime_error("there were errors on the bus");
}

Progress::Progress(std::string name, std::uint64_t goal) : name_(std::move(name)), goal_(goal) {
    std::fprintf(stderr, "%s ...\n", name_.c_str());
}

void Progress::reached(std::uint64_t done) {
    const auto now = Clock::now();
    if (now - told_ < std::chrono::seconds{3}) return;
    told_ = now;
    std::fprintf(stderr, "%s: %.1f %% after %.0f s\n", name_.c_str(),
                 100 * static_cast<double>(done) / static_cast<double>(goal_), seconds());
}

double Progress::seconds() const {
    return std::chrono::duration<double>(Clock::now() - begin_).count();
}

}  // namespace canorb::bench
