#include "orb/can/sim/fault_injector.hpp"

#include <algorithm>
#include <utility>

namespace canorb::can::sim {
namespace {

constexpr std::uint64_t second = 1'000'000'000;  // in nanoseconds
constexpr std::uint64_t latest_second = 4'000'000'000;

/// More recessive bits than any node sends between two dominant ones while a frame, an error frame
/// or what follows them is not over for all.
constexpr std::uint32_t quiet_bits = 32;

/// The upper half of a product. By hand: the same on machines without 128-bit integers.
std::uint64_t multiply_high(std::uint64_t a, std::uint64_t b) {
    const std::uint64_t a_low = a & 0xFFFFFFFFU, a_high = a >> 32;
    const std::uint64_t b_low = b & 0xFFFFFFFFU, b_high = b >> 32;
    const std::uint64_t middle = a_high * b_low + ((a_low * b_low) >> 32);
    const std::uint64_t other = a_low * b_high + (middle & 0xFFFFFFFFU);
    return a_high * b_high + (middle >> 32) + (other >> 32);
}

bool matches(const InFrame& trigger, const Frame& frame) {
    return !trigger.id || (*trigger.id == frame.id && trigger.extended == frame.extended);
}

/// Where a place is in a frame; nothing where the frame has none such, or the place is not in a
/// field.
std::optional<FramePosition> position_of(const FramePlace& place, const Frame& frame) {
    using Field = FramePlace::Field;
    const auto at = [&](FrameField field, unsigned before = 0) {
        return FramePosition{field, static_cast<std::uint8_t>(place.number - 1 - before), false};
    };
    switch (place.field) {
        case Field::start_of_frame:
            return at(FrameField::start_of_frame);
        case Field::identifier:
            if (place.number <= 11) return at(FrameField::identifier);
            if (!frame.extended) return std::nullopt;
            return at(FrameField::extended_identifier, 11);
        case Field::substitute_remote_request:
            if (!frame.extended) return std::nullopt;
            return at(FrameField::remote_request);
        case Field::remote_request:
            return at(frame.extended ? FrameField::extended_remote_request
                                     : FrameField::remote_request);
        case Field::identifier_extension:
            return at(FrameField::identifier_extension);
        case Field::reserved_1:
            if (!frame.extended) return std::nullopt;
            return at(FrameField::reserved_1);
        case Field::reserved_0:
            return at(FrameField::reserved_0);
        case Field::data_length_code:
            return at(FrameField::data_length_code);
        case Field::data:
            if (place.number > 8 * frame.payload().size()) return std::nullopt;
            return at(FrameField::data);
        case Field::crc:
            return at(FrameField::crc);
        case Field::crc_delimiter:
            return at(FrameField::crc_delimiter);
        case Field::ack_slot:
            return at(FrameField::ack_slot);
        case Field::ack_delimiter:
            return at(FrameField::ack_delimiter);
        case Field::end_of_frame:
            return at(FrameField::end_of_frame);
        case Field::intermission:
            return at(FrameField::intermission);
        case Field::stuff_bit:
        case Field::any_bit:
            return std::nullopt;
    }
    return std::nullopt;
}

template <typename T>
bool contains(const std::vector<T>& elements, T element) {
    return std::find(elements.begin(), elements.end(), element) != elements.end();
}

/// Of the bit with that number, counted from 1, since the start of the first. Bits begin at whole
/// nanoseconds, rounded: their middles are the moments that are surely theirs.
Duration middle_of_bit(std::uint64_t number, std::uint32_t bitrate) {
    const std::uint64_t half_bits = 2 * number - 1;
    return Duration{static_cast<Duration::rep>(half_bits * second / 2 / bitrate)};
}

bool is_any_dominant(std::span<const std::uint8_t> levels) {
    return std::find(levels.begin(), levels.end(), 0) != levels.end();
}

std::size_t index_of(NodeIndex node) {
    return static_cast<std::size_t>(node);
}

}  // namespace

FaultInjector::FaultInjector(FaultScript script, std::uint32_t bitrate, TimePoint start)
    : script_(std::move(script)),
      bitrate_(bitrate),
      start_(start),
      last_(start),
      random_(script_.seed),
      acted_(script_.faults.size()) {
    const auto intern = [&](const std::string& name) {
        if (find(name) == Name::unnamed) names_.push_back(name);
        return find(name);
    };
    for (std::size_t i = 0; i < script_.faults.size(); ++i) {
        const Fault& fault = script_.faults[i];
        std::vector<Name> targets;
        for (const std::string& name : fault.targets.names) targets.push_back(intern(name));
        target_names_.push_back(std::move(targets));
        if (const auto* at = std::get_if<AtTime>(&fault.trigger)) {
            timers_.push_back({i, start_ + at->first.at(bitrate_)});
        } else if (const auto* in_frame = std::get_if<InFrame>(&fault.trigger)) {
            const Name sender = in_frame->sender ? intern(*in_frame->sender) : Name::unnamed;
            frame_triggers_.push_back({i, sender, 0});
        } else if (fault.targets.scope == FaultTargets::Scope::wire) {
            add_lottery(i, true, NodeIndex{});
        }
    }
    name_attached_.resize(names_.size());
    find_next();
}

std::vector<const Fault*> FaultInjector::unused() const {
    std::vector<const Fault*> result;
    for (std::size_t i = 0; i < acted_.size(); ++i) {
        if (acted_[i] == 0) result.push_back(&script_.faults[i]);
    }
    return result;
}

std::vector<std::string> FaultInjector::absent_names() const {
    std::vector<std::string> result;
    for (std::size_t i = 0; i < names_.size(); ++i) {
        if (!name_attached_[i]) result.push_back(names_[i]);
    }
    return result;
}

void FaultInjector::bus_entered() {
    nodes_.clear();
    std::erase_if(lotteries_, [](const Lottery& lottery) { return !lottery.wire; });
    find_next();
    combine_effects();
}

void FaultInjector::node_attached(NodeIndex node, std::string_view name) {
    if (nodes_.size() <= index_of(node)) nodes_.resize(index_of(node) + 1);
    remove_lotteries(node);  // it may be told twice, by a bus that was left and taken again
    nodes_[index_of(node)] = Node{true, find(name), {}, 1};
    const Name found = nodes_[index_of(node)].name;
    if (found != Name::unnamed) name_attached_[static_cast<std::size_t>(found)] = true;
    for (std::size_t i = 0; i < script_.faults.size(); ++i) {
        const Fault& fault = script_.faults[i];
        if (!std::holds_alternative<AtRandom>(fault.trigger)) continue;
        if (names(i, found)) add_lottery(i, false, node);
    }
    find_next();
    combine_effects();
}

void FaultInjector::node_detached(NodeIndex node) {
    if (index_of(node) >= nodes_.size()) return;
    nodes_[index_of(node)] = Node{};
    remove_lotteries(node);
    find_next();
    combine_effects();
}

void FaultInjector::remove_lotteries(NodeIndex node) {
    std::erase_if(lotteries_,
                  [&](const Lottery& lottery) { return !lottery.wire && lottery.node == node; });
}

bool FaultInjector::begin_frame(const PlannedFrame& planned) {
    last_ = std::max(last_, planned.start);
    stuff_bits_ = 0;
    armed_.clear();
    next_armed_ = never;
    const std::size_t sender = index_of(planned.sender);
    const Name sender_name = sender < nodes_.size() ? nodes_[sender].name : Name::unnamed;
    for (FrameTrigger& trigger : frame_triggers_) {
        const auto& when = *std::get_if<InFrame>(&script_.faults[trigger.fault].trigger);
        if (!matches(when, planned.frame)) continue;
        if (trigger.sender != Name::unnamed && trigger.sender != sender_name) continue;
        ++trigger.attempts;
        if (trigger.attempts < when.first_attempt || trigger.attempts > when.last_attempt) continue;
        Armed armed{trigger.fault, when.place, {}};
        if (when.place.field == FramePlace::Field::any_bit) {
            armed.middle = planned.start + middle_of_bit(when.place.number, bitrate_);
            next_armed_ = std::min(next_armed_, armed.middle);
        } else if (when.place.field != FramePlace::Field::stuff_bit) {
            const auto position = position_of(when.place, planned.frame);
            if (!position) continue;
            armed.position = *position;
        }
        armed_.push_back(armed);
    }
    recessive_bits_ = 0;
    return !armed_.empty() || next(planned.start) < planned.end;
}

TimePoint FaultInjector::next(TimePoint from) const {
    for (const Effect& effect : effects_) {
        if (effect.until <= from || !effect.acts) continue;
        // Who is cut off from an idle bus sees what he would see on it.
        const bool is_cut_off = script_.faults[effect.fault].kind == FaultKind::cut_off;
        if (!is_cut_off || recessive_bits_ < quiet_bits) return from;
    }
    return std::max(from, std::min(next_, next_armed_));
}

void FaultInjector::disturb_driven(const BitMoment& moment, std::span<std::uint8_t> driven) {
    recessive_bits_ = is_any_dominant(driven) ? 0 : recessive_bits_ + 1;
    if (moment.position && moment.position->stuff) ++stuff_bits_;
    end_effects(moment.start);
    wire_flipped_ = false;
    flipped_.clear();
    if (next_ < moment.end) {
        run_timers(moment);
        run_lotteries(moment);
        find_next();
    }
    if (!armed_.empty()) run_armed(moment);
    last_ = std::max(last_, moment.end);
    count_effects();

    if (nodes_disturbed_) {
        const std::size_t known = std::min(driven.size(), nodes_.size());
        for (std::size_t i = 0; i < known; ++i) {
            Node& node = nodes_[i];
            if (node.disturbed.stuck) driven[i] = 0;
            if (node.disturbed.cut_off) node.sent = std::exchange(driven[i], std::uint8_t{1});
        }
    }
    const bool flips = wire_.flipped != wire_flipped_;
    if (!wire_.forced && !flips) return;
    std::uint8_t level = wire_.forced.value_or(is_any_dominant(driven) ? 0 : 1);
    if (flips) level ^= 1U;
    std::fill(driven.begin(), driven.end(), level);
}

void FaultInjector::disturb_seen(const BitMoment& /*moment*/,
                                 std::span<const std::uint8_t> /*driven*/,
                                 std::span<std::uint8_t> seen) {
    if (nodes_disturbed_) {
        const std::size_t known = std::min(seen.size(), nodes_.size());
        for (std::size_t i = 0; i < known; ++i) {
            const Node& node = nodes_[i];
            if (node.disturbed.cut_off) seen[i] = node.sent;
            if (node.disturbed.forced) seen[i] = *node.disturbed.forced;
            if (node.disturbed.flipped) seen[i] ^= 1U;
        }
    }
    for (const NodeIndex node : flipped_) {
        if (index_of(node) < seen.size()) seen[index_of(node)] ^= 1U;
    }
}

FaultInjector::Name FaultInjector::find(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) return Name::unnamed;
    return Name{static_cast<std::size_t>(found - names_.begin())};
}

/// Whether a fault is one of nodes with that name.
bool FaultInjector::names(std::size_t fault, Name name) const {
    const FaultTargets::Scope scope = script_.faults[fault].targets.scope;
    const std::vector<Name>& targets = target_names_[fault];
    return scope == FaultTargets::Scope::each_node ||
           (scope == FaultTargets::Scope::named && contains(targets, name));
}

bool FaultInjector::concerns(const Effect& effect, const Node& node) const {
    return node.attached && names(effect.fault, node.name) &&
           !contains(effect.reconnected, node.name);
}

void FaultInjector::add(FaultKind kind, Disturbed& disturbed) {
    switch (kind) {
        case FaultKind::flip:
            disturbed.flipped = !disturbed.flipped;
            break;
        case FaultKind::dominant:
            disturbed.forced = 0;
            break;
        case FaultKind::recessive:
            disturbed.forced = 1;
            break;
        case FaultKind::stuck_dominant:
            disturbed.stuck = true;
            break;
        case FaultKind::cut_off:
            disturbed.cut_off = true;
            break;
        case FaultKind::reconnect:
            break;
    }
}

/// Whenever effects or nodes come and go: bits are too many to do it for each.
void FaultInjector::combine_effects() {
    wire_ = Disturbed{};
    nodes_disturbed_ = false;
    for (Node& node : nodes_) node.disturbed = Disturbed{};
    for (Effect& effect : effects_) {
        const Fault& fault = script_.faults[effect.fault];
        effect.acts = fault.targets.scope == FaultTargets::Scope::wire;
        if (effect.acts) {
            const bool is_stuck = fault.kind == FaultKind::stuck_dominant;
            add(is_stuck ? FaultKind::dominant : fault.kind, wire_);
            continue;
        }
        for (Node& node : nodes_) {
            if (!concerns(effect, node)) continue;
            effect.acts = true;
            nodes_disturbed_ = true;
            add(fault.kind, node.disturbed);
        }
    }
}

void FaultInjector::count_effects() {
    for (Effect& effect : effects_) {
        if (effect.counted || !effect.acts) continue;
        effect.counted = true;
        ++acted_[effect.fault];
    }
}

void FaultInjector::end_effects(TimePoint time) {
    const auto ended =
        std::erase_if(effects_, [&](const Effect& effect) { return effect.until <= time; });
    if (ended > 0) combine_effects();
}

/// When a bit begins, on a bus that has had no other.
TimePoint FaultInjector::time_of_bit(std::uint64_t bit) const {
    if (bit / bitrate_ > latest_second) return never;
    return start_ + FaultTime{bit, true}.at(bitrate_);
}

std::uint64_t FaultInjector::first_bit_at(TimePoint time) const {
    const auto since = static_cast<std::uint64_t>(std::max(time - start_, Duration{}).count());
    std::uint64_t bit = since / second * bitrate_ + since % second * bitrate_ / second;
    while (time_of_bit(bit) < time) ++bit;
    return bit;
}

/// The next bit that is hit, counted from the first that begins at `from` or after it: the number
/// n of bits that are spared before it has the probability p * (1 - p)^n.
void FaultInjector::draw(Lottery& lottery, TimePoint from) {
    const std::uint64_t lot = random_();
    std::uint64_t spared = 0;
    std::uint64_t chance = UINT64_MAX;  // that so many are spared
    for (std::size_t k = lottery.powers.size(); k-- > 0;) {
        const std::uint64_t smaller = multiply_high(chance, lottery.powers[k]);
        if (lot >= smaller) continue;
        chance = smaller;
        spared += std::uint64_t{1} << k;
    }
    lottery.next = time_of_bit(first_bit_at(from) + spared);
}

void FaultInjector::add_lottery(std::size_t fault, bool wire, NodeIndex node) {
    Lottery lottery;
    lottery.fault = fault;
    lottery.wire = wire;
    lottery.node = node;
    std::uint64_t power = ~std::get_if<AtRandom>(&script_.faults[fault].trigger)->probability;
    for (std::uint64_t& element : lottery.powers) {
        element = power;
        power = multiply_high(power, power);
    }
    draw(lottery, last_);
    lotteries_.push_back(lottery);
}

/// When a timer goes off for the first time at `time` or after it.
TimePoint FaultInjector::timer_after(std::size_t fault, TimePoint time) const {
    const AtTime& at = *std::get_if<AtTime>(&script_.faults[fault].trigger);
    const TimePoint first = start_ + at.first.at(bitrate_);
    if (time <= first) return first;
    if (!at.period) return never;
    const TimePoint as_if_first_were_the_start = start_ + (time - first);
    const std::uint64_t since = at.period->in_bits
                                    ? first_bit_at(as_if_first_were_the_start)
                                    : static_cast<std::uint64_t>((time - first).count());
    const std::uint64_t times = (since + at.period->amount - 1) / at.period->amount;
    return first + FaultTime{times * at.period->amount, at.period->in_bits}.at(bitrate_);
}

void FaultInjector::find_next() {
    next_ = never;
    for (const Timer& timer : timers_) next_ = std::min(next_, timer.next);
    for (const Lottery& lottery : lotteries_) next_ = std::min(next_, lottery.next);
}

void FaultInjector::run_timers(const BitMoment& moment) {
    for (Timer& timer : timers_) {
        if (timer.next >= moment.end) continue;
        activate(timer.fault, moment);
        timer.next = timer_after(timer.fault, moment.end);
    }
}

void FaultInjector::run_lotteries(const BitMoment& moment) {
    for (Lottery& lottery : lotteries_) {
        if (lottery.next >= moment.end) continue;
        // Else the bit was not simulated: the node, or this object, was not there yet.
        if (lottery.next >= moment.start) {
            ++acted_[lottery.fault];
            if (lottery.wire) {
                wire_flipped_ = !wire_flipped_;
            } else {
                flipped_.push_back(lottery.node);
            }
        }
        draw(lottery, moment.end);
    }
}

void FaultInjector::run_armed(const BitMoment& moment) {
    next_armed_ = never;
    for (const Armed& armed : armed_) {
        bool is_here = false;
        if (armed.place.field == FramePlace::Field::any_bit) {
            is_here = armed.middle >= moment.start && armed.middle < moment.end;
            if (armed.middle >= moment.end) next_armed_ = std::min(next_armed_, armed.middle);
        } else if (armed.place.field == FramePlace::Field::stuff_bit) {
            is_here =
                moment.position && moment.position->stuff && stuff_bits_ == armed.place.number;
        } else {
            is_here = moment.position == armed.position;
        }
        if (is_here) activate(armed.fault, moment);
    }
}

void FaultInjector::activate(std::size_t index, const BitMoment& moment) {
    const Fault& fault = script_.faults[index];
    if (fault.kind == FaultKind::reconnect) {
        reconnect(index);
        return;
    }
    Effect effect;
    effect.fault = index;
    if (fault.duration) {
        effect.until = std::max(moment.end, moment.start + fault.duration->at(bitrate_));
    }
    const auto place = std::find_if(effects_.begin(), effects_.end(),
                                    [&](const Effect& other) { return other.fault >= index; });
    if (place != effects_.end() && place->fault == index) {
        *place = std::move(effect);
    } else {
        effects_.insert(place, std::move(effect));
    }
    combine_effects();
}

void FaultInjector::reconnect(std::size_t index) {
    const bool each = script_.faults[index].targets.scope == FaultTargets::Scope::each_node;
    bool has_ended = false;
    const auto ends = [&](Effect& effect) {
        if (script_.faults[effect.fault].kind != FaultKind::cut_off) return false;
        if (each) {
            has_ended = true;
            return true;
        }
        for (const Name name : target_names_[index]) {
            if (!names(effect.fault, name) || contains(effect.reconnected, name)) continue;
            effect.reconnected.push_back(name);
            has_ended = true;
        }
        const std::vector<Name>& cut_off = target_names_[effect.fault];
        return !cut_off.empty() && std::all_of(cut_off.begin(), cut_off.end(), [&](Name name) {
            return contains(effect.reconnected, name);
        });
    };
    std::erase_if(effects_, ends);
    if (!has_ended) return;
    ++acted_[index];
    combine_effects();
}

}  // namespace canorb::can::sim
