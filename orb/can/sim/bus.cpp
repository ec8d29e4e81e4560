#include "orb/can/sim/bus.hpp"

#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>

#include "orb/can/frame_length.hpp"

namespace canorb::can::sim {
namespace {

constexpr std::uint32_t error_flag_bits = 6;
constexpr std::uint32_t echoed_error_flag_bits = 12;  // a second node's flag begins at its end
constexpr std::uint32_t error_delimiter_bits = 8;
constexpr std::uint32_t bits_after_ack_slot = 1 + 7;  // ACK delimiter, EOF
constexpr std::uint64_t recovery_bits = 128 * 11;
constexpr int error_weight = 8;
constexpr int highest_active_count = 127;
constexpr int highest_passive_count = 255;
constexpr std::size_t basic_can_filters = 2;

/// Of two frames with one arbitration field: whether `a` has the dominant bit where they first
/// differ on the bus. DLC goes before the data, most significant bit first, and equal bits are
/// stuffed alike.
bool is_dominant(const Frame& a, const Frame& b) {
    if (a.length != b.length) return a.length < b.length;
    return std::lexicographical_compare(a.payload().begin(), a.payload().end(), b.payload().begin(),
                                        b.payload().end());
}

/// Bits up to and including the first that differs.
std::uint32_t bits_to_difference(const Frame& a, const Frame& b) {
    const StuffedBits left = stuffed_bits(a);
    const StuffedBits right = stuffed_bits(b);
    std::size_t i = 0;
    while (i < left.size && i < right.size && left.bits[i] == right.bits[i]) ++i;
    return static_cast<std::uint32_t>(i + 1);
}

}  // namespace

Bus::Node::Node(const NodeOptions& node_options, std::uint64_t attach_order)
    : options(node_options), events(node_options.receive_capacity), order(attach_order) {
    mailboxes.reserve(options.mailboxes);
    filters.reserve(std::max(options.filter_list, basic_can_filters));
}

Bus::Bus(std::uint32_t bitrate, TimePoint start)
    : bitrate_(bitrate), time_(start), busy_since_(start) {
    assert(bitrate >= lowest_bitrate && bitrate <= highest_bitrate);
}

NodeIndex Bus::attach(const NodeOptions& options) {
    assert(options.mailboxes >= 1 && options.mailboxes <= 255);
    auto free = std::find_if(nodes_.begin(), nodes_.end(),
                             [](const std::optional<Node>& node) { return !node.has_value(); });
    if (free == nodes_.end()) free = nodes_.emplace(nodes_.end());
    free->emplace(options, ++order_);
    return NodeIndex{static_cast<std::uint16_t>(free - nodes_.begin())};
}

void Bus::detach(NodeIndex node) {
    assert(static_cast<std::size_t>(node) < nodes_.size());
    nodes_[static_cast<std::size_t>(node)].reset();
}

Bus::Node& Bus::at(NodeIndex node) {
    assert(static_cast<std::size_t>(node) < nodes_.size());
    assert(nodes_[static_cast<std::size_t>(node)].has_value());
    return *nodes_[static_cast<std::size_t>(node)];
}

const Bus::Node& Bus::at(NodeIndex node) const {
    assert(static_cast<std::size_t>(node) < nodes_.size());
    assert(nodes_[static_cast<std::size_t>(node)].has_value());
    return *nodes_[static_cast<std::size_t>(node)];
}

std::size_t Bus::free_mailboxes(const Node& node) const {
    const std::size_t used = node.mailboxes.size() + node.events.results();
    return used < node.options.mailboxes ? node.options.mailboxes - used : 0;
}

std::optional<SendError> Bus::submit(NodeIndex index, const Frame& frame,
                                          TransmitHandle handle, SendOptions options) {
    Node& node = at(index);
    const std::uint32_t highest_id = frame.extended ? 0x1FFFFFFF : 0x7FF;
    if (frame.fd || frame.error || frame.length > Frame::max_classic_payload ||
        frame.id > highest_id || node.listen_only) {
        return SendError::unsupported;
    }
    if (node.status.state == ControllerState::bus_off) return SendError::bus_off;
    if (free_mailboxes(node) == 0) return SendError::full;
    Mailbox mailbox;
    mailbox.frame = frame;
    mailbox.handle = handle;
    mailbox.arbitration = arbitration_field(frame);
    mailbox.length = frame_length(frame);
    mailbox.one_shot = options.one_shot;
    node.mailboxes.push_back(mailbox);
    return std::nullopt;
}

bool Bus::fail(NodeIndex index, TransmitHandle handle) {
    Node& node = at(index);
    if (free_mailboxes(node) == 0) return false;
    node.events.push(TransmitResult{handle, TransmitOutcome::failed, time_});
    return true;
}

void Bus::abort(NodeIndex index, TransmitHandle handle) {
    Node& node = at(index);
    for (std::size_t i = 0; i < node.mailboxes.size(); ++i) {
        if (node.mailboxes[i].handle != handle) continue;
        if (node.mailboxes[i].part == Part::waiting) {
            finish(node, i, TransmitOutcome::aborted);
        } else {
            node.mailboxes[i].abort_requested = true;
        }
        return;
    }
}

bool Bus::set_filters(NodeIndex index, std::span<const Filter> filters) {
    Node& node = at(index);
    const std::size_t room =
        node.options.filter_list == 0 ? basic_can_filters : node.options.filter_list;
    if (filters.size() > room) return false;
    node.filters.assign(filters.begin(), filters.end());
    return true;
}

void Bus::set_listen_only(NodeIndex index, bool on) {
    Node& node = at(index);
    node.listen_only = on;
    if (!on) return;
    for (std::size_t i = 0; i < node.mailboxes.size();) {
        if (node.mailboxes[i].part == Part::waiting) {
            finish(node, i, TransmitOutcome::aborted);
        } else {
            node.mailboxes[i++].abort_requested = true;
        }
    }
}

void Bus::recover(NodeIndex index) {
    Node& node = at(index);
    if (node.status.state != ControllerState::bus_off || node.recovered_at != never) return;
    node.recovered_at = time_ + span(recovery_bits);
}

ErrorStatus Bus::error_status(NodeIndex node) const {
    return at(node).status;
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

const EventQueue& Bus::events(NodeIndex node) const {
    return at(node).events;
}

/// The frame with which a node would take part in an arbitration.
const Bus::Mailbox* Bus::candidate(const Node& node) {
    if (!takes_part(node)) return nullptr;
    const Mailbox* lowest = nullptr;
    for (const Mailbox& mailbox : node.mailboxes) {
        if (lowest == nullptr || mailbox.arbitration < lowest->arbitration) lowest = &mailbox;
    }
    return lowest;
}

Duration Bus::span(std::uint64_t bits) const {
    return Duration{static_cast<Duration::rep>(bits * 1'000'000'000U / bitrate_)};
}

TimePoint Bus::free_at() const {
    return busy_since_ + span(busy_bits_);
}

TimePoint Bus::next_recovery() const {
    TimePoint earliest = never;
    for (const auto& node : nodes_) {
        if (node) earliest = std::min(earliest, node->recovered_at);
    }
    return earliest;
}

std::optional<Bus::Attempt> Bus::next_attempt() const {
    const Mailbox* winner = nullptr;  // of the frames that win, the most dominant
    NodeIndex sender{};
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (!nodes_[i]) continue;
        const Mailbox* mailbox = candidate(*nodes_[i]);
        if (mailbox == nullptr) continue;
        if (winner == nullptr || mailbox->arbitration < winner->arbitration ||
            (mailbox->arbitration == winner->arbitration &&
             is_dominant(mailbox->frame, winner->frame))) {
            winner = mailbox;
            sender = NodeIndex{static_cast<std::uint16_t>(i)};
        }
    }
    if (winner == nullptr) return std::nullopt;

    std::size_t nodes = 0;
    bool acknowledged = false;
    bool collision = false;         // some frame differs
    bool active_collision = false;  // and its sender is error active
    bool worth_repeating = false;   // an unacknowledged attempt changes something
    std::uint32_t intact_bits = winner->length;
    for (const auto& node : nodes_) {
        if (!node || !takes_part(*node)) continue;
        if (!node->listen_only) ++nodes;
        const Mailbox* mailbox = candidate(*node);
        if (mailbox == nullptr || mailbox->arbitration != winner->arbitration) {
            acknowledged = acknowledged || !node->listen_only;
            continue;
        }
        const bool is_active = node->status.state == ControllerState::error_active;
        worth_repeating = worth_repeating || is_active || mailbox->one_shot;
        if (mailbox->frame == winner->frame) continue;
        collision = true;
        if (!is_active) continue;
        active_collision = true;
        intact_bits = std::min(intact_bits, bits_to_difference(winner->frame, mailbox->frame));
    }
    if (!acknowledged && !collision && !worth_repeating) return std::nullopt;

    Attempt attempt;
    attempt.frame = winner->frame;
    attempt.arbitration = winner->arbitration;
    attempt.sender = sender;
    const std::uint32_t flag_bits = nodes > 1 ? echoed_error_flag_bits : error_flag_bits;
    if (active_collision) {
        attempt.fate = Fate::collided;
        attempt.bits = intact_bits + flag_bits + error_delimiter_bits + intermission_bits;
    } else if (!acknowledged) {
        attempt.fate = Fate::unacknowledged;
        attempt.bits = winner->length - bits_after_ack_slot + flag_bits + error_delimiter_bits;
    } else {
        attempt.fate = Fate::sent;
        attempt.bits = winner->length;
    }
    attempt.start = std::max(free_at(), time_);
    const bool back_to_back = attempt.start == free_at();
    const TimePoint since = back_to_back ? busy_since_ : attempt.start;
    const std::uint64_t before = back_to_back ? busy_bits_ : 0;
    attempt.end = since + span(before + attempt.bits - intermission_bits);
    return attempt;
}

void Bus::begin(const Attempt& attempt) {
    if (attempt.start != free_at()) {
        busy_since_ = attempt.start;
        busy_bits_ = 0;
    }
    busy_bits_ += attempt.bits;
    if (busy_bits_ >= bitrate_) {  // a second's worth of bits is exactly a second
        busy_since_ += std::chrono::seconds{1};
        busy_bits_ -= bitrate_;
    }
    on_bus_ = attempt;
    on_bus_->order = ++order_;
    for (auto& node : nodes_) {
        if (!node) continue;
        const Mailbox* chosen = candidate(*node);
        if (chosen == nullptr) continue;
        Mailbox& mailbox = node->mailboxes[static_cast<std::size_t>(chosen - &node->mailboxes[0])];
        if (mailbox.arbitration != attempt.arbitration) {
            if (mailbox.one_shot) mailbox.part = Part::lost_one_shot;
        } else if (attempt.fate == Fate::collided || mailbox.frame == attempt.frame) {
            mailbox.part = Part::sending;
        } else {
            mailbox.part = Part::outvoted;
        }
    }
}

void Bus::complete() {
    const Attempt attempt = *std::exchange(on_bus_, std::nullopt);
    time_ = attempt.end;
    if (attempt.fate == Fate::sent && trace_) {
        CompletedFrame completed;
        completed.frame = attempt.frame;
        completed.time = attempt.end;
        completed.sender = attempt.sender;
        trace_(completed);
    }
    for (auto& node : nodes_) {
        if (!node || !takes_part(*node) || node->order > attempt.order) continue;
        const auto busy =
            std::find_if(node->mailboxes.begin(), node->mailboxes.end(),
                         [](const Mailbox& mailbox) { return mailbox.part != Part::waiting; });
        const bool is_receiver = busy == node->mailboxes.end() || busy->part == Part::lost_one_shot;
        if (is_receiver) receive(*node, attempt);
        if (busy != node->mailboxes.end()) {
            settle(*node, static_cast<std::size_t>(busy - node->mailboxes.begin()), attempt.fate);
        }
    }
}

/// What the end of an attempt means for a mailbox that took part in it.
void Bus::settle(Node& node, std::size_t index, Fate fate) {
    Mailbox& mailbox = node.mailboxes[index];
    const Part part = std::exchange(mailbox.part, Part::waiting);
    if (part == Part::sending && fate == Fate::sent) {
        finish(node, index, TransmitOutcome::sent);
        count_errors(node, -1, 0);
        return;
    }
    const bool is_error = part != Part::lost_one_shot;
    const bool is_unheard = part == Part::sending && fate == Fate::unacknowledged;
    const bool is_passive = node.status.state == ControllerState::error_passive;
    if (mailbox.one_shot) {
        finish(node, index, TransmitOutcome::failed);
    } else if (mailbox.abort_requested) {
        finish(node, index, TransmitOutcome::aborted);
    }
    if (is_error && !(is_unheard && is_passive)) count_errors(node, error_weight, 0);
}

void Bus::receive(Node& node, const Attempt& attempt) {
    if (attempt.fate != Fate::sent) {
        // A silent node counts nothing; without an acknowledging receiver there is no other.
        if (!node.listen_only) count_errors(node, 0, 1);
        return;
    }
    count_errors(node, 0, -1);
    const bool accepted = std::any_of(node.filters.begin(), node.filters.end(),
                                      [&](const Filter& f) { return f.accepts(attempt.frame); });
    if (accepted) node.events.push(Received{attempt.frame, attempt.end});
}

void Bus::recover_nodes() {
    for (auto& node : nodes_) {
        if (!node || node->recovered_at > time_) continue;
        node->recovered_at = never;
        node->status = ErrorStatus{};
        node->order = ++order_;  // a frame now on the bus passes it by
        node->events.push(StateChanged{node->status, time_});
    }
}

void Bus::finish(Node& node, std::size_t index, TransmitOutcome outcome) {
    node.events.push(TransmitResult{node.mailboxes[index].handle, outcome, time_});
    node.mailboxes.erase(node.mailboxes.begin() + static_cast<std::ptrdiff_t>(index));
}

void Bus::fail_all(Node& node) {
    while (!node.mailboxes.empty()) finish(node, 0, TransmitOutcome::failed);
}

void Bus::count_errors(Node& node, int tec, int rec) {
    ErrorStatus& status = node.status;
    const auto add = [](int counter, int change) {
        // A good frame brings a counter above the passive limit back to it at once.
        if (change < 0 && counter > highest_active_count + 1) return highest_active_count;
        return std::max(counter + change, 0);
    };
    const int new_tec = std::max(status.tec + tec, 0);
    const int new_rec =
        rec == 0 ? status.rec : std::min(add(status.rec, rec), highest_passive_count);
    status.tec = static_cast<std::uint16_t>(new_tec);
    status.rec = static_cast<std::uint16_t>(new_rec);
    const ControllerState before = status.state;
    if (new_tec > highest_passive_count) {
        status.state = ControllerState::bus_off;
    } else if (new_tec > highest_active_count || new_rec > highest_active_count) {
        status.state = ControllerState::error_passive;
    } else {
        status.state = ControllerState::error_active;
    }
    if (status.state == before) return;
    node.events.push(StateChanged{status, time_});
    if (status.state == ControllerState::bus_off) fail_all(node);
}

TimePoint Bus::next_event() const {
    TimePoint event = next_recovery();
    if (on_bus_) {
        event = std::min(event, on_bus_->end);
    } else if (const auto attempt = next_attempt()) {
        event = std::min(event, attempt->end);
    }
    return event;
}

void Bus::advance(TimePoint to) {
    if (to < time_) return;
    while (true) {
        const TimePoint recovery = next_recovery();
        if (on_bus_) {
            if (std::min(on_bus_->end, recovery) > to) break;
            if (on_bus_->end <= recovery) {
                complete();
                continue;
            }
        } else if (const auto attempt = next_attempt()) {
            // At its very start others may still join in.
            if (attempt->start < std::min(to, recovery)) {
                begin(*attempt);
                continue;
            }
            if (recovery > to) break;
        } else if (recovery > to) {
            break;
        }
        time_ = recovery;
        recover_nodes();
    }
    time_ = to;
}

bool Bus::advance_one() {
    const TimePoint event = next_event();
    if (event == never) return false;
    // Nothing ends before `event`, and whatever else ends at that moment is complete as well.
    advance(event);
    return true;
}

}  // namespace canorb::can::sim
