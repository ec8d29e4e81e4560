#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "longest_frame.hpp"
#include "orb/can/controller.hpp"

namespace canorb::bench {

/// Frames for streams that are to disturb: of 0 to 8 octets; random, of few different bits, and the
/// longest that there are.
class DisturbingFrames {
  public:
    DisturbingFrames(std::span<const std::uint32_t> ids, const LongestFrame& longest,
                     std::mt19937_64& random);

    /// With one of the identifiers.
    const can::Frame& next();
    /// The longest that next() returns, in bit times with the intermission.
    std::uint32_t longest_bits() const { return longest_bits_; }

  private:
    std::mt19937_64& random_;
    std::vector<can::Frame> frames_;
    std::uint32_t longest_bits_ = 0;
};

/// Takes the events of a controller that only sends, so that its mailboxes become free. Throws
/// std::runtime_error when a transmission was not `sent`.
void free_mailboxes(can::Controller& controller);

/// A node that has a frame in each mailbox after each fill().
class BusyNode {
  public:
    BusyNode(std::unique_ptr<can::Controller> controller, DisturbingFrames frames);

    void fill();
    std::uint32_t longest_bits() const { return frames_.longest_bits(); }

  private:
    std::unique_ptr<can::Controller> controller_;
    DisturbingFrames frames_;
};

}  // namespace canorb::bench
