#include "orb/can/link/slcan_mailboxes.hpp"

#include <utility>

#include "orb/can/frame_length.hpp"

namespace canorb::can {

SlcanMailboxes::SlcanMailboxes(sim::EventQueue& events) : events_(events) {
    transmissions_.reserve(count);
}

TransmitHandle SlcanMailboxes::add(const Frame& frame) {
    const TransmitHandle handle{next_handle_++};
    transmissions_.push_back({handle, arbitration_field(frame), frame});
    return handle;
}

const SlcanMailboxes::Transmission* SlcanMailboxes::next() const {
    const Transmission* lowest = nullptr;
    for (const Transmission& transmission : transmissions_) {
        if (transmission.over) continue;
        if (lowest == nullptr || transmission.arbitration < lowest->arbitration) {
            lowest = &transmission;
        }
    }
    return lowest;
}

const Frame& SlcanMailboxes::start() {
    const Transmission& transmission = *next();
    under_way_ = transmission.handle;
    return transmission.frame;
}

bool SlcanMailboxes::end(bool accepted, TimePoint now) {
    const auto ended = std::exchange(under_way_, std::nullopt);
    for (Transmission& transmission : transmissions_) {
        if (transmission.handle != ended || transmission.over) continue;
        if (!accepted && !transmission.withdrawn) return true;
        finish(transmission, accepted ? TransmitOutcome::sent : TransmitOutcome::aborted, now);
    }
    return false;
}

void SlcanMailboxes::withdraw(TransmitHandle handle, TimePoint now) {
    for (Transmission& transmission : transmissions_) {
        if (transmission.handle == handle) withdraw(transmission, now);
    }
}

void SlcanMailboxes::withdraw_all(TimePoint now) {
    for (Transmission& transmission : transmissions_) withdraw(transmission, now);
}

void SlcanMailboxes::withdraw(Transmission& transmission, TimePoint now) {
    transmission.withdrawn = true;
    if (transmission.handle != under_way_) finish(transmission, TransmitOutcome::aborted, now);
}

void SlcanMailboxes::fail_all(TimePoint now) {
    for (Transmission& transmission : transmissions_) {
        finish(transmission, TransmitOutcome::failed, now);
    }
}

void SlcanMailboxes::finish(Transmission& transmission, TransmitOutcome outcome, TimePoint now) {
    if (transmission.over) return;
    transmission.over = true;
    events_.push(TransmitResult{transmission.handle, outcome, now});
}

void SlcanMailboxes::on_taken(const ControllerEvent& event) {
    const auto* result = std::get_if<TransmitResult>(&event);
    if (result == nullptr) return;
    std::erase_if(transmissions_, [&](const Transmission& transmission) {
        return transmission.handle == result->handle;
    });
}

}  // namespace canorb::can
