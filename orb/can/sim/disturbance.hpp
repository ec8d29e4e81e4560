#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "orb/base/time.hpp"
#include "orb/can/frame.hpp"
#include "orb/can/frame_field.hpp"
#include "orb/can/sim/node_index.hpp"

namespace canorb::can::sim {

/// A frame that is about to begin, as it will be if nothing disturbs it.
struct PlannedFrame {
    const Frame& frame;
    NodeIndex sender{};  ///< the lowest one, where several send the same frame as one
    TimePoint start;     ///< SOF
    TimePoint end;       ///< of the intermission
};

/// A bit that is being simulated.
struct BitMoment {
    TimePoint start;
    TimePoint end;
    /// Where the sender of the planned frame is with it; nothing between frames, and from the first
    /// error that the sender detects.
    std::optional<FramePosition> position;
};

/// What is wrong with a bus: it may change any bit that a node drives or sees. A Bus asks it before
/// each frame, and simulates bit by bit those that it may touch. It must not call the bus.
///
/// Levels: 0 is dominant, 1 recessive. The spans have an element for each NodeIndex up to the
/// highest attached, and may have more: those of nodes that are not there are recessive at first,
/// and what is done to them matters only to the wire.
class Disturbance {
  public:
    virtual ~Disturbance() = default;

    /// It has been given to a bus: what it was told of nodes before is no more true. Those of that
    /// bus follow.
    virtual void bus_entered() {}
    virtual void node_attached(NodeIndex node, std::string_view name) = 0;
    virtual void node_detached(NodeIndex node) = 0;

    /// Called once for each attempt to send a frame. True: it may change something before
    /// `planned.end`, and wants to be asked for each bit.
    virtual bool begin_frame(const PlannedFrame& planned) = 0;

    /// The earliest moment, not before `from`, at which it acts whatever is on the bus; `never`
    /// where it waits for frames only. The bit in which that moment is, and as long as the answer
    /// stays in the present bit every bit after it, is simulated.
    virtual TimePoint next(TimePoint from) const = 0;

    /// Before the bus adds up what the nodes drive: changes what reaches the wire.
    virtual void disturb_driven(const BitMoment& moment, std::span<std::uint8_t> driven) = 0;

    /// After that: changes what each node samples. `driven` is as disturb_driven() left it, `seen`
    /// is the wire's level for everybody at first.
    virtual void disturb_seen(const BitMoment& moment, std::span<const std::uint8_t> driven,
                              std::span<std::uint8_t> seen) = 0;
};

}  // namespace canorb::can::sim
