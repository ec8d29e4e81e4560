// The bus bit by bit.

#include <algorithm>

#include "orb/can/sim/bus.hpp"

namespace canorb::can::sim {

void Bus::enter_bits() {
    idle_ = false;
    bit_begun_ = false;
    may_start_ = true;
    busy_ = std::any_of(present_.begin(), present_.end(),
                        [this](std::size_t i) { return nodes_[i]->processor.is_busy(); });
    fruitless_ = false;
    frame_disturbed_ = false;
    in_error_ = false;
    quiet_until_ = 0;
    completed_bit_ = 0;
    losers_ = 0;
    planned_.reset();
    look_for_disturbance();
}

/// False: nothing more before `to`.
bool Bus::step_bits(TimePoint to) {
    const std::uint64_t over = bit_at(to);
    while (!idle_) {
        if (bit_ >= over) {
            if (!bit_begun_ && time_of(bit_) < to) begin_bit();
            return false;
        }
        if (!bit_begun_) begin_bit();
        end_bit();
    }
    return true;
}

void Bus::begin_bit() {
    bit_begun_ = true;
    if (!may_start_) return;
    may_start_ = false;
    const Plan next = plan(time_of(bit_), false);
    if (next.winner == nullptr) return;
    const bool disturbed = ask_disturbance(next);
    look_for_disturbance();
    start_nodes(next, disturbed);
}

void Bus::start_nodes(const Plan& plan, bool disturbed) {
    bool others_are_through = true;  // with the frame before, and its errors
    for (const std::size_t i : present_) {
        Node& node = *nodes_[i];
        const BitStreamProcessor& processor = node.processor;
        if (!processor.may_start()) {
            others_are_through = others_are_through && processor.is_between_frames();
            continue;
        }
        const bool joins = !processor.is_between_frames();
        if (!node.has_mail()) continue;
        const Node::Mailbox& mailbox = *node.candidate();
        node.begin(mailbox);
        node.start_bit = joins ? bit_ - 1 : bit_;
        node.processor.start(mailbox.bits, mailbox.frame.extended);
    }
    if (others_are_through) in_error_ = false;
    planned_ = plan.sender;
    frame_disturbed_ = disturbed;
    frame_end_bit_ = bit_ + plan.bits();
    may_start_ = false;
}

void Bus::look_for_disturbance() {
    if (disturbance_ == nullptr) return;
    const TimePoint next = disturbance_->next(time_of(bit_));
    disturbed_bit_ = next == never ? ~std::uint64_t{0} : bit_at(next);
}

void Bus::end_bit() {
    bit_begun_ = false;
    const bool disturbed = disturbance_ != nullptr && (frame_disturbed_ || bit_ >= disturbed_bit_);
    const bool watched = disturbed || observer_ != nullptr;
    std::uint8_t level = 1;
    if (watched) {
        level = end_watched_bit(disturbed);
    } else {
        for (const std::size_t i : present_) level &= nodes_[i]->processor.driven();
    }
    BitStreamProcessor::Activity activity;
    bool joinable = false;
    if (busy_ || level == 0) ++statistics_.busy_bits;
    for (const std::size_t i : present_) {
        Node& node = *nodes_[i];
        const auto events = node.processor.step(watched ? seen_[i] : level);
        if (events != 0) {
            handle(i, events);
            joinable = joinable || (events & BitStreamProcessor::joinable) != 0;
        }
        activity.add(node.processor);
    }
    ++bit_;
    recessive_bits_ = level != 0 ? recessive_bits_ + 1 : 0;
    busy_ = activity.any_busy();
    may_start_ = joinable || activity.any_idle();
    if (disturbed) look_for_disturbance();
    if (leaving_ > 0) remove_leaving();
    const bool quiet = level != 0 && activity.all_between_frames();
    if (!quiet || (frame_disturbed_ && bit_ < frame_end_bit_)) return;
    in_error_ = false;
    planned_.reset();
    frame_disturbed_ = false;
    idle_ = disturbance_ == nullptr || bit_ < disturbed_bit_;
}

/// Fills wire_ and seen_; returns the level of the bus.
std::uint8_t Bus::end_watched_bit(bool disturbed) {
    for (const std::size_t i : present_) driven_[i] = nodes_[i]->processor.driven();
    wire_ = driven_;
    BitMoment moment;
    moment.start = time_of(bit_);
    moment.end = time_of(bit_ + 1);
    if (disturbed) {
        if (planned_) {
            moment.position = nodes_[static_cast<std::size_t>(*planned_)]->processor.position();
        }
        disturbance_->disturb_driven(moment, wire_);
    }
    std::uint8_t level = 1;  // also of a bus without nodes
    for (const std::uint8_t driven : wire_) level &= driven;
    seen_.assign(wire_.size(), level);
    if (disturbed) disturbance_->disturb_seen(moment, wire_, seen_);
    if (observer_ != nullptr) {
        observer_->bit(BusBit{moment.start, moment.end, level, driven_, seen_});
    }
    return level;
}

void Bus::handle(std::size_t index, BitStreamProcessor::Events events) {
    Node& node = *nodes_[index];
    time_ = time_of(bit_ + 1);
    if ((events & BitStreamProcessor::lost_arbitration) != 0) {
        node.lose(node.processor.lost_at());
        if (lost_start_bit_ != node.start_bit) losers_ = 0;
        lost_start_bit_ = node.start_bit;
        ++losers_;
    }
    if ((events & BitStreamProcessor::detected_error) != 0) {
        NodeError error;
        error.time = time_;
        error.node = NodeIndex{static_cast<std::uint16_t>(index)};
        error.capture = node.processor.error();
        error.status = node.processor.status();
        error.active_flag = node.processor.driven() == 0;
        error.primary = !in_error_;
        ++node.statistics.errors;
        node.statistics.last_error = error.capture;
        if (error.primary) ++statistics_.error_frames;
        in_error_ = true;
        if (planned_ == error.node) planned_.reset();
        if (error_trace_) error_trace_(error);
        node.end_failed(time_);
        // Its flag is recessive: where it alone could not read the frame, nobody repeats it. Nodes
        // that only listen are not told: they would have an event for each repetition of a frame
        // that they do not acknowledge.
        const bool is_passive = !error.active_flag && !node.processor.is_silent();
        if (is_passive && !error.capture.transmitting) node.events.push_doubt(time_);
    }
    if ((events & BitStreamProcessor::sent) != 0) {
        if (completed_bit_ != bit_ + 1) complete_frame(index);  // else it is the same frame
        node.end_sent(time_);
    }
    if ((events & BitStreamProcessor::received) != 0) {
        node.end_received(node.processor.frame(), time_);
    }
    if ((events & BitStreamProcessor::overload) != 0) {
        ++node.statistics.overloads;
        if (overload_trace_) {
            overload_trace_({time_, NodeIndex{static_cast<std::uint16_t>(index)},
                             node.processor.overload_position()});
        }
    }
    if ((events & BitStreamProcessor::status_changed) != 0) node.tell_status(time_);
}

void Bus::complete_frame(std::size_t index) {
    completed_bit_ = bit_ + 1;
    ++statistics_.frames;
    if (!trace_) return;
    const Node& node = *nodes_[index];
    CompletedFrame completed = describe(*node.on_bus());
    completed.start = time_of(node.start_bit);
    completed.time = time_;
    completed.sender = NodeIndex{static_cast<std::uint16_t>(index)};
    completed.lost_arbitrations = lost_start_bit_ == node.start_bit ? losers_ : 0;
    trace_(completed);
}

}  // namespace canorb::can::sim
