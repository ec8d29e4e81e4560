#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/can/frame.hpp"

namespace canorb::bench {

/// What frames cost a classical CAN bus, each with its intermission.
struct CanCost {
    std::uint32_t frames = 0;
    std::uint32_t bits = 0;        ///< with the stuff bits that these frames have
    std::uint32_t worst_bits = 0;  ///< with as many as frames of these lengths can have

    CanCost& operator+=(const CanCost& other);
    /// With the time at 125, 500 and 1000 kbit/s. `known`: `bits` counts; else only the worst case
    /// is told.
    nlohmann::ordered_json json(bool known = true) const;
};

CanCost cost_of(const can::Frame& frame);
CanCost cost_of(const std::vector<can::Frame>& frames);

/// The longest that a frame with so many octets of data can be, in bits, intermission included:
/// Davis, Burns, Bril, Lukkien (2007), equation 1, with g = 34 or, extended, 54.
std::uint32_t worst_length(std::size_t octets, bool extended);

/// A message over ISO 15765-2 (ISO-TP) with normal addressing, no padding, one flow control frame
/// (block size 0) and no separation time: the least that it can cost. More than 4095 octets have no
/// classical form; there are none here.
std::vector<can::Frame> over_iso_tp(Bytes message);

}  // namespace canorb::bench
