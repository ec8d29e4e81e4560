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

/// `time` is not before the first sample.
std::uint64_t BusReporter::busy_bits_until(TimePoint time) const {
    const auto after = std::find_if(samples_.begin(), samples_.end(),
                                    [&](const Sample& sample) { return sample.time > time; });
    const Sample next = after == samples_.end() ? present() : *after;
    const Sample& last = *(after - 1);
    if (next.time == last.time) return last.busy_bits;
    const auto part = static_cast<double>((time - last.time).count()) /
                      static_cast<double>((next.time - last.time).count());
    return last.busy_bits +
           static_cast<std::uint64_t>(static_cast<double>(next.busy_bits - last.busy_bits) * part);
}

std::uint64_t BusReporter::bits_within(Duration duration) const {
    const auto seconds = static_cast<std::uint64_t>(duration / std::chrono::seconds{1});
    const auto rest = static_cast<std::uint64_t>((duration % std::chrono::seconds{1}).count());
    return seconds * bus_.bitrate() + rest * bus_.bitrate() / 1'000'000'000U;
}

BusReport BusReporter::report(std::span<const sim::NodeIndex> nodes) const {
    const sim::BusStatistics statistics = bus_.statistics();
    const TimePoint recent = std::max(start_, bus_.now() - window);
    BusReport report;
    report.bitrate = bus_.bitrate();
    report.bus.time = bus_.now();
    report.bus.bits = bits_within(bus_.now() - start_);
    report.bus.busy_bits = statistics.busy_bits;
    report.bus.recent_bits = bits_within(bus_.now() - recent);
    report.bus.recent_busy_bits = statistics.busy_bits - busy_bits_until(recent);
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
