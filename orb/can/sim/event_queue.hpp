#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "orb/can/controller.hpp"

namespace canorb::can::sim {

/// What a controller has to tell and nobody has taken yet, in order.
///
/// It is bounded although it never refuses: Received events stop at the receive capacity and are
/// counted as lost from then on, TransmitResults are bounded by the sender's mailboxes (its user
/// sees to that), and FramesLost and StateChanged events fold into the one before where nothing
/// that a reader could tell apart happened in between.
class EventQueue {
  public:
    /// `receive_capacity`: Received events held at once.
    explicit EventQueue(std::size_t receive_capacity);

    void push(const Received& received);
    void push(const TransmitResult& result);
    void push(const StateChanged& change);
    /// A frame that could not be read, and may not be repeated: FramesLost with a count of 0.
    void push_doubt(TimePoint time);

    std::optional<ControllerEvent> pop();
    /// What pop() would return; null when empty().
    const ControllerEvent* front() const { return empty() ? nullptr : &ring_[first_]; }

    bool empty() const { return size_ == 0; }
    std::size_t received() const { return received_; }
    bool receive_full() const { return received_ >= receive_capacity_; }
    /// TransmitResults that wait to be taken.
    std::size_t results() const { return results_; }
    /// Frames lost so far.
    std::uint64_t lost() const { return lost_; }

  private:
    ControllerEvent& at(std::size_t index) { return ring_[(first_ + index) % ring_.size()]; }
    void append(const ControllerEvent& event);

    std::size_t receive_capacity_;
    std::vector<ControllerEvent> ring_;
    std::size_t first_ = 0;
    std::size_t size_ = 0;
    std::size_t received_ = 0;
    std::size_t results_ = 0;
    std::uint64_t lost_ = 0;
    /// Where the FramesLost event is that further losses add to, counted from the front.
    std::optional<std::size_t> open_loss_;
};

}  // namespace canorb::can::sim
