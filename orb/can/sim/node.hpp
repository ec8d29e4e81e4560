#pragma once

#include <optional>
#include <span>
#include <vector>

#include "orb/can/controller.hpp"
#include "orb/can/frame_length.hpp"
#include "orb/can/sim/bit_stream_processor.hpp"
#include "orb/can/sim/bus_types.hpp"
#include "orb/can/sim/event_queue.hpp"

namespace canorb::can::sim {

/// One controller of a Bus: what its user has put into it and not taken out yet, and the
/// BitStreamProcessor that faces the bus.
///
/// Invariants: at most one mailbox is not waiting, and only from a SOF to the end of that frame or
/// the first error in it. Mailboxes are in the order of submission.
class Node {
  public:
    /// What a mailbox's frame does while there is a frame on the bus.
    enum class Part : std::uint8_t {
        waiting,
        sending,
        lost,  ///< began with the others and lost the arbitration
    };

    struct Mailbox {
        Frame frame;
        StuffedBits bits;
        std::uint32_t arbitration = 0;
        TransmitHandle handle{};
        bool one_shot = false;
        bool abort_requested = false;
        Part part = Part::waiting;
    };

    /// `recessive_bits`: for how long the bus has been recessive.
    Node(const NodeOptions& node_options, std::uint64_t recessive_bits);

    // As Bus's functions of these names; `now` is the bus's.
    [[nodiscard]] std::optional<SendError> submit(const Frame& frame, TransmitHandle handle,
                                                  SendOptions options);
    [[nodiscard]] bool fail(TransmitHandle handle, TimePoint now);
    void abort(TransmitHandle handle, TimePoint now);
    [[nodiscard]] bool set_filters(std::span<const Filter> filters);
    void set_listen_only(bool on, bool dominant, TimePoint now);

    /// The node has been detached: withdraws what waits and tells nobody.
    void leave();

    /// The frame with which it would take part in an arbitration, while all wait.
    const Mailbox* candidate() const;
    bool has_mail() const { return !mailboxes_.empty(); }

    /// Its candidate is on the bus.
    void begin(const Mailbox& chosen);
    void lose(std::uint8_t at);
    void end_sent(TimePoint now);
    void end_received(const Frame& frame, TimePoint now);
    void end_failed(TimePoint now);
    void tell_status(TimePoint now);

    /// The mailbox that is not waiting, if any.
    const Mailbox* on_bus() const;

    BitStreamProcessor processor;
    NodeOptions options;
    EventQueue events;
    NodeStatistics statistics;
    bool leaving = false;  ///< detached, and still in a frame
    /// When its frame on the bus began: the bit of its SOF.
    std::uint64_t start_bit = 0;
    /// recover() came during a frame that is simulated in one step: after so many of its bits.
    std::optional<std::uint64_t> recover_bit;

  private:
    std::size_t free_mailboxes() const;
    void finish(std::size_t mailbox, TransmitOutcome outcome, TimePoint now);
    /// The frame is over, and a mailbox that took part in it goes on waiting, or does not.
    void settle(TimePoint now);
    std::optional<std::size_t> find_on_bus() const;

    std::vector<Mailbox> mailboxes_;
    std::vector<Filter> filters_;
};

}  // namespace canorb::can::sim
