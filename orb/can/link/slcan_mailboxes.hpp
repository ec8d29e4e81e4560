#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "orb/can/controller.hpp"
#include "orb/can/sim/event_queue.hpp"

namespace canorb::can {

/// The transmissions of a serial adapter's controller: each from add() until its result, which is
/// put into the event queue once, was taken from there.
class SlcanMailboxes {
  public:
    static constexpr std::size_t count = 8;

    explicit SlcanMailboxes(sim::EventQueue& events);

    bool full() const { return transmissions_.size() >= count; }
    TransmitHandle add(const Frame& frame);

    /// Whether start() has one to begin.
    bool waits() const { return next() != nullptr; }
    /// The frame that would win an arbitration among those that wait, on its way to the adapter
    /// from now until end(). Only where waits().
    const Frame& start();
    /// What became of the one that was started, if it is still of interest. True: the adapter
    /// refused it, and it waits to be started again.
    bool end(bool accepted, TimePoint now);

    /// Ends it now, or, while it is on its way, when the adapter refuses it.
    void withdraw(TransmitHandle handle, TimePoint now);
    void withdraw_all(TimePoint now);
    void fail_all(TimePoint now);

    /// Makes room where `event` is a result.
    void on_taken(const ControllerEvent& event);

  private:
    struct Transmission {
        TransmitHandle handle;
        std::uint32_t arbitration;
        Frame frame;
        bool withdrawn = false;  ///< not to be tried again
        bool over = false;       ///< the result is among the events
    };

    const Transmission* next() const;
    void withdraw(Transmission& transmission, TimePoint now);
    void finish(Transmission& transmission, TransmitOutcome outcome, TimePoint now);

    sim::EventQueue& events_;
    std::vector<Transmission> transmissions_;
    std::optional<TransmitHandle> under_way_;
    std::uint64_t next_handle_ = 1;
};

}  // namespace canorb::can
