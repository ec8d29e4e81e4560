#include "orb/caniop/transmit_queue.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "orb/caniop/segmenter.hpp"

namespace canorb::caniop {

TransmitQueue::TransmitQueue(const TransmitLimits& limits)
    : limits_(limits), octets_(std::make_unique_for_overwrite<std::uint8_t[]>(limits.max_octets)) {
    assert(limits.max_messages > 0 && limits.frames_in_controller > 0);
    assert(limits.continuation_gap == Duration::zero() ||
           limits.continuation_gap < limits.inter_frame_timeout / 2);
    messages_.reserve(limits.max_messages);
    finished_.reserve(limits.max_messages);
    // Twice: fail_all() writes frames off before their aborts are fetched.
    in_controller_.reserve(2 * limits.frames_in_controller);
}

std::optional<MessageHandle> TransmitQueue::enqueue(Identifier identifier, Bytes message,
                                                    TimePoint deadline) {
    assert(!message.empty());
    if (messages_.size() + finished_.size() >= limits_.max_messages) return std::nullopt;
    if (!make_room(message.size())) return std::nullopt;
    std::memcpy(octets_.get() + octets_end_, message.data(), message.size());

    const auto handle = MessageHandle{++last_handle_};
    const auto behind = std::upper_bound(
        messages_.begin(), messages_.end(), identifier.can_id(),
        [](std::uint32_t id, const Queued& queued) { return id < queued.identifier.can_id(); });
    messages_.insert(behind, Queued{.handle = handle,
                                    .identifier = identifier,
                                    .deadline = deadline,
                                    .offset = octets_end_,
                                    .length = message.size(),
                                    .frames = frame_count(message.size())});
    octets_end_ += message.size();
    octets_in_use_ += message.size();
    return handle;
}

bool TransmitQueue::withdraw(MessageHandle message) {
    const auto queued = find(message);
    if (queued == messages_.end() || queued->handed_over > 0) return false;
    erase(queued);
    return true;
}

bool TransmitQueue::begun(MessageHandle message) const {
    return std::any_of(messages_.begin(), messages_.end(), [message](const Queued& queued) {
        return queued.handle == message && queued.handed_over > 0;
    });
}

std::optional<can::Frame> TransmitQueue::next_frame(TimePoint now) {
    offered_.reset();
    end_gaps(now);
    const auto occupied = std::count_if(in_controller_.begin(), in_controller_.end(),
                                        [](const InController& frame) { return frame.counts; });
    if (static_cast<std::size_t>(occupied) >= limits_.frames_in_controller) return std::nullopt;

    std::optional<Identifier> held_back;
    for (const Queued& queued : messages_) {
        if (held_back == queued.identifier || queued.handed_over == queued.frames) continue;
        if (queued.handed_over == 0 && queued.deadline <= now) continue;
        if (waits(queued)) {
            held_back = queued.identifier;
            continue;
        }
        offered_ = queued.handle;
        return cut_frame(queued.identifier, Bytes{octets_.get() + queued.offset, queued.length},
                         queued.handed_over);
    }
    return std::nullopt;
}

void TransmitQueue::handed_over(can::TransmitHandle frame) {
    assert(offered_);
    const auto queued = find(*offered_);
    assert(queued != messages_.end());
    ++queued->handed_over;
    in_controller_.push_back({.frame = frame, .message = queued->handle});
    offered_.reset();
}

void TransmitQueue::on_result(const can::TransmitResult& result, TimePoint now) {
    const auto frame =
        std::find_if(in_controller_.begin(), in_controller_.end(),
                     [&](const InController& other) { return other.frame == result.handle; });
    if (frame == in_controller_.end()) return;
    const std::optional<MessageHandle> message = frame->message;
    in_controller_.erase(frame);
    if (!message) return;

    const auto queued = find(*message);
    if (result.outcome != can::TransmitOutcome::sent) {
        finish(queued, MessageOutcome::failed, now);
        return;
    }
    ++queued->confirmed;
    queued->last_confirmed = now;
    if (queued->confirmed == queued->frames) {
        finish(queued, MessageOutcome::sent, result.time);
    } else {
        queued->in_gap = limits_.continuation_gap > Duration::zero();
    }
}

void TransmitQueue::expire(TimePoint now) {
    end_gaps(now);
    for (auto queued = messages_.begin(); queued != messages_.end();) {
        if (queued->handed_over == 0 && queued->deadline <= now) {
            queued = finish(queued, MessageOutcome::expired, now);
        } else if (stop_time(*queued) <= now) {
            queued = finish(queued, MessageOutcome::stopped, now);
        } else {
            ++queued;
        }
    }
}

std::optional<can::TransmitHandle> TransmitQueue::next_abort() {
    const auto frame =
        std::find_if(in_controller_.begin(), in_controller_.end(),
                     [](const InController& other) { return !other.message && !other.abort_told; });
    if (frame == in_controller_.end()) return std::nullopt;
    const can::TransmitHandle handle = frame->frame;
    frame->abort_told = true;
    if (!frame->counts) in_controller_.erase(frame);
    return handle;
}

std::optional<Finished> TransmitQueue::next_finished() {
    if (finished_.empty()) return std::nullopt;
    const Finished finished = finished_.front();
    finished_.erase(finished_.begin());
    return finished;
}

TimePoint TransmitQueue::next_deadline() const {
    TimePoint next = never;
    for (const Queued& queued : messages_) {
        if (queued.handed_over == 0) {
            next = std::min(next, queued.deadline);
            continue;
        }
        next = std::min(next, stop_time(queued));
        if (queued.in_gap) next = std::min(next, gap_end(queued));
    }
    return next;
}

void TransmitQueue::fail_all(TimePoint now) {
    for (auto queued = messages_.begin(); queued != messages_.end();) {
        queued = finish(queued, MessageOutcome::failed, now);
    }
    for (InController& frame : in_controller_) frame.counts = false;
    std::erase_if(in_controller_, [](const InController& frame) { return frame.abort_told; });
}

TransmitQueue::Position TransmitQueue::find(MessageHandle message) {
    return std::find_if(messages_.begin(), messages_.end(),
                        [message](const Queued& queued) { return queued.handle == message; });
}

TransmitQueue::Position TransmitQueue::finish(Position message, MessageOutcome outcome,
                                              TimePoint time) {
    for (InController& frame : in_controller_) {
        if (frame.message == message->handle) frame.message.reset();
    }
    finished_.push_back({.handle = message->handle,
                         .outcome = outcome,
                         .begun = message->handed_over > 0,
                         .time = time});
    return erase(message);
}

TransmitQueue::Position TransmitQueue::erase(Position message) {
    octets_in_use_ -= message->length;
    if (octets_in_use_ == 0) octets_end_ = 0;
    return messages_.erase(message);
}

// Makes room for so many octets in a row at octets_end_.
bool TransmitQueue::make_room(std::size_t length) {
    if (length > limits_.max_octets - octets_in_use_) return false;
    if (length <= limits_.max_octets - octets_end_) return true;
    std::sort(messages_.begin(), messages_.end(),
              [](const Queued& a, const Queued& b) { return a.offset < b.offset; });
    octets_end_ = 0;
    for (Queued& queued : messages_) {
        std::memmove(octets_.get() + octets_end_, octets_.get() + queued.offset, queued.length);
        queued.offset = octets_end_;
        octets_end_ += queued.length;
    }
    std::sort(messages_.begin(), messages_.end(), [](const Queued& a, const Queued& b) {
        return a.identifier.can_id() != b.identifier.can_id()
                   ? a.identifier.can_id() < b.identifier.can_id()
                   : a.handle < b.handle;
    });
    return true;
}

// Remembered, not computed when asked: next_deadline() must not tell of a gap that is over, or a
// caller whose controller is full would wake for it for ever.
void TransmitQueue::end_gaps(TimePoint now) {
    for (Queued& queued : messages_) {
        if (queued.in_gap && gap_end(queued) <= now) queued.in_gap = false;
    }
}

// With a gap, a frame is handed over only after the one before was confirmed.
bool TransmitQueue::waits(const Queued& message) const {
    if (limits_.continuation_gap == Duration::zero()) return false;
    return message.in_gap || message.confirmed < message.handed_over;
}

TimePoint TransmitQueue::gap_end(const Queued& message) const {
    return message.last_confirmed + limits_.continuation_gap;
}

TimePoint TransmitQueue::stop_time(const Queued& message) const {
    if (message.confirmed == 0) return never;
    return message.last_confirmed + limits_.inter_frame_timeout / 2;
}

}  // namespace canorb::caniop
