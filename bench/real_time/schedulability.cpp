#include "schedulability.hpp"

#include <algorithm>

namespace canorb::bench {
namespace {

using Streams = std::span<const Stream>;

std::int64_t divide_up(Duration a, Duration b) {
    return (a.count() + b.count() - 1) / b.count();
}

/// B: by the longest of the less urgent ones, which has just begun.
Duration blocking(Streams streams, std::size_t index) {
    Duration longest{0};
    for (const Stream& lower : streams.subspan(index + 1)) {
        longest = std::max(longest, lower.transmission);
    }
    return longest;
}

/// What the streams have queued within `window`, as transmission time.
Duration demand(Streams streams, Duration window) {
    Duration sum{0};
    for (const Stream& stream : streams) {
        sum += divide_up(window + stream.jitter, stream.period) * stream.transmission;
    }
    return sum;
}

/// The wait of a message behind `ahead` and all that is more urgent and comes before it begins: the
/// least w = ahead + demand(w + a bit), for what is queued one bit time later loses no more.
/// Nothing when that is above `limit`.
std::optional<Duration> queueing(Streams more_urgent, Duration ahead, Duration bit,
                                 Duration limit) {
    Duration wait = ahead;
    while (wait <= limit) {
        const Duration next = ahead + demand(more_urgent, wait + bit);
        if (next == wait) return wait;
        wait = next;
    }
    return std::nullopt;
}

std::optional<Duration> one_instance(Streams streams, std::size_t index, Duration bit,
                                     Duration blocked) {
    const Stream& own = streams[index];
    const Duration limit = std::min(own.deadline, own.period) - own.jitter - own.transmission;
    const auto wait = queueing(streams.first(index), blocked, bit, limit);
    if (!wait) return std::nullopt;
    return own.jitter + *wait + own.transmission;
}

}  // namespace

double utilization(Streams streams) {
    double sum = 0;
    for (const Stream& stream : streams) {
        sum += static_cast<double>(stream.transmission.count()) /
               static_cast<double>(stream.period.count());
    }
    return sum;
}

std::optional<WorstCase> worst_case(Streams streams, std::size_t index, Duration bit) {
    const Stream& own = streams[index];
    const Streams more_urgent = streams.first(index);
    const Streams level = streams.first(index + 1);
    if (utilization(level) >= 1) return std::nullopt;  // it may end at exactly 1, or never
    const Duration blocked = blocking(streams, index);

    Duration busy = own.transmission;
    while (true) {
        const Duration next = blocked + demand(level, busy);
        if (next == busy) break;
        busy = next;
    }

    WorstCase worst{.response = Duration{0}, .instances = divide_up(busy + own.jitter, own.period)};
    for (std::int64_t q = 0; q < worst.instances; ++q) {
        // Below a full bus it ends: no limit.
        const auto wait =
            queueing(more_urgent, blocked + q * own.transmission, bit, Duration::max() / 2);
        const Duration response = own.jitter + *wait - q * own.period + own.transmission;
        if (response > worst.response) {
            worst.response = response;
            worst.worst = q;
        }
    }
    return worst;
}

std::optional<Duration> sufficient_bound(Streams streams, std::size_t index, Duration bit) {
    return one_instance(streams, index, bit,
                        std::max(blocking(streams, index), streams[index].transmission));
}

std::optional<Duration> refuted_bound(Streams streams, std::size_t index, Duration bit) {
    return one_instance(streams, index, bit, blocking(streams, index));
}

}  // namespace canorb::bench
