#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "orb/can/frame.hpp"

namespace canorb::bench {

/// Finds the data with which a standard frame is longest. The formula of the analysis assumes more
/// stuff bits than are possible, for part of a frame is given: RTR, IDE, r0, the DLC, and a CRC
/// that follows from the rest.
///
/// Sending is a walk through the states (CRC register, last level, how often it came in a row); the
/// table has the most stuff bits from each state on, for each number of data bits to come. The
/// identifier and the length only say where the walk begins.
class LongestFrame {
  public:
    LongestFrame();

    /// Where more than one choice of a bit leads to the longest frame, `random` decides.
    can::Frame find(std::uint32_t id, std::uint8_t octets, std::mt19937_64& random) const;

  private:
    /// Of what a controller has sent so far.
    struct State {
        std::uint32_t crc = 0;
        std::uint32_t level = 1;
        std::uint32_t run = 0;  ///< 0 before SOF, else 1..4: after 5 comes a stuff bit

        std::size_t index() const { return (std::size_t{crc} << 3) | (level << 2) | (run - 1); }
        /// Sends a bit, of which the CRC takes note. The stuff bits that were sent with it.
        std::uint32_t send(std::uint32_t bit);
        std::uint32_t send_bits(std::uint32_t value, int width);
    };

    static constexpr std::size_t states = std::size_t{1} << 18;
    static constexpr std::size_t most_data_bits = 64;

    /// By the number of data bits to come, then by State::index().
    std::vector<std::vector<std::uint8_t>> most_stuff_bits_;
};

}  // namespace canorb::bench
