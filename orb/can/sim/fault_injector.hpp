#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orb/can/sim/disturbance.hpp"
#include "orb/can/sim/fault_script.hpp"

namespace canorb::can::sim {

/// Does to a bus what a fault script says. The same script on the same traffic does the same on
/// every machine.
///
/// Where several faults meet in one bit: a node's transmitter is stuck before it is cut off; a
/// forced level of a later line replaces that of an earlier one; flips come last, and two of them
/// cancel. What happens on the wire does not reach a node that is cut off.
///
/// Not safe for use by two threads at once.
class FaultInjector : public Disturbance {
  public:
    /// Of a bus with that bit rate (in bit/s), which started at `start`.
    FaultInjector(FaultScript script, std::uint32_t bitrate, TimePoint start = TimePoint{});

    const FaultScript& script() const { return script_; }

    /// How often the fault, by its index in script().faults, has begun to do something: random
    /// ones count each bit that was flipped, others each time that they began to act on a node that
    /// is there, or on the wire.
    std::uint64_t acted(std::size_t fault) const { return acted_[fault]; }

    /// The faults that never acted, in the order of the script.
    std::vector<const Fault*> unused() const;

    /// The names in the script that no node had so far, each once.
    std::vector<std::string> absent_names() const;

    void bus_entered() override;
    void node_attached(NodeIndex node, std::string_view name) override;
    void node_detached(NodeIndex node) override;
    bool begin_frame(const PlannedFrame& planned) override;
    TimePoint next(TimePoint from) const override;
    void disturb_driven(const BitMoment& moment, std::span<std::uint8_t> driven) override;
    void disturb_seen(const BitMoment& moment, std::span<const std::uint8_t> driven,
                      std::span<std::uint8_t> seen) override;

  private:
    /// An index in names_; unnamed for a node whose name is not in the script.
    enum class Name : std::size_t { unnamed = SIZE_MAX };

    /// What the effects together do to a node or the wire.
    struct Disturbed {
        bool stuck = false;  ///< the transmitter
        bool cut_off = false;
        std::optional<std::uint8_t> forced{};  ///< level
        bool flipped = false;
    };

    struct Node {
        bool attached = false;
        Name name = Name::unnamed;
        Disturbed disturbed{};
        std::uint8_t sent = 1;  ///< in the present bit, where cut_off
    };

    struct Timer {
        std::size_t fault = 0;
        TimePoint next = never;
    };

    struct FrameTrigger {
        std::size_t fault = 0;
        Name sender = Name::unnamed;  ///< anybody
        std::uint64_t attempts = 0;   ///< that matched
    };

    /// A fault that acts on the present frame when its place comes.
    struct Armed {
        std::size_t fault = 0;
        FramePlace place;
        FramePosition position;    ///< where the place is in a field
        TimePoint middle = never;  ///< of the bit, where the place is counted in bits from SOF
    };

    /// (1 - probability) to the power of 2^k, times 2^64.
    using Powers = std::array<std::uint64_t, 48>;

    /// Draws the bits of one bit error rate at one node, or on the wire.
    struct Lottery {
        std::size_t fault = 0;
        bool wire = false;
        NodeIndex node{};
        Powers powers{};
        TimePoint next = never;
    };

    /// A fault while it acts.
    struct Effect {
        std::size_t fault = 0;
        TimePoint until = never;          ///< acts in bits that begin before
        std::vector<Name> reconnected{};  ///< nodes that its cut_off has left
        bool acts = false;                ///< on a node that is there, or on the wire
        bool counted = false;             ///< in acted_
    };

    Name find(std::string_view name) const;
    bool names(std::size_t fault, Name name) const;
    bool concerns(const Effect& effect, const Node& node) const;
    static void add(FaultKind kind, Disturbed& disturbed);
    void combine_effects();
    void count_effects();
    void end_effects(TimePoint time);

    TimePoint time_of_bit(std::uint64_t bit) const;
    std::uint64_t first_bit_at(TimePoint time) const;
    void draw(Lottery& lottery, TimePoint from);
    void add_lottery(std::size_t fault, bool wire, NodeIndex node);
    void remove_lotteries(NodeIndex node);
    TimePoint timer_after(std::size_t fault, TimePoint time) const;
    void find_next();

    void run_timers(const BitMoment& moment);
    void run_lotteries(const BitMoment& moment);
    void run_armed(const BitMoment& moment);
    void activate(std::size_t fault, const BitMoment& moment);
    void reconnect(std::size_t fault);

    FaultScript script_;
    std::uint32_t bitrate_;
    TimePoint start_;
    TimePoint last_;  ///< the latest moment heard of
    std::mt19937_64 random_;

    std::vector<std::string> names_;  ///< all that are in the script
    std::vector<bool> name_attached_;
    std::vector<std::vector<Name>> target_names_;  ///< of each fault
    std::vector<std::uint64_t> acted_;
    std::vector<Node> nodes_;

    std::vector<Timer> timers_;
    std::vector<Lottery> lotteries_;
    TimePoint next_ = never;  ///< the earliest of timers_ and lotteries_

    std::vector<FrameTrigger> frame_triggers_;
    std::vector<Armed> armed_;
    TimePoint next_armed_ = never;      ///< the earliest of their bits that are counted from SOF
    std::uint32_t stuff_bits_ = 0;      ///< of the present frame, up to the present bit
    std::uint32_t recessive_bits_ = 0;  ///< sent by all nodes, up to the present bit

    std::vector<Effect> effects_;     ///< in the order of the script, at most one for each fault
    Disturbed wire_;                  ///< by effects_, as Node::disturbed
    bool nodes_disturbed_ = false;    ///< any of them, by effects_
    bool wire_flipped_ = false;       ///< by lot, in the present bit
    std::vector<NodeIndex> flipped_;  ///< nodes, the same
};

}  // namespace canorb::can::sim
