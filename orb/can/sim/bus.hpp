#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/frame.hpp"
#include "orb/can/sim/bit_observer.hpp"
#include "orb/can/sim/disturbance.hpp"
#include "orb/can/sim/error_capture.hpp"
#include "orb/can/sim/event_queue.hpp"
#include "orb/can/sim/node_index.hpp"

namespace canorb::can::sim {

/// What a node's controller is like.
struct NodeOptions {
    std::size_t mailboxes = 8;           ///< 1..255
    std::size_t receive_capacity = 512;  ///< received frames held for the reader; more are lost
    /// Exact filters, or 0 for a BasicCAN controller with two mask-and-match registers.
    std::size_t filter_list = 32;
    /// Leaves bus-off by itself, without recover().
    bool automatic_recovery = false;
    std::string name{};  ///< for recordings and fault scripts
};

/// A frame that was sent and acknowledged.
struct CompletedFrame {
    Frame frame;
    TimePoint start;         ///< SOF
    TimePoint time;          ///< end of EOF
    NodeIndex sender;        ///< the lowest one, where several sent the same frame as one
    std::uint32_t bits = 0;  ///< SOF to the end of EOF, with stuff bits
    std::uint32_t stuff_bits = 0;
    std::uint32_t lost_arbitrations = 0;  ///< nodes that began a frame at the same time and lost
};

/// A node detected an error.
struct NodeError {
    TimePoint time;  ///< end of the bit at which it did
    NodeIndex node{};
    ErrorCapture capture;
    ErrorStatus status;    ///< after it was counted
    bool primary = false;  ///< the first of one disturbance; the others follow from its error flag
};

/// What a node has done since it was attached.
struct NodeStatistics {
    std::uint64_t sent = 0;      ///< frames, acknowledged
    std::uint64_t received = 0;  ///< valid frames of others, whatever its filters
    std::uint64_t lost_arbitrations = 0;
    std::uint64_t errors = 0;  ///< detected by it
    /// Where it lost an arbitration last, as an SJA1000 counts: 0..10 identifier bits 28..18 (or
    /// 10..0 of a standard one), 11 SRR or RTR, 12 IDE, 13..30 identifier bits 17..0, 31 RTR of an
    /// extended frame.
    std::optional<std::uint8_t> arbitration_lost_at;
    std::optional<ErrorCapture> last_error;
};

/// How full a bus was since it began. Busy is each bit from SOF to the end of the intermission.
struct BusStatistics {
    std::uint64_t busy_bits = 0;
    std::uint64_t frames = 0;        ///< sent and acknowledged
    std::uint64_t error_frames = 0;  ///< disturbances, however many nodes saw them
};

/// How a bus simulates frames that nothing disturbs. All that can be observed is the same.
enum class Fidelity : std::uint8_t {
    frames,  ///< in one step each; a disturbed one, or with an observer every one, in bits
    bits,    ///< always bit by bit
};

/// A CAN bus that arbitrates frame by frame, in its own time. A frame takes its exact length in
/// bits (stuff bits and intermission included); what happens inside a frame is not simulated.
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
/// Rules:
/// * The lowest arbitration field of the waiting frames wins (a standard frame before an extended
///   one with the same base identifier, data before remote). Within a node equal identifiers leave
///   in the order of submit().
/// * Time stamps are the end of EOF. The bus is free 3 bit times after that. Bit times are counted,
///   not added up: no rounding error grows.
/// * Two nodes with the same arbitration field at the same moment: the same frame is sent as one
///   and both succeed. Different frames differ in DLC or data: those that send the recessive bit
///   there see a bit error. While one of these is error active its error flag destroys the attempt,
///   every sender's TEC grows by 8, every receiver's REC by 1, and all try again; when they are all
///   error passive the dominant frame passes and only their own TEC grows. So a collision costs 16
///   attempts, and repeated ones drive the senders to bus-off (TEC above 255).
/// * Without an acknowledging node (attached since before SOF, not listen-only, not bus-off) an
///   attempt fails and TEC grows by 8, up to 128: error passive, not bus-off. Then the frame waits,
///   without further attempts being simulated, until there is somebody to acknowledge it.
/// * A failed attempt takes the time to the error and an error frame; its flags take 12 bit times,
///   or 6 where there is no second node.
/// * Bus-off fails all of the node's transmissions. recover() takes 128 times 11 bit times,
///   whatever the traffic.
/// * A mailbox is free again when its TransmitResult has been taken with poll(), so nothing here
///   grows without bound.
///
/// No threads, no clock, no I/O; not safe for use by two threads at once. A NodeIndex that is not
/// attached is a programming error.
class Bus {
  public:
    static constexpr std::uint32_t lowest_bitrate = 10'000;
    static constexpr std::uint32_t highest_bitrate = 1'000'000;

    /// `bitrate` in bit/s, 10 000 to 1 000 000. `start` is now() at first.
    explicit Bus(std::uint32_t bitrate, TimePoint start = TimePoint{});

    std::uint32_t bitrate() const { return bitrate_; }
    TimePoint now() const { return time_; }

    /// A new node, error active, accepting no frame until it has filters. A frame already on the
    /// bus passes it by.
    NodeIndex attach(const NodeOptions& options = {});

    /// The node goes. Its frame on the bus, if any, still goes out; its waiting ones do not.
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
    const EventQueue& events(NodeIndex node) const;

    /// When something happens next if nobody submits anything until then: the end of the frame
    /// on the bus or of the one that would win now, or the end of a bus-off recovery; `never` when
    /// the bus is quiet.
    TimePoint next_event() const;

    /// Completes, in order, everything that ends at or before `to`; now() is `to` then. Going back
    /// does nothing.
    void advance(TimePoint to);

    /// Jumps to next_event() and completes it. False, and no jump, when the bus is quiet. This is
    /// the unpaced bus: time moves by frames only.
    bool advance_one();

    /// Called with every frame that was sent and acknowledged, in order, inside advance() and
    /// advance_one(), before anybody can take its events. It must not call the bus.
    void set_trace(std::function<void(const CompletedFrame&)> trace) { trace_ = std::move(trace); }

    /// Called for each error that a node detects; otherwise as set_trace().
    void set_error_trace(std::function<void(const NodeError&)> trace) {
        error_trace_ = std::move(trace);
    }

    /// From the next frame on. It must outlive the bus; nullptr: none.
    void set_disturbance(Disturbance* disturbance);
    void set_bit_observer(BitObserver* observer);
    void set_fidelity(Fidelity fidelity) { fidelity_ = fidelity; }

    const NodeStatistics& statistics(NodeIndex node) const { return at(node).statistics; }
    const BusStatistics& statistics() const { return statistics_; }
    const std::string& name(NodeIndex node) const { return at(node).options.name; }

  private:
    /// What a mailbox's frame does while there is a frame on the bus.
    enum class Part : std::uint8_t {
        waiting,
        sending,
        outvoted,       ///< error passive, and another sender's bit was dominant
        lost_one_shot,  ///< took part in the arbitration, lost it, and is not to be repeated
    };

    struct Mailbox {
        Frame frame;
        TransmitHandle handle{};
        std::uint32_t arbitration = 0;
        std::uint32_t length = 0;  ///< bit times, with intermission
        bool one_shot = false;
        bool abort_requested = false;
        Part part = Part::waiting;
    };

    struct Node {
        Node(const NodeOptions& node_options, std::uint64_t attach_order);

        NodeOptions options;
        std::vector<Mailbox> mailboxes;  ///< in the order of submission; at most one not waiting
        std::vector<Filter> filters;
        EventQueue events;
        std::uint64_t order;  ///< of attach() among all attach() and attempts
        ErrorStatus status;
        TimePoint recovered_at = never;
        bool listen_only = false;
        NodeStatistics statistics;
    };

    enum class Fate : std::uint8_t { sent, unacknowledged, collided };

    /// A frame that is, or would be, on the bus.
    struct Attempt {
        Frame frame;
        std::uint32_t arbitration = 0;
        NodeIndex sender{};  ///< the lowest
        Fate fate = Fate::sent;
        std::uint32_t bits = 0;   ///< from SOF until the bus is free
        TimePoint start;          ///< SOF
        TimePoint end;            ///< of EOF, or of the error delimiter
        std::uint64_t order = 0;  ///< nodes attached after this take no part
    };

    Node& at(NodeIndex node);
    const Node& at(NodeIndex node) const;
    static bool takes_part(const Node& node) {
        return node.status.state != ControllerState::bus_off;
    }
    static const Mailbox* candidate(const Node& node);
    std::size_t free_mailboxes(const Node& node) const;

    TimePoint free_at() const;
    Duration span(std::uint64_t bits) const;
    TimePoint next_recovery() const;
    std::optional<Attempt> next_attempt() const;
    void begin(const Attempt& attempt);
    void complete();
    void settle(Node& node, std::size_t mailbox, Fate fate);
    void receive(Node& node, const Attempt& attempt);
    void recover_nodes();
    void finish(Node& node, std::size_t mailbox, TransmitOutcome outcome);
    void fail_all(Node& node);
    void count_errors(Node& node, int tec, int rec);

    std::uint32_t bitrate_;
    TimePoint time_;
    /// The bus is free from busy_bits_ bit times after busy_since_ on.
    TimePoint busy_since_;
    std::uint64_t busy_bits_ = 0;
    std::uint64_t order_ = 0;
    std::vector<std::optional<Node>> nodes_;
    std::optional<Attempt> on_bus_;
    std::function<void(const CompletedFrame&)> trace_;
    std::function<void(const NodeError&)> error_trace_;
    Fidelity fidelity_ = Fidelity::frames;
    BusStatistics statistics_;
};

}  // namespace canorb::can::sim
