// Sets of periodic streams: 12 on 5 nodes, and the example of the analysis's paper. The worst case
// is sought, not waited for: now and then a stream and all that are more urgent are queued at one
// moment, just after the longest of the less urgent ones.

#include <canorb/orb.hpp>
#include <canorb/simulation.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <stdexcept>
#include <string>

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

using namespace std::chrono_literals;

constexpr std::uint32_t set_bitrate = 125'000;
constexpr Duration set_bit = bit_times(1, set_bitrate);

struct Member {
    caniop::Identifier identifier;
    std::uint8_t octets;
    Duration period;
    Duration jitter;
};

constexpr caniop::Identifier to_group(std::uint8_t node, std::uint8_t group) {
    return caniop::Identifier::to_group(GroupId{group}, NodeId{node});
}
constexpr caniop::Identifier to_node(std::uint8_t node, std::uint8_t peer) {
    return caniop::Identifier::to_node(NodeId{peer}, NodeId{node});
}

/// Most urgent first. No node is called that there is: it would answer.
constexpr std::array<Member, 12> twelve{{{to_group(1, 1), 2, 5ms, 0ms},
                                         {to_group(2, 2), 8, 10ms, 1ms},
                                         {to_group(3, 3), 6, 10ms, 0ms},
                                         {to_group(1, 4), 8, 12500us, 500us},
                                         {to_group(4, 5), 4, 10ms, 0ms},
                                         {to_group(5, 6), 8, 15ms, 2ms},
                                         {to_group(2, 7), 8, 20ms, 0ms},
                                         {to_node(3, 20), 5, 20ms, 0ms},
                                         {to_node(4, 21), 8, 20ms, 1ms},
                                         {to_node(1, 22), 8, 25ms, 0ms},
                                         {to_node(5, 23), 7, 25ms, 0ms},
                                         {to_node(2, 24), 8, 30ms, 0ms}}};
constexpr int highest_node = 5;

using Members = std::span<const Member>;
using Streams = std::vector<Stream>;

Streams by_formula(double lengthen, bool full_frames) {
    Streams streams;
    for (const Member& member : twelve) {
        const std::uint32_t bits = longest_by_formula(full_frames ? 8 : member.octets);
        const Duration period{std::llround(static_cast<double>(member.period.count()) * lengthen)};
        streams.push_back({bit_times(bits, set_bitrate), period, period, member.jitter});
    }
    return streams;
}

/// When what is queued.
class Releases {
  public:
    Releases(const Streams& streams, std::mt19937_64& random)
        : streams_(streams), random_(random), next_(streams.size()) {
        for (std::size_t i = 0; i < streams.size(); ++i) {
            const TimePoint event = TimePoint{} + up_to(streams[i].period);
            next_[i] = {event, event};
        }
    }

    struct Release {
        TimePoint event;
        TimePoint queued;  ///< by the jitter later
    };

    /// The stream that is queued next, and when. Plans its next one.
    std::pair<std::size_t, Release> next() {
        if (++taken_ % releases_between_critical_instants == 0) plan_critical_instant();
        const auto first = std::min_element(
            next_.begin(), next_.end(),
            [](const Release& a, const Release& b) { return a.queued < b.queued; });
        const auto index = static_cast<std::size_t>(first - next_.begin());
        const Release release = *first;
        const Stream& stream = streams_[index];
        first->event = release.event + stream.period;
        first->queued = first->event;
        if (random_() % 2 == 0) first->queued += up_to(stream.jitter);
        // In their order, even if a jitter were longer than a period.
        first->queued = std::max(first->queued, release.queued);
        return {index, release};
    }

  private:
    static constexpr std::uint64_t releases_between_critical_instants = 200;

    Duration up_to(Duration longest) {
        const auto values = static_cast<std::uint64_t>(longest.count()) + 1;
        return Duration{static_cast<std::int64_t>(random_() % values)};
    }

    /// Periods are least ones, so each stream may wait until all can begin together.
    void plan_critical_instant() {
        const std::size_t chosen = random_() % streams_.size();
        TimePoint instant{};
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            instant = std::max(instant, next_[i].event + streams_[i].jitter + 1ns);
            instant = std::max(instant, next_[i].queued + 1ns);
        }
        std::size_t longest = chosen;
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            if (i <= chosen) {
                // What was delayed most, so that the next of its stream comes soonest.
                next_[i] = {instant - streams_[i].jitter, instant};
                continue;
            }
            next_[i].event = next_[i].queued = instant + up_to(streams_[i].period);
            if (longest == chosen || streams_[i].transmission > streams_[longest].transmission) {
                longest = i;
            }
        }
        if (longest != chosen) next_[longest] = {instant - 1ns, instant - 1ns};
    }

    const Streams& streams_;
    std::mt19937_64& random_;
    std::vector<Release> next_;
    std::uint64_t taken_ = 0;
};

/// What is simulated, and how.
struct Set {
    std::string name;
    Members members;
    Streams streams;
    bool analysis_applies = true;
    std::function<void(std::size_t)> send;  ///< queues one message of a stream at now()
};

Outcome run(const RunOptions& options, Simulation& simulation, SimulatedBus& bus, const Set& set) {
    const Members members = set.members;
    const Streams& streams = set.streams;
    std::mt19937_64 random{options.seed};
    const std::uint64_t messages = std::max<std::uint64_t>(options.messages / 5, 1);
    std::vector<Responses> responses(members.size());
    std::vector<std::deque<TimePoint>> pending(members.size());
    std::vector<std::uint32_t> longest_bits(members.size());
    std::array<std::size_t, 2048> stream_of;
    stream_of.fill(members.size());
    for (std::size_t i = 0; i < members.size(); ++i) stream_of[members[i].identifier.can_id()] = i;
    bus.on_frame([&](const can::Frame& frame, TimePoint end) {
        const std::size_t index = stream_of.at(frame.id);
        if (index == members.size() || pending[index].empty()) {
            throw std::runtime_error("a frame on the bus that nobody should send");
        }
        responses[index].add(end - pending[index].front());
        pending[index].pop_front();
        longest_bits[index] = std::max(longest_bits[index], can::frame_length(frame));
    });

    Progress progress{set.name, messages};
    Releases releases{streams, random};
    for (std::uint64_t i = 0; i < messages; ++i) {
        const auto [index, release] = releases.next();
        simulation.run_until(release.queued);
        pending[index].push_back(release.event);
        set.send(index);
        if (i % 4096 == 0) progress.reached(i);
    }
    simulation.run_for(1s);  // what is still queued
    const can::sim::BusStatistics statistics = simulation.impl().frames(0).statistics();
    check_undisturbed(statistics);

    // What the analysis says with the frames that there were.
    Streams sent_streams = streams;
    for (std::size_t i = 0; i < members.size(); ++i) {
        sent_streams[i].transmission = bit_times(longest_bits[i], set_bitrate);
    }

    Outcome outcome;
    nlohmann::ordered_json& json = outcome.json;
    json["bitrate"] = set_bitrate;
    json["analysis_applies"] = set.analysis_applies;
    json["utilization_percent"] = 100 * utilization(streams);
    json["load_percent"] = load_percent(statistics);
    std::uint64_t sent = 0;
    std::uint64_t exceeded = 0;
    std::uint64_t exceeded_reachable = 0;
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < members.size(); ++i) {
        const auto worst = worst_case(streams, i, set_bit);
        if (!worst) throw std::runtime_error("the set needs more than the bus");
        sent += responses[i].messages();
        exceeded += responses[i].above(worst->response);
        nlohmann::ordered_json row;
        row["identifier"] = members[i].identifier.can_id();
        row["node"] = members[i].identifier.sender;
        row["peer_to_peer"] = members[i].identifier.peer_to_peer;
        row["transmission_ns"] = streams[i].transmission.count();
        row["period_ns"] = streams[i].period.count();
        row["jitter_ns"] = streams[i].jitter.count();
        row["instances_examined"] = worst->instances;
        row["worst_instance"] = worst->worst;
        row.update(responses[i].summary(worst->response));
        const auto sufficient = sufficient_bound(streams, i, set_bit);
        row["sufficient_bound_ns"] =
            sufficient ? nlohmann::ordered_json(sufficient->count()) : nullptr;
        const Duration reachable = worst_case(sent_streams, i, set_bit)->response -
                                   bit_times(can::intermission_bits, set_bitrate);
        row["longest_frame_bits"] = longest_bits[i];
        row["reachable_bound_ns"] = reachable.count();
        row["exceeded_reachable_bound"] = responses[i].above(reachable);
        if (const auto refuted = refuted_bound(streams, i, set_bit)) {
            row["refuted_bound_ns"] = refuted->count();
            row["above_refuted_bound"] = responses[i].above(*refuted);
        }
        exceeded_reachable += responses[i].above(reachable);
        row["histogram"] = responses[i].histogram(10 * set_bit);
        rows.push_back(std::move(row));
    }
    json["messages"] = sent;
    json["not_sent"] = messages - sent;
    json["exceeded"] = exceeded;
    json["exceeded_reachable_bound"] = exceeded_reachable;
    json["streams"] = std::move(rows);
    json["simulated_seconds"] =
        std::chrono::duration<double>(simulation.now().time_since_epoch()).count();
    json["seconds"] = progress.seconds();
    outcome.holds =
        !set.analysis_applies || (exceeded == 0 && exceeded_reachable == 0 && sent == messages);
    return outcome;
}

/// On controllers that have room for all messages of their nodes. Most frames are the longest that
/// there are with their identifiers and lengths.
Outcome run_on_controllers(const std::string& name, const RunOptions& options,
                           const LongestFrame& longest, Members members, Streams streams) {
    std::mt19937_64 random{options.seed + 1};
    Simulation simulation;
    SimulatedBus& bus = simulation.add_bus({.bitrate = set_bitrate});
    std::vector<std::unique_ptr<can::Controller>> controllers;
    for (int node = 0; node <= highest_node; ++node) controllers.push_back(bus.attach("member"));

    std::vector<std::vector<can::Frame>> frames(members.size());
    for (std::size_t i = 0; i < members.size(); ++i) {
        for (int j = 0; j < 64; ++j) {
            frames[i].push_back(
                longest.find(members[i].identifier.can_id(), members[i].octets, random));
        }
    }
    const auto send = [&](std::size_t index) {
        can::Frame frame = frames[index][random() % frames[index].size()];
        if (random() % 4 == 0) {
            for (std::uint8_t i = 0; i < frame.length; ++i) {
                frame.data[i] = static_cast<std::uint8_t>(random());
            }
        }
        can::Controller& controller = *controllers[members[index].identifier.sender];
        free_mailboxes(controller);
        if (!std::holds_alternative<can::TransmitHandle>(controller.send(frame))) {
            throw std::runtime_error("a controller is full");
        }
    };
    return run(options, simulation, bus, {name, members, std::move(streams), true, send});
}

}  // namespace

Outcome periodic_set(const RunOptions& options, const LongestFrame& longest) {
    return run_on_controllers("periodic_set", options, longest, twelve, by_formula(1, false));
}

Outcome paper_example(const RunOptions& options, const LongestFrame& longest) {
    // One identifier of each of three nodes, such that all have frames of the same, greatest
    // length.
    constexpr std::uint8_t octets = 7;
    constexpr std::uint8_t nodes = 3;
    std::mt19937_64 random{options.seed};
    const auto length = [&](const caniop::Identifier& identifier) {
        return can::frame_length(longest.find(identifier.can_id(), octets, random));
    };
    std::vector<Member> members;
    std::uint32_t bits = longest_by_formula(octets) + 1;
    while (members.size() < nodes) {
        if (--bits == 0) throw std::runtime_error("no three identifiers with equal frames");
        members.clear();
        for (std::uint8_t group = 1; group <= GroupId::highest && members.size() < nodes; ++group) {
            const auto identifier = to_group(static_cast<std::uint8_t>(members.size() + 1), group);
            if (length(identifier) == bits) members.push_back({identifier, octets, {}, {}});
        }
    }
    // Periods of 2.5, 3.5 and 3.5 C and deadlines of 2.5, 3.25 and 3.25 C. There is no frame as
    // long as the formula's, so C is that of the longest there is.
    const Duration c = bit_times(bits, set_bitrate);
    const Streams streams{
        {c, c * 5 / 2, c * 5 / 2}, {c, c * 7 / 2, c * 13 / 4}, {c, c * 7 / 2, c * 13 / 4}};
    return run_on_controllers("paper_example", options, longest, members, streams);
}

Outcome periodic_set_of_calls(const RunOptions& options, std::size_t frames_in_controller) {
    Simulation simulation;
    SimulatedBus& bus = simulation.add_bus({.bitrate = set_bitrate});
    std::vector<std::unique_ptr<Orb>> orbs;
    for (int node = 0; node <= highest_node; ++node) {
        orbs.push_back(
            std::make_unique<Orb>(bus, OrbOptions{.node = node,
                                                  .management_object = false,
                                                  .frames_in_controller = frames_in_controller}));
    }
    std::vector<RealTime::Alarm> alarms;
    for (const Member& member : twelve) {
        const std::string receiver = std::to_string(member.identifier.receiver);
        alarms.push_back(orbs[member.identifier.sender]
                             ->string_to_object("corbaloc:caniop:" + (member.identifier.peer_to_peer
                                                                          ? receiver + "/1"
                                                                          : "group/" + receiver))
                             .unchecked_narrow<RealTime::Alarm>());
    }
    // All frames have 8 octets now: longer periods give the same utilization.
    const double lengthen = utilization(by_formula(1, true)) / utilization(by_formula(1, false));
    // Each node has a frame of each of its streams in its controller at a time, or it has not.
    std::array<std::size_t, highest_node + 1> streams_of_node{};
    for (const Member& member : twelve) ++streams_of_node[member.identifier.sender];
    const bool all_fit =
        *std::max_element(streams_of_node.begin(), streams_of_node.end()) <= frames_in_controller;
    Outcome outcome = run(options, simulation, bus,
                          {"periodic_set_of_calls, " + std::to_string(frames_in_controller) +
                               " frames in the controller",
                           twelve, by_formula(lengthen, true), all_fit,
                           [&](std::size_t index) { alarms[index].sound(); }});
    outcome.json["frames_in_controller"] = frames_in_controller;
    return outcome;
}

}  // namespace canorb::bench
