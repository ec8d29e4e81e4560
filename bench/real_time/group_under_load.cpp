// Node 0 calls group 1, whose identifier is the most urgent that an application can have. Three
// other nodes, each with a frame in every mailbox, keep the bus full.

#include <canorb/orb.hpp>
#include <canorb/simulation.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "alarm.hpp"
#include "orb/can/frame_length.hpp"
#include "orb/caniop/identifier.hpp"
#include "orb/runtime/simulation_impl.hpp"
#include "scenarios.hpp"
#include "schedulability.hpp"
#include "statistics.hpp"
#include "traffic.hpp"

namespace canorb::bench {
namespace {

constexpr std::uint8_t urgent_node = 0;
constexpr std::uint8_t urgent_group = 1;
constexpr int busy_nodes = 3;

/// Of one busy node: groups and peers from most to least urgent, group 1 among them. Nothing goes
/// to the ORB's node: it would answer, and shared_controller.cpp is about frames of its own.
std::vector<std::uint32_t> less_urgent_ids(int node) {
    std::vector<std::uint32_t> ids;
    for (const int group : {1, 2, 7, 16, 31}) {
        ids.push_back(
            caniop::Identifier::to_group(*GroupId::from(group), *NodeId::from(node)).can_id());
    }
    for (const int peer : {4, 9, 20, 30}) {
        ids.push_back(
            caniop::Identifier::to_node(*NodeId::from(peer), *NodeId::from(node)).can_id());
    }
    return ids;
}

}  // namespace

Outcome group_under_load(const RunOptions& options, const LongestFrame& longest) {
    std::mt19937_64 random{options.seed};
    const Duration bit = bit_times(1, options.bitrate);
    const std::uint32_t most_bits = longest_by_formula(can::Frame::max_classic_payload);

    Simulation simulation;
    SimulatedBus& bus = simulation.add_bus({.bitrate = options.bitrate});
    Orb orb{bus, {.node = urgent_node, .management_object = false}};
    const auto alarm = orb.group_reference(GroupId{urgent_group}).narrow<RealTime::Alarm>();
    const std::uint32_t urgent_id =
        caniop::Identifier::to_group(GroupId{urgent_group}, NodeId{urgent_node}).can_id();

    std::vector<BusyNode> others;
    std::uint32_t blocking_bits = 0;
    for (int node = 1; node <= busy_nodes; ++node) {
        const std::vector<std::uint32_t> ids = less_urgent_ids(node);
        others.emplace_back(bus.attach("busy"), DisturbingFrames{ids, longest, random});
        blocking_bits = std::max(blocking_bits, others.back().longest_bits());
    }

    // The least period is the bound itself, so that no two of them wait at a time, and the rest is
    // random by about one frame, so that calls come at every phase of the others' frames.
    const Duration transmission = bit_times(most_bits, options.bitrate);
    const Duration least_period = 2 * transmission;
    const auto spread = static_cast<std::uint64_t>(transmission.count());
    const std::array<Stream, 2> streams{
        Stream{.transmission = transmission, .period = least_period, .deadline = least_period},
        Stream{.transmission = transmission, .period = least_period, .deadline = least_period}};
    const Duration bound = worst_case(streams, 0, bit)->response;

    Responses responses;
    responses.reserve(options.messages);
    TimePoint called{};
    bool waiting = false;
    std::uint32_t urgent_bits = 0;
    bus.on_frame([&](const can::Frame& frame, TimePoint end) {
        if (frame.id != urgent_id) return;
        if (!waiting) throw std::runtime_error("an urgent message was sent twice");
        waiting = false;
        responses.add(end - called);
        // Only the request's number differs, so some of them are the longest.
        if (responses.messages() <= 0x10000) {
            urgent_bits = std::max(urgent_bits, can::frame_length(frame));
        }
    });

    Progress progress{"group_under_load", options.messages};
    TimePoint next = simulation.now() + least_period;
    std::uint64_t overdue = 0;
    for (BusyNode& node : others) node.fill();
    for (std::uint64_t i = 0; i < options.messages; ++i) {
        simulation.run_until(next);
        if (waiting) ++overdue;
        // It is to be counted, however late.
        for (int j = 0; waiting && j < 100; ++j) {
            for (BusyNode& node : others) node.fill();
            simulation.run_for(least_period);
        }
        if (waiting) throw std::runtime_error("an urgent message was not sent");
        for (BusyNode& node : others) node.fill();
        called = simulation.now();
        waiting = true;
        alarm.sound();
        next = called + least_period + Duration{static_cast<std::int64_t>(random() % spread)};
        if (i % 4096 == 0) progress.reached(i);
    }
    simulation.run_until(next);
    const can::sim::BusStatistics statistics = simulation.impl().frames(0).statistics();
    check_undisturbed(statistics);

    Outcome outcome;
    nlohmann::ordered_json& json = outcome.json;
    json["bitrate"] = options.bitrate;
    json.update(responses.summary(bound));
    const Duration reachable =
        bit_times(blocking_bits + urgent_bits - can::intermission_bits, options.bitrate);
    json["longest_frame_bits"] = {
        {"by_formula", most_bits}, {"of_others", blocking_bits}, {"of_urgent", urgent_bits}};
    json["reachable_bound_ns"] = reachable.count();
    json["exceeded_reachable_bound"] = responses.above(reachable);
    json["overdue_at_next_call"] = overdue;
    json["load_percent"] = load_percent(statistics);
    json["frames_on_bus"] = statistics.frames;
    json["simulated_seconds"] =
        std::chrono::duration<double>(simulation.now().time_since_epoch()).count();
    json["histogram"] = responses.histogram(5 * bit);
    json["seconds"] = progress.seconds();
    outcome.holds = responses.messages() == options.messages && responses.above(bound) == 0 &&
                    responses.above(reachable) == 0;
    return outcome;
}

}  // namespace canorb::bench
