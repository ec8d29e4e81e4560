#include "tools/scenario.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <memory>
#include <utility>

#include "orb/can/candump.hpp"
#include "orb/can/frame_length.hpp"
#include "orb/can/sim/controller.hpp"
#include "orb/can/sim/fault_script.hpp"

namespace canorb::tools {
namespace {

using can::Frame;
using can::sim::NodeIndex;

std::string_view without_spaces(std::string_view text) {
    constexpr std::string_view spaces = " \t\r";
    const std::size_t first = text.find_first_not_of(spaces);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(spaces) + 1 - first);
}

}  // namespace

Result<Scenario, std::vector<std::string>> parse_scenario(std::string_view text) {
    Scenario scenario;
    std::vector<std::string> errors;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = without_spaces(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        if (line.empty() || line[0] == '#') continue;
        const auto parsed = can::parse_candump(line);
        if (!parsed) {
            errors.push_back(
                std::to_string(number) + ": " + std::string{can::name(parsed.error())} +
                (parsed.error() == can::CandumpError::time ? ", which has six decimals" : "") +
                "; a line is (SECONDS) NODE FRAME, for example "
                "(0.001000) pump-3 123#DEADBEEF");
        } else if (!is_classic(parsed->frame)) {
            errors.push_back(std::to_string(number) +
                             ": only data and remote frames of classic CAN can be played");
        } else {
            Scenario::Line added{parsed->time, parsed->interface, parsed->frame};
            // In the order of time, and of the file where times are equal.
            const auto after = std::upper_bound(
                scenario.lines.begin(), scenario.lines.end(), added.time,
                [](TimePoint time, const Scenario::Line& each) { return time < each.time; });
            scenario.lines.insert(after, std::move(added));
        }
    }
    if (!errors.empty()) return Failure{std::move(errors)};
    return scenario;
}

std::optional<Duration> parse_duration(std::string_view text) {
    struct Unit {
        std::string_view name;
        double nanoseconds;
    };
    constexpr std::array<Unit, 4> units{{{"ns", 1}, {"us", 1e3}, {"ms", 1e6}, {"s", 1e9}}};
    constexpr double longest = 1e6 * 1e9;
    double amount = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, amount, std::chars_format::fixed);
    if (error != std::errc{}) return std::nullopt;
    const std::string_view unit{stop, static_cast<std::size_t>(end - stop)};
    for (const Unit& known : units) {
        const double nanoseconds = amount * known.nanoseconds;
        if (unit != known.name || !(nanoseconds >= 0 && nanoseconds <= longest)) continue;
        return Duration{static_cast<Duration::rep>(nanoseconds + 0.5)};
    }
    return std::nullopt;
}

namespace {

constexpr std::size_t mailboxes = 32;
constexpr std::array<can::Filter, 2> all_frames{can::Filter{}, can::Filter{.extended = true}};
constexpr Duration patience = std::chrono::seconds{1};

/// As candump writes it.
std::string frame_text(const Frame& frame) {
    const std::string line = can::format_candump(TimePoint{}, "-", frame);
    return line.substr(line.rfind(' ') + 1);
}

/// Which kinds of frame a node may have lost the 12th bit with, where both send recessive.
struct Losers {
    bool standard_remote = false;
    bool extended = false;

    void add(const Frame& frame) {
        extended = extended || frame.extended;
        standard_remote = standard_remote || (frame.remote && !frame.extended);
    }
};

/// The bit of its frame at which a node lost the arbitration, from the number that an SJA1000 has
/// for it.
std::string lost_place(std::uint8_t at, Losers losers) {
    if (at <= 10) return "id." + std::to_string(at + 1);
    if (at == 11 && losers.standard_remote == losers.extended) return "rtr/srr";
    if (at == 11) return losers.extended ? "srr" : "rtr";
    if (at == 12) return "ide";
    if (at <= 30) return "id." + std::to_string(at - 1);
    return "rtr";
}

std::string counters(const can::ErrorStatus& status) {
    return "TEC " + std::to_string(status.tec) + ", REC " + std::to_string(status.rec);
}

/// Invariant: `nodes_` are in the order in which they were attached.
class Player {
  public:
    using Tell = std::function<void(const std::string&)>;

    Player(const Scenario& scenario, const PlayOptions& options, can::sim::Bus& bus,
           const Tell& tell)
        : lines_(scenario.lines), options_(options), bus_(bus), tell_(tell), start_(bus.now()) {
        for (const Scenario::Line& line : lines_) {
            add_node(line.node);
            frame_width_ = std::max(frame_width_, frame_text(line.frame).size());
        }
        for (const std::string& name : options.listeners) add_node(name);
        bus.set_fidelity(can::sim::Fidelity::bits);
        bus.set_trace([this](const can::sim::CompletedFrame& completed) {
            if (options_.trace) options_.trace(completed);
            completed_.push_back(completed);
        });
        bus.set_error_trace([this](const can::sim::NodeError& error) {
            if (options_.error_trace) options_.error_trace(error);
            tell_error(error);
        });
        bus.set_overload_trace([this](const can::sim::NodeOverload& overload) {
            this->tell(
                overload.time, bus_.name(overload.node),
                "overload flag, for a dominant bit at " + can::sim::place_name(overload.position));
        });
    }
    ~Player() {
        bus_.set_trace({});
        bus_.set_error_trace({});
        bus_.set_overload_trace({});
    }
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;

    can::BusReport run() {
        can::BusReporter reporter{bus_};
        const TimePoint end = last_moment();
        std::size_t next = 0;
        while (bus_.now() < end) {
            const TimePoint line = next < lines_.size() ? time_of(lines_[next]) : never;
            const TimePoint something = std::min(line, bus_.next_event());
            if (something == never && !options_.length) break;
            bus_.advance(std::min(something, end));
            tell_events();
            reporter.sample();
            while (next < lines_.size() && time_of(lines_[next]) <= bus_.now()) {
                submit(lines_[next++]);
            }
        }
        std::vector<NodeIndex> indices;
        for (const Node& node : nodes_) {
            indices.push_back(node.controller->node());
            for (const Pending& pending : node.pending) {
                tell(bus_.now(), node.name, pending.frame, "still waits");
            }
        }
        advise_alone();
        return reporter.report(indices);
    }

  private:
    struct Pending {
        can::TransmitHandle handle;
        Frame frame;
    };
    struct Node {
        std::string name;
        std::unique_ptr<can::sim::Controller> controller;
        std::vector<Pending> pending;         ///< sent, without a result so far
        std::uint64_t lost_arbitrations = 0;  ///< that were told
        Losers losers{};                      ///< all that may have lost one since
    };
    template <typename Event>
    struct Told {
        Node* node;
        Event event;
    };
    struct Ended {
        Node* node;
        Frame frame;
        can::TransmitResult result;
    };

    void add_node(const std::string& name) {
        for (const Node& node : nodes_) {
            if (node.name == name) return;
        }
        can::sim::NodeOptions node_options;
        node_options.mailboxes = mailboxes;
        node_options.automatic_recovery = options_.automatic_recovery;
        node_options.name = name;
        auto controller = std::make_unique<can::sim::Controller>(bus_, node_options);
        (void)controller->set_filters(all_frames);
        nodes_.push_back({name, std::move(controller), {}});
        name_width_ = std::max(name_width_, name.size());
    }

    TimePoint time_of(const Scenario::Line& line) const {
        return start_ + line.time.time_since_epoch();
    }

    TimePoint last_moment() const {
        if (options_.length) return start_ + *options_.length;
        return lines_.empty() ? start_ : time_of(lines_.back()) + patience;
    }

    void submit(const Scenario::Line& line) {
        for (Node& node : nodes_) {
            if (node.name != line.node) continue;
            const can::SendResult result = node.controller->send(line.frame);
            if (const auto* handle = std::get_if<can::TransmitHandle>(&result)) {
                node.pending.push_back({*handle, line.frame});
                node.losers.add(line.frame);
            } else {
                const bool full = std::get<can::SendError>(result) == can::SendError::full;
                tell(bus_.now(), node.name, line.frame,
                     full ? "refused, all mailboxes are full" : "refused, bus-off");
            }
        }
    }

    /// What has happened up to now, except errors.
    void tell_events() {
        for (Node& node : nodes_) {
            while (const auto event = node.controller->poll()) {
                if (const auto* received = std::get_if<can::Received>(&*event)) {
                    received_.push_back({&node, *received});
                } else if (const auto* change = std::get_if<can::StateChanged>(&*event)) {
                    changes_.push_back({&node, *change});
                } else if (const auto* result = std::get_if<can::TransmitResult>(&*event)) {
                    ended_.push_back({&node, take_pending(node, result->handle), *result});
                }
            }
        }
        for (const auto& completed : completed_) tell_completed(completed);
        tell_received_in_part();
        for (const auto& [node, change] : changes_) {
            tell(change.time, node->name,
                 "is " + std::string{can::name(change.status.state)} + ", " +
                     counters(change.status));
        }
        for (const Ended& ended : ended_) {
            if (ended.result.outcome == can::TransmitOutcome::sent) continue;
            tell(ended.result.time, ended.node->name, ended.frame, "failed");
        }
        completed_.clear();
        received_.clear();
        changes_.clear();
        ended_.clear();
        for (Node& node : nodes_) forget_losers(node);
    }

    /// Those whose losses, if any, were told.
    void forget_losers(Node& node) const {
        const auto statistics = bus_.statistics(node.controller->node());
        if (statistics.lost_arbitrations != node.lost_arbitrations) return;
        node.losers = {};
        for (const Pending& pending : node.pending) node.losers.add(pending.frame);
    }

    /// A log whose lines all have one name is that of an interface, most often. Who has said when
    /// it ends knows what is to come.
    void advise_alone() const {
        if (!options_.advise || options_.length || nodes_.size() != 1) return;
        if (nodes_.front().pending.empty()) return;
        options_.advise("nobody could acknowledge the frames of " + nodes_.front().name +
                        ": name another node with --nodes");
    }

    static Frame take_pending(Node& node, can::TransmitHandle handle) {
        const auto found =
            std::find_if(node.pending.begin(), node.pending.end(),
                         [&](const Pending& pending) { return pending.handle == handle; });
        const Frame frame = found->frame;
        node.pending.erase(found);
        return frame;
    }

    void tell_completed(const can::sim::CompletedFrame& completed) {
        std::vector<const Node*> senders;
        for (const Ended& ended : ended_) {
            if (ended.result.outcome == can::TransmitOutcome::sent &&
                ended.frame == completed.frame) {
                senders.push_back(ended.node);
            }
        }
        tell(completed.time, names(senders), completed.frame,
             receivers_text(completed.frame, senders) + losers_text());
    }

    /// Frames that only their receivers take for complete.
    void tell_received_in_part() {
        while (!received_.empty()) {
            const can::Received received = received_.front().event;
            std::vector<const Node*> senders;
            for (const Node& node : nodes_) {
                if (std::any_of(
                        node.pending.begin(), node.pending.end(),
                        [&](const Pending& pending) { return pending.frame == received.frame; })) {
                    senders.push_back(&node);
                }
            }
            tell(received.time, names(senders), received.frame,
                 receivers_text(received.frame, senders) + "; not sent as " + names(senders) +
                     " sees it");
        }
    }

    /// Who received a frame, taken out of received_, and who did not.
    std::string receivers_text(const Frame& frame, const std::vector<const Node*>& senders) {
        std::vector<const Node*> with;
        std::vector<const Node*> without;
        for (const Node& node : nodes_) {
            const auto taken = std::erase_if(received_, [&](const Told<can::Received>& told) {
                return told.node == &node && told.event.frame == frame;
            });
            if (taken > 0) {
                with.push_back(&node);
            } else if (std::find(senders.begin(), senders.end(), &node) == senders.end() &&
                       node.controller->error_status().state != can::ControllerState::bus_off) {
                without.push_back(&node);
            }
        }
        std::string text = "received by " + (with.empty() ? "nobody" : names(with));
        if (!with.empty() && !without.empty()) text += ", not by " + names(without);
        return text;
    }

    /// Who lost an arbitration since this was told last.
    std::string losers_text() {
        std::string text;
        for (Node& node : nodes_) {
            const auto statistics = bus_.statistics(node.controller->node());
            if (statistics.lost_arbitrations == node.lost_arbitrations) continue;
            node.lost_arbitrations = statistics.lost_arbitrations;
            text += "; " + node.name + " lost the arbitration at " +
                    lost_place(statistics.arbitration_lost_at.value_or(0), node.losers);
        }
        return text;
    }

    void tell_error(const can::sim::NodeError& error) {
        const bool silent = error.status.state == can::ControllerState::bus_off;
        tell(error.time, bus_.name(error.node),
             std::string{can::sim::name(error.capture.kind)} + " at " +
                 (error.capture.position.stuff ? "the stuff bit after " : "") +
                 can::sim::place_name(error.capture.position) +
                 (error.capture.transmitting ? ", sending" : ", receiving") +
                 (silent              ? ", no flag, "
                  : error.active_flag ? ", active flag, "
                                      : ", passive flag, ") +
                 counters(error.status));
    }

    static std::string names(const std::vector<const Node*>& nodes) {
        std::string text;
        for (const Node* node : nodes) text += (text.empty() ? "" : ", ") + node->name;
        return text;
    }

    void tell(TimePoint time, const std::string& node, const Frame& frame,
              const std::string& text) const {
        tell(time, node, padded(frame_text(frame), frame_width_) + "  " + text);
    }
    void tell(TimePoint time, const std::string& node, const std::string& text) const {
        tell_(seconds(time - start_) + "  " + padded(node, name_width_) + "  " + text);
    }

    static std::string padded(std::string text, std::size_t width) {
        text.resize(std::max(text.size(), width), ' ');
        return text;
    }

    /// A bit takes a microsecond or more.
    static std::string seconds(Duration time) {
        const auto microseconds = time / std::chrono::microseconds{1};
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%3lld.%06lld",
                      static_cast<long long>(microseconds / 1'000'000),
                      static_cast<long long>(microseconds % 1'000'000));
        return text.data();
    }

    const std::vector<Scenario::Line>& lines_;
    const PlayOptions& options_;
    can::sim::Bus& bus_;
    const Tell& tell_;
    TimePoint start_;
    std::vector<Node> nodes_;
    std::size_t name_width_ = 0;
    std::size_t frame_width_ = 0;

    // Of the present step.
    std::vector<can::sim::CompletedFrame> completed_;
    std::vector<Told<can::Received>> received_;
    std::vector<Told<can::StateChanged>> changes_;
    std::vector<Ended> ended_;
};

}  // namespace

can::BusReport play(const Scenario& scenario, const PlayOptions& options, can::sim::Bus& bus,
                    const std::function<void(const std::string&)>& tell) {
    Player player{scenario, options, bus, tell};
    return player.run();
}

}  // namespace canorb::tools
