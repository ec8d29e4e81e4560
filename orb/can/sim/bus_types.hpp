#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/frame.hpp"
#include "orb/can/sim/error_capture.hpp"
#include "orb/can/sim/node_index.hpp"

namespace canorb::can::sim {

/// What a node's controller is like.
struct NodeOptions {
    std::size_t mailboxes = 8;           ///< 1..32
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
    ErrorStatus status;        ///< after it was counted
    bool active_flag = false;  ///< it answers with an active error flag
    bool primary = false;  ///< the first of one disturbance; the others follow from its error flag
};

/// A node begins an overload frame.
struct NodeOverload {
    TimePoint time;  ///< end of the bit that should not have been dominant
    NodeIndex node{};
    FramePosition position;  ///< of that bit
};

/// What a node has done since it was attached.
struct NodeStatistics {
    std::uint64_t sent = 0;      ///< frames, acknowledged
    std::uint64_t received = 0;  ///< valid frames of others, whatever its filters
    std::uint64_t lost_arbitrations = 0;
    std::uint64_t errors = 0;     ///< detected by it
    std::uint64_t overloads = 0;  ///< overload frames that it began
    /// Frames that passed its filters and found the receive queue full.
    std::uint64_t overruns = 0;
    /// Where it lost an arbitration last, as an SJA1000 counts: 0..10 identifier bits 28..18 (or
    /// 10..0 of a standard one), 11 SRR or RTR, 12 IDE, 13..30 identifier bits 17..0, 31 RTR of an
    /// extended frame.
    std::optional<std::uint8_t> arbitration_lost_at;
    std::optional<ErrorCapture> last_error;
};

/// How full a bus was since it began. Busy is each bit from SOF to the end of the intermission.
struct BusStatistics {
    std::uint64_t elapsed_bits = 0;  ///< bit times that are over, never less than the busy ones
    std::uint64_t busy_bits = 0;
    std::uint64_t frames = 0;        ///< sent and acknowledged
    std::uint64_t error_frames = 0;  ///< disturbances, however many nodes saw them
};

/// How a bus simulates frames that nothing disturbs. All that can be observed is the same.
enum class Fidelity : std::uint8_t {
    frames,  ///< in one step each; a disturbed one, or with an observer every one, in bits
    bits,    ///< always bit by bit
};

}  // namespace canorb::can::sim
