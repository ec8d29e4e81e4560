#include "self_test.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <random>

#include "orb/can/frame_length.hpp"
#include "schedulability.hpp"

namespace canorb::bench {
namespace {

using namespace std::chrono_literals;
using nlohmann::ordered_json;

class Checks {
  public:
    void add(const std::string& what, bool passed) {
        list_.push_back({{"check", what}, {"passed", passed}});
        all_ = all_ && passed;
    }
    ordered_json json() const { return {{"passed", all_}, {"checks", list_}}; }

  private:
    ordered_json list_ = ordered_json::array();
    bool all_ = true;
};

void check_formula(Checks& checks) {
    bool equal = true;
    for (std::uint32_t octets = 0; octets <= 8; ++octets) {
        equal = equal && longest_by_formula(octets) == 55 + 10 * octets;
    }
    checks.add("frames have at most 55 + 10 s bits", equal);
}

/// The example of the paper: 3 messages of 7 octets at 125 kbit/s.
void check_example(Checks& checks) {
    const Duration bit = bit_times(1, 125'000);
    const Duration transmission = bit_times(longest_by_formula(7), 125'000);
    const std::array<Stream, 3> streams{Stream{transmission, 2500us, 2500us},
                                        Stream{transmission, 3500us, 3250us},
                                        Stream{transmission, 3500us, 3250us}};
    const auto response = [&](std::size_t i) { return worst_case(streams, i, bit)->response; };
    checks.add("example: C is 1 ms", transmission == 1ms);
    checks.add("example: R of A is 2 ms", response(0) == 2ms);
    checks.add("example: R of B is 3 ms", response(1) == 3ms);
    checks.add("example: R of C is 3.5 ms, beyond its deadline", response(2) == 3500us);
    checks.add("example: the second instance of C is the worst",
               worst_case(streams, 2, bit)->worst == 1);
    checks.add("example: the refuted analysis has 3 ms for C",
               refuted_bound(streams, 2, bit) == Duration{3ms});
    checks.add("example: C fails the sufficient test", !sufficient_bound(streams, 2, bit));
}

/// The longest response times of a schedule without preemption, by ticks of one bit, where all
/// streams begin at 0 and a less urgent one has just got the bus, if `blocked`.
std::vector<Duration> schedule(std::span<const Stream> streams, std::size_t level, bool blocked,
                               Duration bit, std::int64_t ticks) {
    std::vector<Duration> longest(streams.size());
    std::vector<std::deque<std::int64_t>> queued(streams.size());
    std::int64_t free_at = 0;
    for (std::size_t i = level + 1; blocked && i < streams.size(); ++i) {
        free_at = std::max<std::int64_t>(free_at, streams[i].transmission / bit - 1);
    }
    for (std::int64_t now = 0; now < ticks; ++now) {
        for (std::size_t i = 0; i <= level; ++i) {
            if (now % (streams[i].period / bit) == 0) queued[i].push_back(now);
        }
        if (now < free_at) continue;
        const auto first = std::find_if(queued.begin(), queued.end(),
                                        [](const auto& queue) { return !queue.empty(); });
        if (first == queued.end()) continue;
        const auto i = static_cast<std::size_t>(first - queued.begin());
        free_at = now + streams[i].transmission / bit;
        longest[i] = std::max(longest[i], (free_at - first->front()) * bit);
        first->pop_front();
    }
    return longest;
}

/// No schedule takes longer than the exact bound, most come within two bits of it, and the
/// sufficient one is never below it.
void check_random_sets(Checks& checks) {
    std::mt19937_64 random{1};
    const Duration bit = bit_times(1, 1'000'000);
    bool safe = true;
    bool ordered = true;
    std::uint64_t compared = 0;
    std::uint64_t reached = 0;
    for (int set = 0; set < 400; ++set) {
        std::vector<Stream> streams(3 + random() % 5);
        for (Stream& stream : streams) {
            stream.transmission =
                bit_times(longest_by_formula(static_cast<std::uint32_t>(random() % 9)), 1'000'000);
            stream.period = bit * static_cast<std::int64_t>(300 + random() % 1500);
            stream.deadline = stream.period;
        }
        if (utilization(streams) > 0.98) continue;
        for (std::size_t level = 0; level < streams.size(); ++level) {
            const auto exact = worst_case(streams, level, bit);
            const auto sufficient = sufficient_bound(streams, level, bit);
            if (sufficient && *sufficient < exact->response) ordered = false;
            const Duration seen = schedule(streams, level, true, bit, 20'000)[level];
            if (seen > exact->response) safe = false;
            ++compared;
            if (seen + 2 * bit >= exact->response) ++reached;
        }
    }
    checks.add("random sets: no computed schedule exceeds the exact bound", safe && compared > 500);
    checks.add("random sets: 19 of 20 computed schedules reach it within 2 bits",
               reached * 20 >= compared * 19);
    checks.add("random sets: the sufficient bound is never below the exact one", ordered);
}

void check_longest_frames(Checks& checks, const LongestFrame& longest) {
    std::mt19937_64 random{2};
    bool within = true;
    bool most = true;
    for (int i = 0; i < 200; ++i) {
        const auto id = static_cast<std::uint32_t>(random() % 0x7E0);
        // With 0 or 1 octets all frames can be tried.
        for (const std::uint8_t octets : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{8}}) {
            const can::Frame found = longest.find(id, octets, random);
            const std::uint32_t bits = can::frame_length(found);
            within = within && bits <= longest_by_formula(octets);
            std::uint32_t tried = 0;
            can::Frame frame = found;
            for (std::uint64_t j = 0; j < 256; ++j) {
                for (std::uint8_t k = 0; k < octets; ++k) {
                    frame.data[k] = static_cast<std::uint8_t>(octets == 1 ? j : random() % 256);
                }
                tried = std::max(tried, can::frame_length(frame));
            }
            most = most && (octets == 8 ? tried <= bits : tried == bits);
        }
    }
    checks.add("longest frames: within the formula", within);
    checks.add("longest frames: no frame that was tried is longer", most);
}

}  // namespace

ordered_json self_test(const LongestFrame& longest) {
    Checks checks;
    check_formula(checks);
    check_example(checks);
    check_random_sets(checks);
    check_longest_frames(checks, longest);
    return checks.json();
}

}  // namespace canorb::bench
