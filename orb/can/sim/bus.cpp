#include "orb/can/sim/bus.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace canorb::can::sim {
namespace {

constexpr std::uint64_t nanoseconds = 1'000'000'000;

}  // namespace

Bus::Bus(std::uint32_t bitrate, TimePoint start)
    : bitrate_(bitrate), start_(start), time_(start), anchor_(start) {
    assert(bitrate >= lowest_bitrate && bitrate <= highest_bitrate);
    rebuild_present();
}

// ---- nodes

NodeIndex Bus::attach(const NodeOptions& options) {
    assert(options.mailboxes >= 1 && options.mailboxes <= 32);
    fruitless_ = false;
    if (idle_ && !jump_) settle_idle(time_);
    // A bit of which it saw the beginning only does not make it take part.
    const bool dominant = is_dominant();
    auto free = std::find(nodes_.begin(), nodes_.end(), nullptr);
    if (free == nodes_.end()) free = nodes_.insert(nodes_.end(), nullptr);
    *free = std::make_unique<Node>(options, dominant ? 0 : recessive_bits_);
    rebuild_present();
    const NodeIndex index{static_cast<std::uint16_t>(free - nodes_.begin())};
    if (disturbance_ != nullptr) disturbance_->node_attached(index, options.name);
    if (observer_ != nullptr) observer_->node_attached(index, options.name);
    return index;
}

void Bus::detach(NodeIndex index) {
    Node& node = at(index);
    fruitless_ = false;
    const bool in_frame =
        !node.processor.is_between_frames() || (is_dominant() && node.processor.takes_part());
    if (in_frame) {
        node.leave();
        ++leaving_;
    } else {
        remove(static_cast<std::size_t>(index));
    }
}

/// Somebody is sending a dominant bit, or has begun a frame that is simulated in one step.
bool Bus::is_dominant() const {
    if (jump_) return true;
    return bit_begun_ && std::any_of(present_.begin(), present_.end(), [this](std::size_t i) {
               return nodes_[i]->processor.driven() == 0;
           });
}

void Bus::remove(std::size_t index) {
    nodes_[index] = nullptr;
    while (!nodes_.empty() && !nodes_.back()) nodes_.pop_back();
    rebuild_present();
    const NodeIndex node{static_cast<std::uint16_t>(index)};
    if (planned_ == node) planned_.reset();
    if (disturbance_ != nullptr) disturbance_->node_detached(node);
    if (observer_ != nullptr) observer_->node_detached(node);
}

void Bus::remove_leaving() {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (!nodes_[i] || !nodes_[i]->leaving || !nodes_[i]->processor.is_between_frames())
            continue;
        remove(i);
        --leaving_;
    }
}

void Bus::rebuild_present() {
    present_.clear();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (nodes_[i]) present_.push_back(i);
    }
    const std::size_t size = std::max<std::size_t>(nodes_.size(), 1);
    driven_.assign(size, 1);
    wire_.assign(size, 1);
    seen_.assign(size, 1);
}

Node& Bus::at(NodeIndex node) {
    const auto index = static_cast<std::size_t>(node);
    assert(index < nodes_.size() && nodes_[index] && !nodes_[index]->leaving);
    return *nodes_[index];
}

const Node& Bus::at(NodeIndex node) const {
    const auto index = static_cast<std::size_t>(node);
    assert(index < nodes_.size() && nodes_[index] && !nodes_[index]->leaving);
    return *nodes_[index];
}

std::optional<SendError> Bus::submit(NodeIndex node, const Frame& frame, TransmitHandle handle,
                                     SendOptions options) {
    fruitless_ = false;
    return at(node).submit(frame, handle, options);
}

bool Bus::fail(NodeIndex node, TransmitHandle handle) {
    return at(node).fail(handle, time_);
}

void Bus::abort(NodeIndex node, TransmitHandle handle) {
    fruitless_ = false;
    at(node).abort(handle, time_);
}

bool Bus::set_filters(NodeIndex node, std::span<const Filter> filters) {
    return at(node).set_filters(filters);
}

void Bus::set_listen_only(NodeIndex node, bool on) {
    fruitless_ = false;
    at(node).set_listen_only(on, is_dominant(), time_);
}

void Bus::recover(NodeIndex index) {
    Node& node = at(index);
    fruitless_ = false;
    if (jump_) {
        if (node.processor.status().state == ControllerState::bus_off &&
            !node.processor.is_recovering()) {
            node.processor.recover(false);
            node.recover_bit = bits_within(time_ - anchor_);
            if (time_of(*node.recover_bit) < time_) ++*node.recover_bit;
        }
        return;
    }
    if (idle_) {
        settle_idle(time_);
        // Without anybody who counts bits they have no phase.
        const bool counted = std::any_of(present_.begin(), present_.end(), [this](std::size_t i) {
            const BitStreamProcessor& processor = nodes_[i]->processor;
            return processor.bits_to_start().value_or(0) > 0 || processor.is_recovering();
        });
        if (!counted) move_grid_to(time_);
        node.processor.recover(time_of(bit_) < time_);
    } else {
        node.processor.recover(bit_begun_);
    }
}

Capabilities Bus::capabilities(NodeIndex index) const {
    const Node& node = at(index);
    Capabilities capabilities;
    capabilities.max_payload = Frame::max_classic_payload;
    capabilities.mailboxes = node.options.mailboxes;
    capabilities.filter_list = node.options.filter_list;
    capabilities.bitrate = bitrate_;
    capabilities.one_shot = true;
    capabilities.listen_only = true;
    return capabilities;
}

std::optional<ControllerEvent> Bus::poll(NodeIndex node) {
    return at(node).events.pop();
}

BusStatistics Bus::statistics() const {
    BusStatistics statistics = statistics_;
    if (jump_) {
        const std::uint64_t over = std::min(bits_within(time_ - anchor_), jump_->end_bit);
        statistics.busy_bits += over - bit_;
    } else if (idle_) {
        const std::uint64_t over = bits_within(time_ - anchor_);
        statistics.busy_bits += std::min(over - std::min(over, bit_), intermission_left());
    }
    // Frames that begin off the grid of the bits before them cost a fraction of a nanosecond each.
    statistics.elapsed_bits = std::max(bits_within(time_ - start_), statistics.busy_bits);
    return statistics;
}

void Bus::set_disturbance(Disturbance* disturbance) {
    disturbance_ = disturbance;
    if (disturbance == nullptr) return;
    disturbance->bus_entered();
    for (const std::size_t i : present_) {
        disturbance->node_attached(NodeIndex{static_cast<std::uint16_t>(i)},
                                   nodes_[i]->options.name);
    }
    if (!idle_) look_for_disturbance();
}

void Bus::set_bit_observer(BitObserver* observer) {
    observer_ = observer;
    if (observer == nullptr) return;
    for (const std::size_t i : present_) {
        observer->node_attached(NodeIndex{static_cast<std::uint16_t>(i)}, nodes_[i]->options.name);
    }
}

// ---- time

Duration Bus::span(std::uint64_t bits) const {
    // In two parts, so that no product is too large.
    const std::uint64_t seconds = bits / bitrate_;
    return Duration{static_cast<Duration::rep>(seconds * nanoseconds +
                                               bits % bitrate_ * nanoseconds / bitrate_)};
}

TimePoint Bus::time_of(std::uint64_t bit) const {
    return anchor_ + span(bit);
}

/// The most bits that span() makes no longer than `duration`.
std::uint64_t Bus::bits_within(Duration duration) const {
    if (duration < Duration::zero()) return 0;
    const auto count = static_cast<std::uint64_t>(duration.count());
    return count / nanoseconds * bitrate_ +
           ((count % nanoseconds + 1) * bitrate_ - 1) / nanoseconds;
}

std::uint64_t Bus::bit_at(TimePoint time) const {
    return bits_within(time - anchor_);
}

// ---- moving on

TimePoint Bus::next_event() const {
    if (jump_) return jump_->completed.time;
    if (!idle_) {
        if (fruitless_ && !is_watched()) return never;
        return time_of(std::max(quiet_until_, bit_ + 1));
    }
    TimePoint event = next_recovery();
    if (const TimePoint disturbed = next_disturbance(); disturbed != never) {
        event = std::min(event, time_of(std::max(bit_, bit_at(disturbed)) + 1));
    }
    const TimePoint start = next_start();
    if (start == never || start >= event) return event;
    const Plan next = plan(start, true);
    if (next.fruitless && disturbance_ == nullptr && !is_watched()) return event;
    const std::uint64_t bits = disturbance_ != nullptr ? 1 : next.quiet_bits;
    const std::uint64_t bit = bit_at(start);
    return std::min(event, time_of(bit) == start ? time_of(bit + bits) : start + span(bits));
}

void Bus::advance(TimePoint to) {
    if (to < time_ || to == never) return;
    while (true) {
        if (jump_) {
            if (jump_->completed.time > to) break;
            end_jump();
        } else if (!(idle_ ? step_idle(to) : step_bits(to))) {
            break;
        }
    }
    time_ = to;
}

bool Bus::is_quiet() const {
    if (jump_) return false;
    if (!idle_) return fruitless_;
    if (next_recovery() != never) return false;
    const TimePoint start = next_start();
    return start == never || (disturbance_ == nullptr && plan(start, true).fruitless);
}

bool Bus::advance_one() {
    if (is_quiet()) return false;
    const TimePoint event = next_event();
    // Nothing ends before `event`, and whatever else ends at that moment is complete as well.
    advance(event);
    return true;
}

}  // namespace canorb::can::sim
