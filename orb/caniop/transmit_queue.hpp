#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/frame.hpp"
#include "orb/caniop/identifier.hpp"

namespace canorb::caniop {

struct TransmitLimits {
    /// Messages in the queue, 1 or more; those whose outcome was not yet fetched count.
    std::size_t max_messages = 64;
    /// Octets of all messages in the queue; all memory is reserved at construction.
    std::size_t max_octets = 262144;
    /// Frames handed over to the controller and not yet confirmed, 1 or more: an urgent message
    /// waits for no more than these.
    std::size_t frames_in_controller = 2;
    /// That of the receivers. A message whose next frame is not confirmed within half of it after
    /// the frame before is stopped.
    Duration inter_frame_timeout = std::chrono::milliseconds{100};
    /// The least time from a frame's confirmation to the next frame of the same message, for slow
    /// receivers: 0, or less than half of inter_frame_timeout.
    Duration continuation_gap{0};
};

/// Names one message in one queue; never used twice.
enum class MessageHandle : std::uint64_t {};

enum class MessageOutcome : std::uint8_t {
    sent,     ///< the controller confirmed every frame
    expired,  ///< its deadline passed before it was begun; nothing was sent
    stopped,  ///< its next frame did not get out within half of the inter-frame timeout
    failed,   ///< the controller failed or aborted a frame, or fail_all()
};

/// What became of a message.
struct Finished {
    MessageHandle handle;
    MessageOutcome outcome;
    bool begun;      ///< a frame had gone to the controller: others may have it
    TimePoint time;  ///< `sent`: end of its last frame on the bus's clock; else the `now` given
};

/// The messages that wait to be sent, and the order of their frames (doc/wire/caniop.md,
/// "Sending"). No threads, no clock, and it does not know the controller: the caller carries
/// frames, results and aborts between the two:
///
///     // on_result() for each TransmitResult that the controller has, then
///     queue.expire(now);
///     while (auto handle = queue.next_abort()) controller.abort(*handle);
///     while (auto frame = queue.next_frame(now)) {
///         const can::SendResult result = controller.send(*frame);
///         const auto* handle = std::get_if<can::TransmitHandle>(&result);
///         if (handle == nullptr) break;  // full: again after the next TransmitResult
///         queue.handed_over(*handle);    // (where send() has the result: with its handle, and
///                                        // then on_result())
///     }
///     while (auto finished = queue.next_finished()) { ... }
///
/// Invariants:
///  1. Of the messages that may send, the lowest CAN identifier sends first, and within one
///     identifier the one that was enqueued first. A message's frames are handed over in order, and
///     no frame of another message with its identifier is handed over between them.
///  2. At most `frames_in_controller` frames are handed over without a result.
///  3. A message once begun is never expired or withdrawn.
///  4. Each message that enqueue() took and withdraw() did not remove is reported by
///     next_finished() exactly once; no frame of it is handed over after that.
///
/// It never allocates after construction, and counts nothing: frames_sent, messages_sent,
/// messages_expired, messages_stopped and messages_failed are the caller's to count.
class TransmitQueue {
  public:
    explicit TransmitQueue(const TransmitLimits& limits);

    /// Copies the message, of one octet or more, and queues it. It expires when it is not begun
    /// at `deadline`; `never` for none. Nothing: the queue is full. That a message is not longer
    /// than 65538 octets is for the caller to see.
    [[nodiscard]] std::optional<MessageHandle> enqueue(Identifier identifier, Bytes message,
                                                       TimePoint deadline);

    /// True: it was not begun, and is gone; no outcome will be reported. False: it is begun and
    /// goes on, or the queue has no such message (any more).
    bool withdraw(MessageHandle message);

    /// Whether a frame of it was handed over. False too when the queue has no such message.
    bool begun(MessageHandle message) const;

    /// The next frame for the controller, or nothing: nothing to send, as many frames in the
    /// controller as allowed, or only messages that wait for their continuation gap. Until
    /// handed_over() is called nothing changes: asked again it gives the same frame, or one that
    /// has become more urgent.
    [[nodiscard]] std::optional<can::Frame> next_frame(TimePoint now);

    /// The controller took the frame that next_frame() gave last, under this handle. Nothing but
    /// const functions may be called between the two.
    void handed_over(can::TransmitHandle frame);

    /// What became of a frame handed over. Unknown handles are ignored.
    void on_result(const can::TransmitResult& result, TimePoint now);

    /// Finishes the messages whose deadline has come before they were begun, and stops those
    /// whose next frame is late.
    void expire(TimePoint now);

    /// A frame to abort in the controller, because its message is finished; each is told once.
    [[nodiscard]] std::optional<can::TransmitHandle> next_abort();

    /// The outcomes, in their order, each once.
    [[nodiscard]] std::optional<Finished> next_finished();

    /// When time alone gives expire() or next_frame() something to do; `never`: not at all.
    TimePoint next_deadline() const;

    /// Bus-off, or the link is down: every message fails, begun or not. Frames handed over before
    /// leave the count of those in the controller at once, are given to next_abort(), and their
    /// results are ignored.
    void fail_all(TimePoint now);

    /// Messages that are not finished.
    std::size_t size() const { return messages_.size(); }

  private:
    struct Queued {
        MessageHandle handle;
        Identifier identifier;
        TimePoint deadline;
        std::size_t offset;  ///< of its octets in octets_
        std::size_t length;
        std::size_t frames;           ///< that it takes
        std::size_t handed_over = 0;  ///< of them
        std::size_t confirmed = 0;    ///< of those
        TimePoint last_confirmed{};   ///< when `confirmed` is not 0
        bool in_gap = false;          ///< between last_confirmed and the end of the gap
    };

    /// A frame in the controller.
    struct InController {
        can::TransmitHandle frame;
        std::optional<MessageHandle> message;  ///< nothing: it is finished
        bool abort_told = false;
        bool counts = true;  ///< false: fail_all() has written it off
    };

    using Position = std::vector<Queued>::iterator;

    Position find(MessageHandle message);
    Position finish(Position message, MessageOutcome outcome, TimePoint time);
    Position erase(Position message);
    bool make_room(std::size_t length);
    void end_gaps(TimePoint now);
    bool waits(const Queued& message) const;
    TimePoint gap_end(const Queued& message) const;
    TimePoint stop_time(const Queued& message) const;

    TransmitLimits limits_;
    std::vector<Queued> messages_;  ///< by CAN identifier, then by age
    std::vector<InController> in_controller_;
    std::vector<Finished> finished_;
    std::unique_ptr<std::uint8_t[]> octets_;
    std::size_t octets_end_ = 0;     ///< behind the last octet in use
    std::size_t octets_in_use_ = 0;  ///< there may be gaps
    std::uint64_t last_handle_ = 0;
    std::optional<MessageHandle> offered_;  ///< whose frame next_frame() gave last
};

}  // namespace canorb::caniop
