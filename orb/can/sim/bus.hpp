#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/frame.hpp"
#include "orb/can/sim/bit_observer.hpp"
#include "orb/can/sim/bus_types.hpp"
#include "orb/can/sim/disturbance.hpp"
#include "orb/can/sim/event_queue.hpp"
#include "orb/can/sim/node.hpp"

namespace canorb::can::sim {

/// A CAN bus in its own time: ISO 11898-1's rules, bit by bit, for classic frames.
///
/// Each node is a BitStreamProcessor; the bus is the wired AND of what they drive. A frame that
/// nothing disturbs and somebody acknowledges is simulated in one step, with the same order, time
/// stamps and counters; Fidelity, a BitObserver or a Disturbance make it bits.
///
/// Time: everything happens at now(). Whoever owns the bus moves it with advance() or
/// advance_one(), and does so *before* letting nodes act at a moment:
///
///     sim::Bus bus{500'000};
///     sim::Controller a{bus}, b{bus};
///     a.send(frame);                       // at bus.now()
///     bus.advance(bus.next_event());       // end of EOF: both have their event
///
/// Two nodes that submit at the same now() on an idle bus arbitrate, whoever came first: a frame's
/// SOF is at that moment, but the winner is decided when time moves on.
///
/// Rules besides those of the standard:
/// * The lowest arbitration field of a node's waiting frames goes first (a standard frame before an
///   extended one with the same base identifier, data before remote); equal ones leave in the order
///   of submit(). The choice is made at each SOF.
/// * Time stamps are the end of EOF, for the receivers as well; at that moment the filters decide.
///   Bit times are counted, not added up: no rounding error grows.
/// * What is asked for during a frame in which a node takes part (abort, listen-only, detach) shows
///   at the frame's end.
/// * Bits have no phase on an idle bus: a SOF begins when a frame is submitted.
/// * A node that is attached has been watching the bus before: it takes part as soon as there have
///   been 11 recessive bits.
/// * Bus-off fails all of the node's transmissions.
/// * A mailbox is free again when its TransmitResult has been taken with poll(), so nothing here
///   grows without bound.
///
/// No threads, no clock, no I/O; not safe for use by two threads at once. A NodeIndex that is not
/// attached is a programming error.
class Bus {
  public:
    static constexpr std::uint32_t lowest_bitrate = 5'000;
    static constexpr std::uint32_t highest_bitrate = 1'000'000;

    /// `bitrate` in bit/s, 5 000 to 1 000 000. `start` is now() at first.
    explicit Bus(std::uint32_t bitrate, TimePoint start = TimePoint{});

    std::uint32_t bitrate() const { return bitrate_; }
    TimePoint now() const { return time_; }

    /// A new node, error active, accepting no frame until it has filters. A frame already on the
    /// bus passes it by.
    NodeIndex attach(const NodeOptions& options = {});

    /// The node goes, at the end of the frame that is on the bus; what waits in it is withdrawn.
    void detach(NodeIndex node);

    /// Hands a frame over at now(). `handle` is the caller's name for it, unused until its
    /// TransmitResult. Nothing when accepted.
    [[nodiscard]] std::optional<SendError> submit(NodeIndex node, const Frame& frame,
                                                  TransmitHandle handle, SendOptions options = {});

    /// Reports a transmission as `failed` that submit() refused (not as `full`). For links that
    /// promised a result before they knew. False: no mailbox free.
    [[nodiscard]] bool fail(NodeIndex node, TransmitHandle handle);

    /// As Controller's functions of these names.
    void abort(NodeIndex node, TransmitHandle handle);
    [[nodiscard]] bool set_filters(NodeIndex node, std::span<const Filter> filters);
    void set_listen_only(NodeIndex node, bool on);  ///< on: withdraws what waits
    void recover(NodeIndex node);
    ErrorStatus error_status(NodeIndex node) const;
    Capabilities capabilities(NodeIndex node) const;

    std::optional<ControllerEvent> poll(NodeIndex node);
    const EventQueue& events(NodeIndex node) const { return at(node).events; }
    /// Also of a node that was detached, in traces of its last frame.
    const std::string& name(NodeIndex node) const {
        return nodes_[static_cast<std::size_t>(node)]->options.name;
    }
    NodeStatistics statistics(NodeIndex node) const;
    BusStatistics statistics() const;

    /// No event comes before this moment if nobody does anything until then; `never` when the bus
    /// is quiet. Mostly there is one at it. Of frames that are disturbed it may be the next bit,
    /// with nothing to tell. A frame that is repeated without end because nobody is there to
    /// acknowledge it is quiet, unless bits or errors are watched.
    TimePoint next_event() const;

    /// Completes, in order, everything that ends at or before `to`; now() is `to` then. Going back
    /// does nothing, and neither does `never`.
    void advance(TimePoint to);

    /// Nothing is on the bus, and nobody has anything to send that somebody would acknowledge.
    bool is_quiet() const;

    /// Jumps to next_event() and completes it. False, and no jump, when the bus is_quiet(). This is
    /// the unpaced bus: time moves by frames only.
    bool advance_one();

    /// Called with every frame that was sent and acknowledged, in order, inside advance() and
    /// advance_one(), before anybody can take its events. It must not call the bus.
    void set_trace(std::function<void(const CompletedFrame&)> trace) { trace_ = std::move(trace); }

    /// Called for each error that a node detects; otherwise as set_trace().
    void set_error_trace(std::function<void(const NodeError&)> trace) {
        error_trace_ = std::move(trace);
    }

    /// Called for each overload frame that a node begins; otherwise as set_trace().
    void set_overload_trace(std::function<void(const NodeOverload&)> trace) {
        overload_trace_ = std::move(trace);
    }

    /// From the next frame on, until another one is set; nullptr: none.
    void set_disturbance(Disturbance* disturbance);
    void set_bit_observer(BitObserver* observer);
    void set_fidelity(Fidelity fidelity) { fidelity_ = fidelity; }

  private:
    /// A frame that is, or would be, on the bus, and what can be said of it at its SOF.
    struct Plan {
        const Node::Mailbox* winner = nullptr;
        NodeIndex sender{};  ///< the lowest
        TimePoint start;
        std::uint32_t losers = 0;
        /// Nothing can be observed before the end of this bit, counted from SOF.
        std::uint32_t quiet_bits = 1;
        /// It will be sent and acknowledged, and nothing happens before the end of its EOF.
        bool predictable = false;
        /// It is repeated, for nobody acknowledges it and its sender is error passive already.
        bool fruitless = false;

        /// SOF to the end of the intermission, undisturbed.
        std::uint64_t bits() const {
            return winner->bits.size + frame_tail_bits + intermission_bits;
        }
    };

    /// A frame that is simulated in one step.
    struct Jump {
        CompletedFrame completed;
        StuffedBits bits;
        std::uint32_t arbitration = 0;
        std::uint64_t end_bit = 0;
    };

    Node& at(NodeIndex node);
    const Node& at(NodeIndex node) const;
    bool is_dominant() const;
    void remove(std::size_t index);
    void remove_leaving();
    void rebuild_present();

    // Time: bit n begins at time_of(n).
    TimePoint time_of(std::uint64_t bit) const;
    Duration span(std::uint64_t bits) const;
    std::uint64_t bits_within(Duration duration) const;
    /// The bit that a moment is in.
    std::uint64_t bit_at(TimePoint time) const;

    // Between frames.
    std::uint64_t intermission_left() const;
    void settle_idle(TimePoint to);
    void move_grid_to(TimePoint start);
    TimePoint next_recovery() const;
    TimePoint next_start() const;
    TimePoint next_disturbance() const;
    Plan plan(TimePoint start, bool idle) const;
    bool would_start(const Node& node, TimePoint start, bool idle) const;
    bool step_idle(TimePoint to);
    void begin_frame(TimePoint start, TimePoint to);
    bool ask_disturbance(const Plan& plan);
    void skip_fruitless(const Plan& plan, TimePoint to);

    // A frame in one step.
    static CompletedFrame describe(const Node::Mailbox& mailbox);
    void begin_jump(const Plan& plan);
    void end_jump();

    /// Somebody wants to see each attempt, even one that changes nothing.
    bool is_watched() const { return observer_ != nullptr || error_trace_; }

    // Bits (bus_bits.cpp).
    void enter_bits();
    bool step_bits(TimePoint to);
    void begin_bit();
    void start_nodes(const Plan& plan, bool disturbed);
    void end_bit();
    std::uint8_t end_watched_bit(bool disturbed);
    void look_for_disturbance();
    void handle(std::size_t index, BitStreamProcessor::Events events);
    void complete_frame(std::size_t index);

    std::uint32_t bitrate_;
    TimePoint start_;  ///< of the bus
    TimePoint time_;

    /// The grid of bits, and how many of them are over.
    TimePoint anchor_;
    std::uint64_t bit_ = 0;
    /// So many bits, up to the last one that is over, were recessive.
    std::uint64_t recessive_bits_ = BitStreamProcessor::integration_bits;

    /// All nodes are between frames, the bus is recessive, and bits are skipped.
    bool idle_ = true;
    std::optional<Jump> jump_;

    // While bits are stepped.
    bool bit_begun_ = false;
    bool may_start_ = false;  ///< some node may
    bool busy_ = false;       ///< the bit under way belongs to a frame, whatever its level
    bool fruitless_ = false;  ///< as in Plan, and nobody has done anything since
    bool frame_disturbed_ = false;
    bool in_error_ = false;  ///< an error was detected in this frame
    std::uint64_t disturbed_bit_ = 0;
    std::uint64_t quiet_until_ = 0;  ///< the bit before which nothing can be observed
    /// The sender of the frame that was planned, until it detects an error.
    std::optional<NodeIndex> planned_;
    /// Nodes that lost the arbitration of the frames that began with this bit.
    std::uint64_t lost_start_bit_ = 0;
    std::uint64_t frame_end_bit_ = 0;  ///< of its intermission, if nothing disturbs it
    std::uint32_t losers_ = 0;
    std::uint64_t completed_bit_ = 0;  ///< at whose end a frame was complete last

    std::vector<std::unique_ptr<Node>> nodes_;
    std::vector<std::size_t> present_;  ///< indices of nodes_ that there are
    std::size_t leaving_ = 0;           ///< how many of them are detached
    // For who watches: one element for each of nodes_, and at least one.
    std::vector<std::uint8_t> driven_;
    std::vector<std::uint8_t> wire_;
    std::vector<std::uint8_t> seen_;

    std::function<void(const CompletedFrame&)> trace_;
    std::function<void(const NodeError&)> error_trace_;
    std::function<void(const NodeOverload&)> overload_trace_;
    Disturbance* disturbance_ = nullptr;
    BitObserver* observer_ = nullptr;
    Fidelity fidelity_ = Fidelity::frames;
    BusStatistics statistics_;
};

}  // namespace canorb::can::sim
