#include "orb/can/link/bus_report.hpp"

#include <algorithm>

namespace canorb::can {
namespace {

constexpr Duration window = std::chrono::seconds{1};
/// So samples_ has two thousand elements at most, however often sample() is called.
constexpr Duration resolution = std::chrono::milliseconds{1};

}  // namespace

BusReporter::BusReporter(const sim::Bus& bus) : bus_(bus), start_(bus.now()) {
    samples_.push_back(present());
}

BusReporter::Sample BusReporter::present() const {
    const sim::BusStatistics statistics = bus_.statistics();
    return {bus_.now(), statistics.elapsed_bits, statistics.busy_bits};
}

void BusReporter::sample() {
    const Sample now = present();
    const std::size_t count = samples_.size();
    // One that the samples beside it make superfluous goes: on an idle bus, or when they are close.
    if (count >= 2) {
        const Sample& before = samples_[count - 2];
        const bool idle = before.busy_bits == now.busy_bits;
        if (idle || now.time - before.time < resolution) samples_.pop_back();
    }
    samples_.push_back(now);
    while (samples_.size() >= 2 && samples_[1].time <= now.time - window) samples_.pop_front();
}

/// The bits that were over at `time`, which is not before the first sample.
BusReporter::Sample BusReporter::sample_at(TimePoint time) const {
    const auto after = std::find_if(samples_.begin(), samples_.end(),
                                    [&](const Sample& sample) { return sample.time > time; });
    const Sample next = after == samples_.end() ? present() : *after;
    const Sample& last = *(after - 1);
    if (next.time == last.time) return last;
    const auto part = static_cast<double>((time - last.time).count()) /
                      static_cast<double>((next.time - last.time).count());
    const auto between = [part](std::uint64_t from, std::uint64_t to) {
        return from + static_cast<std::uint64_t>(static_cast<double>(to - from) * part);
    };
    // Rounded the same way, so that no bits are busy that are not over.
    const std::uint64_t idle_bits = between(last.bits - last.busy_bits, next.bits - next.busy_bits);
    const std::uint64_t busy_bits = between(last.busy_bits, next.busy_bits);
    return {time, idle_bits + busy_bits, busy_bits};
}

BusReport BusReporter::report(std::span<const sim::NodeIndex> nodes) const {
    const sim::BusStatistics statistics = bus_.statistics();
    const Sample recent = sample_at(std::max(start_, bus_.now() - window));
    BusReport report;
    report.bitrate = bus_.bitrate();
    report.bus.time = bus_.now();
    report.bus.bits = statistics.elapsed_bits;
    report.bus.busy_bits = statistics.busy_bits;
    report.bus.recent_bits = statistics.elapsed_bits - recent.bits;
    report.bus.recent_busy_bits = statistics.busy_bits - recent.busy_bits;
    report.bus.frames = statistics.frames;
    report.bus.error_frames = statistics.error_frames;
    report.bus.nodes = static_cast<std::uint16_t>(nodes.size());
    for (const sim::NodeIndex node : nodes) {
        const sim::NodeStatistics& done = bus_.statistics(node);
        report.nodes.push_back({bus_.error_status(node), done.sent, done.received,
                                done.lost_arbitrations, done.errors, bus_.name(node)});
    }
    return report;
}

}  // namespace canorb::can
