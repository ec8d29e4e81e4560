#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/base/counters.hpp"
#include "orb/base/time.hpp"
#include "orb/caniop/identifier.hpp"

namespace canorb::caniop {

struct ReassemblerLimits {
    /// The longest message that is kept, in octets, 3..65538. Longer ones are skipped.
    std::size_t max_message = 4096;
    /// Messages under way at once, 1 or more. All memory is reserved at construction:
    /// max_message * max_reassemblies octets.
    std::size_t max_reassemblies = 32;
    /// The longest time between the receive time stamps of two frames of one message.
    Duration inter_frame_timeout = std::chrono::milliseconds{100};
};

/// From a first frame, which has the whole header, to the whole message's length in octets
/// (header included, at most 65538), or nothing when the message is malformed.
using MeasureFunction = std::optional<std::size_t> (*)(Bytes first_frame);

/// What the reassembler must know of the messages that it puts together; nothing else.
struct MessageFormat {
    std::size_t header_octets;  ///< a first frame with fewer is dropped; 1..8
    MeasureFunction measure;
};

/// The frame did not end a message.
struct Nothing {};

/// A whole message.
struct Message {
    Identifier from;
    /// Valid until the next accept(), and for a message of one frame only as long as the payload
    /// that accept() was given: it is not copied.
    Bytes octets;
};

/// A message above `max_message` was received to its end and skipped.
struct Oversize {
    Identifier from;
    Bytes first_frame;  ///< valid as Message::octets
};

/// A first frame that the measure function refuses. Its continuation frames will be dropped.
struct Malformed {
    Identifier from;
    Bytes first_frame;  ///< the payload given
};

using Reception = std::variant<Nothing, Message, Oversize, Malformed>;

/// Puts the frames of CANIOP messages together again (doc/wire/caniop.md, "Reassembly").
/// No threads, no clock. It never allocates after construction.
///
/// Invariants:
///  1. There is at most one open message for each identifier, and at most `max_reassemblies` in
///     all. When one more is opened, the one whose last frame is the oldest gives way.
///  2. An open message has its first frame and continuations 1..k without a gap, each full, with
///     no more than `inter_frame_timeout` between their time stamps. Any frame that breaks this
///     closes it; a repeated frame changes nothing, not even the time.
///  3. A message is handed out once, when it has exactly the octets that its first frame tells.
///  4. Each frame ignored and each message closed early adds one to the counter of its cause (a
///     frame that both closes a message and is itself unusable, to two). What comes of a message
///     after it was closed counts as continuations_without_message.
///
/// Counted here: messages_received, malformed_messages, oversize_messages (at their end) and the
/// "Reassembly" section of Counter, except frames_lost_by_link. The rest is the caller's.
class Reassembler {
  public:
    /// `counters` must outlive it.
    Reassembler(const ReassemblerLimits& limits, const MessageFormat& format, Counters& counters);

    /// One frame that admit() let pass: its payload and receive time stamp.
    ///
    ///  - A continuation is a frame whose first octet has bit 7 set. All others are first frames,
    ///    the empty one included, and close an open message, whatever else is wrong with them.
    ///  - The repeat of a message's last frame, right after it, is a duplicate.
    ///  - A malformed message is reported at once, an oversize one at its end, and only when it
    ///    came there unbroken.
    [[nodiscard]] Reception accept(Identifier from, Bytes payload, TimePoint received);

    /// The link lost frames: no partial message can be trusted any more.
    void drop_all();

    /// Messages under way, those past their inter-frame timeout and not yet dropped included.
    std::size_t open() const;

  private:
    enum class State : std::uint8_t {
        free,
        ended,  ///< a message was whole: kept to know the repeat of its last frame
        open,
        skipping,  ///< open, but oversize: only the first frame is kept
    };

    struct Slot {
        State state = State::free;
        Identifier from;
        std::size_t length = 0;         ///< of the whole message
        std::size_t received = 0;       ///< message octets so far
        std::size_t continuations = 0;  ///< so far
        TimePoint last_frame{};
        std::uint64_t last_used = 0;  ///< orders slots by age even when time stamps are equal
    };

    static bool is_under_way(const Slot& slot);

    Reception accept_first(Slot* slot, Identifier from, Bytes payload, TimePoint received);
    Reception accept_continuation(Slot* slot, Bytes payload, TimePoint received);
    Slot* find(Identifier from);
    Slot& take_slot(TimePoint now);
    void close(Slot& slot, Counter cause);
    std::uint8_t* buffer(const Slot& slot) const;

    ReassemblerLimits limits_;
    MessageFormat format_;
    Counters& counters_;
    std::vector<Slot> slots_;
    std::size_t ever_used_ = 0;  ///< of the slots; all behind are free
    std::size_t buffer_size_;    ///< of each slot
    std::unique_ptr<std::uint8_t[]> buffers_;
    std::uint64_t uses_ = 0;
};

}  // namespace canorb::caniop
