#include "orb/can/sim/event_queue.hpp"

namespace canorb::can::sim {

EventQueue::EventQueue(std::size_t receive_capacity)
    : receive_capacity_(receive_capacity), ring_(receive_capacity + 16) {}

void EventQueue::append(const ControllerEvent& event) {
    if (size_ == ring_.size()) {
        std::vector<ControllerEvent> larger(ring_.size() * 2);
        for (std::size_t i = 0; i < size_; ++i) larger[i] = at(i);
        ring_.swap(larger);
        first_ = 0;
    }
    ++size_;
    at(size_ - 1) = event;
}

void EventQueue::push(const Received& received) {
    if (!receive_full()) {
        ++received_;
        append(received);
        open_loss_.reset();
        return;
    }
    ++lost_;
    push_doubt(received.time);
    ++std::get_if<FramesLost>(&at(*open_loss_))->count;
}

void EventQueue::push_doubt(TimePoint time) {
    if (open_loss_) return;
    append(FramesLost{0, time});
    open_loss_ = size_ - 1;
}

void EventQueue::push(const TransmitResult& result) {
    ++results_;
    append(result);
}

void EventQueue::push(const StateChanged& change) {
    if (size_ > 0) {
        if (auto* last = std::get_if<StateChanged>(&at(size_ - 1))) {
            *last = change;
            return;
        }
    }
    append(change);
}

std::optional<ControllerEvent> EventQueue::pop() {
    if (size_ == 0) return std::nullopt;
    const ControllerEvent event = at(0);
    first_ = (first_ + 1) % ring_.size();
    --size_;
    if (std::holds_alternative<Received>(event)) --received_;
    if (std::holds_alternative<TransmitResult>(event)) --results_;
    if (open_loss_) {
        if (*open_loss_ == 0) {
            open_loss_.reset();
        } else {
            --*open_loss_;
        }
    }
    return event;
}

}  // namespace canorb::can::sim
