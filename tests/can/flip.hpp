#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "orb/can/sim/disturbance.hpp"

namespace canorb::can::sim::test {

/// Turns over one bit of the first frame that begins after at(), as one node or as all see it.
class Flip : public Disturbance {
  public:
    void at(FramePosition position, std::optional<NodeIndex> node = std::nullopt) {
        position_ = position;
        node_ = node;
        armed_ = true;
        active_ = false;
    }

    void node_attached(NodeIndex, std::string_view) override {}
    void node_detached(NodeIndex) override {}
    bool begin_frame(const PlannedFrame&) override {
        active_ = armed_;
        armed_ = false;
        return active_;
    }
    TimePoint next(TimePoint) const override { return never; }
    void disturb_driven(const BitMoment&, std::span<std::uint8_t>) override {}
    void disturb_seen(const BitMoment& moment, std::span<const std::uint8_t>,
                      std::span<std::uint8_t> seen) override {
        if (!active_ || moment.position != position_) return;
        active_ = false;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            if (!node_ || i == static_cast<std::size_t>(*node_)) seen[i] ^= 1U;
        }
    }

  private:
    FramePosition position_;
    std::optional<NodeIndex> node_;
    bool armed_ = false;
    bool active_ = false;
};

}  // namespace canorb::can::sim::test
