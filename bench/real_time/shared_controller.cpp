// What the analysis leaves out: it assumes that a node's most urgent frame is always in its
// controller. An ORB has only so many frames there, and takes none back, so calls of its own that
// were queued before can be in the way of an urgent one, and those wait for the frames of others.

#include <canorb/orb.hpp>
#include <canorb/simulation.hpp>

#include <algorithm>
#include <stdexcept>

#include "alarm.hpp"
#include "orb/caniop/identifier.hpp"
#include "orb/runtime/simulation_impl.hpp"
#include "scenarios.hpp"
#include "schedulability.hpp"
#include "statistics.hpp"
#include "traffic.hpp"

namespace canorb::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t urgent_node = 0;
constexpr std::uint8_t urgent_group = 1;
constexpr std::uint8_t called_peer = 9;
constexpr std::size_t own_calls_queued = 4;
constexpr Duration deadline = 100ms;

/// `others_are_groups`: more urgent than the ORB's own calls to a peer; else less urgent.
Outcome run(const std::string& name, const RunOptions& options, const LongestFrame& longest,
            bool others_are_groups, std::uint64_t calls) {
    std::mt19937_64 random{options.seed};
    Simulation simulation;
    SimulatedBus& bus = simulation.add_bus({.bitrate = options.bitrate});
    Orb orb{bus, {.node = urgent_node, .management_object = false}};
    const auto urgent = orb.group_reference(GroupId{urgent_group})
                            .with_timeout(deadline)
                            .unchecked_narrow<RealTime::Alarm>();
    const auto own = orb.string_to_object("corbaloc:caniop:" + std::to_string(called_peer) + "/1")
                         .with_timeout(1h)
                         .unchecked_narrow<RealTime::Alarm>();
    const std::uint32_t urgent_id =
        caniop::Identifier::to_group(GroupId{urgent_group}, NodeId{urgent_node}).can_id();
    const std::uint32_t own_id =
        caniop::Identifier::to_node(NodeId{called_peer}, NodeId{urgent_node}).can_id();

    std::vector<BusyNode> others;
    for (const std::uint8_t node : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}}) {
        std::vector<std::uint32_t> ids;
        for (const int receiver : {20, 25, 30}) {
            ids.push_back(
                (others_are_groups
                     ? caniop::Identifier::to_group(*GroupId::from(receiver), NodeId{node})
                     : caniop::Identifier::to_node(*NodeId::from(receiver), NodeId{node}))
                    .can_id());
        }
        others.emplace_back(bus.attach("busy"), DisturbingFrames{ids, longest, random});
    }

    Responses responses;
    TimePoint called{};
    bool waiting = false;
    std::size_t own_queued = 0;
    bus.on_frame([&](const can::Frame& frame, TimePoint end) {
        if (frame.id == own_id) --own_queued;
        if (frame.id != urgent_id || !waiting) return;
        waiting = false;
        responses.add(end - called);
    });
    const auto keep_busy = [&] {
        for (BusyNode& node : others) node.fill();
        for (; own_queued < own_calls_queued; ++own_queued) own.sound();
    };

    Progress progress{name, calls};
    const Duration transmission =
        bit_times(longest_by_formula(can::Frame::max_classic_payload), options.bitrate);
    const auto spread = static_cast<std::uint64_t>(transmission.count());
    std::uint64_t expired = 0;
    for (std::uint64_t i = 0; i < calls; ++i) {
        keep_busy();
        simulation.run_for(2 * transmission +
                           Duration{static_cast<std::int64_t>(random() % spread)});
        keep_busy();
        called = simulation.now();
        waiting = true;
        urgent.sound();
        while (waiting && simulation.now() < called + 2 * deadline) {
            simulation.run_for(2 * transmission);
            keep_busy();
        }
        if (waiting) ++expired;
        waiting = false;
        progress.reached(i);
    }
    const can::sim::BusStatistics statistics = simulation.impl().frames(0).statistics();
    check_undisturbed(statistics);

    // Two frames come first: one that has just begun, and one of the own, whose place it takes.
    const std::vector<Stream> streams(2, Stream{transmission, 1h, 1h});
    const Duration alone = worst_case(streams, 0, bit_times(1, options.bitrate))->response;
    const Duration behind_own = alone + transmission;
    Outcome outcome;
    nlohmann::ordered_json& json = outcome.json;
    json["bitrate"] = options.bitrate;
    json["frames_in_controller"] = orb.options().frames_in_controller;
    json["analysis_applies"] = false;
    json["calls"] = calls;
    json["expired"] = expired;
    json["deadline_ns"] = deadline.count();
    json.update(responses.summary(alone));
    if (!others_are_groups) {
        json["bound_with_own_frame_ns"] = behind_own.count();
        json["exceeded_bound_with_own_frame"] = responses.above(behind_own);
        outcome.holds = expired == 0 && responses.above(behind_own) == 0;
    }
    json["load_percent"] = load_percent(statistics);
    json["histogram"] = responses.histogram(5 * bit_times(1, options.bitrate));
    json["seconds"] = progress.seconds();
    return outcome;
}

}  // namespace

Outcome shared_controller(const RunOptions& options, const LongestFrame& longest) {
    const std::uint64_t calls = std::max<std::uint64_t>(options.messages / 20, 1);
    Outcome less =
        run("shared_controller, others less urgent than own calls", options, longest, false, calls);
    Outcome more = run("shared_controller, others more urgent than own calls", options, longest,
                       true, std::min<std::uint64_t>(calls, options.quick ? 5 : 50));
    return {.json = {{"others_less_urgent_than_own_calls", std::move(less.json)},
                     {"others_more_urgent_than_own_calls", std::move(more.json)}},
            .holds = less.holds && more.holds};
}

}  // namespace canorb::bench
