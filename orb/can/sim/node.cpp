#include "orb/can/sim/node.hpp"

#include <algorithm>

namespace canorb::can::sim {
namespace {

constexpr std::size_t basic_can_filters = 2;

}  // namespace

Node::Node(const NodeOptions& node_options, std::uint64_t recessive_bits)
    : processor(node_options.automatic_recovery, recessive_bits),
      options(node_options),
      events(node_options.receive_capacity) {
    mailboxes_.reserve(options.mailboxes);
    filters_.reserve(std::max(options.filter_list, basic_can_filters));
}

std::size_t Node::free_mailboxes() const {
    const std::size_t used = mailboxes_.size() + events.results();
    return used < options.mailboxes ? options.mailboxes - used : 0;
}

std::optional<SendError> Node::submit(const Frame& frame, TransmitHandle handle,
                                      SendOptions send_options) {
    if (!is_classic(frame) || processor.is_listen_only()) return SendError::unsupported;
    if (processor.status().state == ControllerState::bus_off) return SendError::bus_off;
    if (free_mailboxes() == 0) return SendError::full;
    Mailbox& mailbox = mailboxes_.emplace_back();
    mailbox.frame = frame;
    // Only what goes over the bus arrives.
    std::fill(mailbox.frame.data.begin() + static_cast<std::ptrdiff_t>(frame.payload().size()),
              mailbox.frame.data.end(), std::uint8_t{0});
    mailbox.bits = stuffed_bits(frame);
    mailbox.arbitration = arbitration_field(frame);
    mailbox.handle = handle;
    mailbox.one_shot = send_options.one_shot;
    return std::nullopt;
}

bool Node::fail(TransmitHandle handle, TimePoint now) {
    if (free_mailboxes() == 0) return false;
    events.push(TransmitResult{handle, TransmitOutcome::failed, now});
    return true;
}

void Node::abort(TransmitHandle handle, TimePoint now) {
    const auto mailbox =
        std::find_if(mailboxes_.begin(), mailboxes_.end(),
                     [handle](const Mailbox& each) { return each.handle == handle; });
    if (mailbox == mailboxes_.end()) return;
    if (mailbox->part == Part::waiting) {
        finish(static_cast<std::size_t>(mailbox - mailboxes_.begin()), TransmitOutcome::aborted,
               now);
    } else {
        mailbox->abort_requested = true;
    }
}

bool Node::set_filters(std::span<const Filter> filters) {
    const std::size_t room = options.filter_list == 0 ? basic_can_filters : options.filter_list;
    if (filters.size() > room) return false;
    filters_.assign(filters.begin(), filters.end());
    return true;
}

void Node::set_listen_only(bool on, bool dominant, TimePoint now) {
    processor.set_listen_only(on, dominant);
    if (!on) return;
    for (std::size_t i = 0; i < mailboxes_.size();) {
        if (mailboxes_[i].part == Part::waiting) {
            finish(i, TransmitOutcome::aborted, now);
        } else {
            mailboxes_[i++].abort_requested = true;
        }
    }
}

void Node::leave() {
    leaving = true;
    std::erase_if(mailboxes_, [](const Mailbox& each) { return each.part == Part::waiting; });
    for (Mailbox& mailbox : mailboxes_) mailbox.abort_requested = true;
}

const Node::Mailbox* Node::candidate() const {
    const Mailbox* lowest = nullptr;
    for (const Mailbox& mailbox : mailboxes_) {
        if (lowest == nullptr || mailbox.arbitration < lowest->arbitration) lowest = &mailbox;
    }
    return lowest;
}

std::optional<std::size_t> Node::find_on_bus() const {
    for (std::size_t i = 0; i < mailboxes_.size(); ++i) {
        if (mailboxes_[i].part != Part::waiting) return i;
    }
    return std::nullopt;
}

const Node::Mailbox* Node::on_bus() const {
    const auto index = find_on_bus();
    return index ? &mailboxes_[*index] : nullptr;
}

void Node::begin(const Mailbox& chosen) {
    mailboxes_[static_cast<std::size_t>(&chosen - mailboxes_.data())].part = Part::sending;
}

void Node::lose(std::uint8_t at) {
    ++statistics.lost_arbitrations;
    statistics.arbitration_lost_at = at;
    if (const auto index = find_on_bus()) mailboxes_[*index].part = Part::lost;
}

void Node::end_sent(TimePoint now) {
    ++statistics.sent;
    if (const auto index = find_on_bus()) finish(*index, TransmitOutcome::sent, now);
}

void Node::end_received(const Frame& frame, TimePoint now) {
    ++statistics.received;
    const bool accepted = std::any_of(filters_.begin(), filters_.end(),
                                      [&](const Filter& filter) { return filter.accepts(frame); });
    if (accepted) events.push(Received{frame, now});
    settle(now);
}

void Node::end_failed(TimePoint now) {
    settle(now);
}

void Node::settle(TimePoint now) {
    const auto index = find_on_bus();
    if (!index) return;
    Mailbox& mailbox = mailboxes_[*index];
    mailbox.part = Part::waiting;
    if (mailbox.one_shot) {
        finish(*index, TransmitOutcome::failed, now);
    } else if (mailbox.abort_requested) {
        finish(*index, TransmitOutcome::aborted, now);
    }
}

void Node::tell_status(TimePoint now) {
    events.push(StateChanged{processor.status(), now});
    if (processor.status().state != ControllerState::bus_off) return;
    while (!mailboxes_.empty()) finish(0, TransmitOutcome::failed, now);
}

void Node::finish(std::size_t mailbox, TransmitOutcome outcome, TimePoint now) {
    events.push(TransmitResult{mailboxes_[mailbox].handle, outcome, now});
    mailboxes_.erase(mailboxes_.begin() + static_cast<std::ptrdiff_t>(mailbox));
}

}  // namespace canorb::can::sim
