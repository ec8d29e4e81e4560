// The bus between frames: what comes next, and frames that need no bits.

#include <algorithm>
#include <bit>
#include <utility>

#include "orb/can/sim/bus.hpp"

namespace canorb::can::sim {
namespace {

constexpr std::uint32_t bits_after_ack_slot = 1 + 7;  // ACK delimiter, EOF
constexpr std::uint32_t bits_to_ack_slot = 2;         // after the CRC: its delimiter, the slot

/// The place on the wire of a bit that is the `plain`-th, from SOF on, without stuff bits.
std::size_t place_on_wire(const StuffedBits& bits, std::size_t plain) {
    std::size_t place = 0;
    std::uint8_t last = 2;
    for (int run = 0;; ++place) {
        const bool is_stuff = run == 5;
        run = bits.bits[place] == last ? run + 1 : 1;
        last = bits.bits[place];
        if (is_stuff) continue;
        if (plain-- == 0) return place;
    }
}

/// Where the sender of one arbitration field loses against another, as an SJA1000 counts: both
/// begin with the bit after SOF.
std::uint8_t lost_at(std::uint32_t loser, std::uint32_t winner) {
    return static_cast<std::uint8_t>(std::countl_zero(loser ^ winner));
}

}  // namespace

// ---- between frames

/// Of the frame that is over, in bits after the last one that is counted.
std::uint64_t Bus::intermission_left() const {
    int left = 0;
    for (const std::size_t i : present_) {
        left = std::max(left, nodes_[i]->processor.intermission_left());
    }
    return static_cast<std::uint64_t>(left);
}

/// Lets whole bits pass that are recessive for all.
void Bus::settle_idle(TimePoint to) {
    const std::uint64_t over = bit_at(to);
    if (over <= bit_) return;
    const std::uint64_t bits = over - bit_;
    bit_ = over;
    recessive_bits_ += bits;
    statistics_.busy_bits += std::min(bits, intermission_left());
    for (const std::size_t i : present_) {
        Node& node = *nodes_[i];
        if (node.processor.skip_recessive(bits) != 0) node.tell_status(to);
    }
}

/// Bits are counted from `start` on.
void Bus::move_grid_to(TimePoint start) {
    if (time_of(bit_) == start) return;
    anchor_ = start;
    bit_ = 0;
}

TimePoint Bus::next_recovery() const {
    TimePoint earliest = never;
    for (const std::size_t i : present_) {
        const auto bits = nodes_[i]->processor.bits_to_recovery();
        if (bits) earliest = std::min(earliest, time_of(bit_ + *bits));
    }
    return earliest;
}

TimePoint Bus::next_start() const {
    TimePoint earliest = never;
    for (const std::size_t i : present_) {
        if (!nodes_[i]->has_mail()) continue;
        const auto bits = nodes_[i]->processor.bits_to_start();
        if (bits) earliest = std::min(earliest, std::max(time_, time_of(bit_ + *bits)));
    }
    return earliest;
}

TimePoint Bus::next_disturbance() const {
    return disturbance_ == nullptr ? never : disturbance_->next(std::max(time_, time_of(bit_)));
}

bool Bus::would_start(const Node& node, TimePoint start, bool idle) const {
    if (!node.has_mail()) return false;
    if (!idle) return node.processor.may_start();
    const auto bits = node.processor.bits_to_start();
    return bits && time_of(bit_ + *bits) <= start;
}

Bus::Plan Bus::plan(TimePoint start, bool idle) const {
    Plan plan;
    plan.start = start;
    for (const std::size_t i : present_) {
        if (!would_start(*nodes_[i], start, idle)) continue;
        const Node::Mailbox* mailbox = nodes_[i]->candidate();
        if (plan.winner == nullptr || mailbox->arbitration < plan.winner->arbitration) {
            plan.winner = mailbox;
            plan.sender = NodeIndex{static_cast<std::uint16_t>(i)};
        }
    }
    if (plan.winner == nullptr) return plan;

    bool acknowledged = false;
    bool same = true;     // frames with the winner's arbitration field are the winner's
    bool orderly = true;  // everybody else is ready for a frame, with counters that need no care
    bool alone = true;    // only its senders are on the bus, and no attempt changes them
    for (const std::size_t i : present_) {
        const Node& node = *nodes_[i];
        const BitStreamProcessor& processor = node.processor;
        if (processor.status().state == ControllerState::bus_off) {
            alone = alone && !processor.is_recovering();
            continue;
        }
        const auto bits = processor.bits_to_start();
        const bool joins_later =
            idle && processor.is_integrating() && time_of(bit_ + *bits) > start;
        if (joins_later) {
            alone = false;
            continue;
        }
        const auto intermission = static_cast<std::uint64_t>(processor.intermission_left());
        orderly = orderly && processor.is_predictable() && processor.is_between_frames() &&
                  (intermission == 0 || time_of(bit_ + intermission) <= start);
        const Node::Mailbox* mailbox = would_start(node, start, idle) ? node.candidate() : nullptr;
        if (mailbox == nullptr || mailbox->arbitration != plan.winner->arbitration) {
            if (mailbox != nullptr) ++plan.losers;
            acknowledged = acknowledged || !processor.is_listen_only();
            alone = false;
            continue;
        }
        same = same && mailbox->frame == plan.winner->frame;
        alone = alone && !mailbox->one_shot && !mailbox->abort_requested &&
                processor.status().state == ControllerState::error_passive;
    }
    plan.predictable = acknowledged && same && orderly && idle;
    plan.fruitless = alone && same && orderly && idle;
    if (plan.predictable) {
        plan.quiet_bits = static_cast<std::uint32_t>(plan.winner->bits.size) + frame_tail_bits;
    } else if (same && orderly && idle) {
        plan.quiet_bits = static_cast<std::uint32_t>(plan.winner->bits.size) + bits_to_ack_slot;
    }
    return plan;
}

bool Bus::step_idle(TimePoint to) {
    const TimePoint recovery = next_recovery();
    const TimePoint start = next_start();
    TimePoint disturbed = next_disturbance();
    if (disturbed != never) {  // the bit that it is in
        disturbed = time_of(std::max(bit_, bit_at(disturbed)));
    }
    if (recovery <= std::min(start, disturbed)) {
        if (recovery == never || recovery > to) return false;
        settle_idle(recovery);
        time_ = recovery;
        return true;
    }
    if (disturbed < start) {
        if (disturbed >= to) return false;
        settle_idle(disturbed);
        enter_bits();
        return true;
    }
    // At its very start others may still join in.
    if (start >= to) return false;
    begin_frame(start, to);
    return true;
}

void Bus::begin_frame(TimePoint start, TimePoint to) {
    settle_idle(start);
    move_grid_to(start);
    const Plan next = plan(start, true);
    const bool disturbed =
        ask_disturbance(next) ||
        (disturbance_ != nullptr && disturbance_->next(start) < time_of(bit_ + next.bits()));
    if (next.predictable && !disturbed && observer_ == nullptr && fidelity_ == Fidelity::frames) {
        begin_jump(next);
        return;
    }
    if (next.fruitless && disturbance_ == nullptr && !is_watched() &&
        fidelity_ == Fidelity::frames) {
        skip_fruitless(next, to);
    }
    enter_bits();
    start_nodes(next, disturbed);
    fruitless_ = next.fruitless && !disturbed;
    quiet_until_ = disturbed ? 0 : bit_ + next.quiet_bits;
    bit_begun_ = true;
}

/// Once for each attempt to send a frame: whether it wants to see every bit of it.
bool Bus::ask_disturbance(const Plan& plan) {
    if (disturbance_ == nullptr) return false;
    return disturbance_->begin_frame(
        {plan.winner->frame, plan.sender, plan.start, time_of(bit_ + plan.bits())});
}

/// Leaves out whole attempts that begin before `to`, all but the last.
void Bus::skip_fruitless(const Plan& plan, TimePoint to) {
    constexpr std::uint64_t passive_flag_and_delimiter = 6 + 8;
    const std::uint64_t busy =
        plan.winner->bits.size + bits_to_ack_slot + passive_flag_and_delimiter + intermission_bits;
    const std::uint64_t period = busy + BitStreamProcessor::suspend_bits;
    std::uint64_t begun = bit_at(to);
    if (time_of(begun) < to) ++begun;
    const std::uint64_t attempts = (begun - 1 - bit_) / period;
    if (attempts == 0) return;
    for (const std::size_t i : present_) {
        Node& node = *nodes_[i];
        if (!would_start(node, plan.start, true)) continue;
        node.statistics.errors += attempts;
        node.statistics.last_error =
            ErrorCapture{ErrorKind::acknowledgment, {FrameField::ack_slot, 0, false}, true};
    }
    bit_ += attempts * period;
    statistics_.busy_bits += attempts * busy;
    statistics_.error_frames += attempts;
}

// ---- a frame in one step

/// What is the same in each of a frame's transmissions.
CompletedFrame Bus::describe(const Node::Mailbox& mailbox) {
    CompletedFrame completed;
    completed.frame = mailbox.frame;
    completed.bits = static_cast<std::uint32_t>(mailbox.bits.size) + frame_tail_bits;
    // SOF to CRC without data: 34 bits, or 54 of an extended frame.
    const std::size_t plain =
        (mailbox.frame.extended ? 54U : 34U) + 8 * mailbox.frame.payload().size();
    completed.stuff_bits = static_cast<std::uint32_t>(mailbox.bits.size - plain);
    return completed;
}

void Bus::begin_jump(const Plan& plan) {
    const Node::Mailbox& winner = *plan.winner;
    jump_ = Jump{};  // clang 19 finds no emplace() for a nested class with defaults
    Jump& jump = *jump_;
    jump.arbitration = winner.arbitration;
    jump.end_bit = bit_ + winner.bits.size + frame_tail_bits;
    jump.bits = winner.bits;
    jump.completed = describe(winner);
    jump.completed.start = plan.start;
    jump.completed.time = time_of(jump.end_bit);
    jump.completed.sender = plan.sender;
    jump.completed.lost_arbitrations = plan.losers;
    for (const std::size_t i : present_) {
        Node& node = *nodes_[i];
        if (would_start(node, plan.start, true)) node.begin(*node.candidate());
    }
}

void Bus::end_jump() {
    const Jump jump = *std::exchange(jump_, std::nullopt);
    time_ = jump.completed.time;
    statistics_.busy_bits += jump.end_bit - bit_;
    ++statistics_.frames;
    bit_ = jump.end_bit;
    recessive_bits_ = bits_after_ack_slot;
    if (trace_) trace_(jump.completed);
    for (const std::size_t i : present_) {
        Node& node = *nodes_[i];
        if (!node.processor.takes_part()) {
            node.processor.end_undisturbed(false);
            if (const auto from = std::exchange(node.recover_bit, std::nullopt)) {
                const std::uint64_t bits = jump.end_bit - std::min(*from, jump.end_bit);
                node.processor.recovered_for(
                    static_cast<int>(std::min<std::uint64_t>(bits, bits_after_ack_slot)));
            }
            continue;
        }
        const Node::Mailbox* mailbox = node.on_bus();
        const bool sends = mailbox != nullptr && mailbox->arbitration == jump.arbitration;
        if (mailbox != nullptr && !sends) {
            node.lose(lost_at(mailbox->arbitration, jump.arbitration));
        }
        const ControllerState before = node.processor.status().state;
        node.processor.end_undisturbed(sends);
        if (sends) {
            node.end_sent(time_);
        } else {
            node.end_received(jump.completed.frame, time_);
        }
        if (node.processor.status().state != before) node.tell_status(time_);
    }
    if (leaving_ > 0) remove_leaving();
}

// ---- what a frame in one step shows of its bits

ErrorStatus Bus::error_status(NodeIndex index) const {
    const Node& node = at(index);
    ErrorStatus status = node.processor.status();
    if (jump_ && status.rec > 0 && node.processor.takes_part() && !node.processor.is_silent() &&
        time_ >= time_of(jump_->end_bit - bits_after_ack_slot)) {
        const Node::Mailbox* mailbox = node.on_bus();
        const bool sends = mailbox != nullptr && mailbox->arbitration == jump_->arbitration;
        if (!sends) --status.rec;  // rule 8 counts at the ACK slot
    }
    return status;
}

NodeStatistics Bus::statistics(NodeIndex index) const {
    const Node& node = at(index);
    NodeStatistics statistics = node.statistics;
    statistics.overruns = node.events.lost();
    const Node::Mailbox* mailbox = jump_ ? node.on_bus() : nullptr;
    if (mailbox != nullptr && mailbox->arbitration != jump_->arbitration) {
        const std::uint8_t lost = lost_at(mailbox->arbitration, jump_->arbitration);
        const std::uint64_t bit = bit_ + place_on_wire(jump_->bits, lost + 1U);
        if (time_ >= time_of(bit + 1)) {
            ++statistics.lost_arbitrations;
            statistics.arbitration_lost_at = lost;
        }
    }
    return statistics;
}

}  // namespace canorb::can::sim
