#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <cstring>

#include "orb/base/bytes.hpp"

namespace canorb::can {

/// One CAN frame as an application sees it. A plain value.
struct Frame {
    static constexpr std::uint8_t max_classic_payload = 8;
    static constexpr std::uint8_t max_payload = 64;

    std::uint32_t id = 0;     ///< 11 bits, or 29 where `extended`
    bool extended = false;    ///< 29-bit identifier
    bool remote = false;      ///< remote frame: `length` is its DLC, there is no data
    bool error = false;       ///< not a frame of the bus: the link tells of an error
    bool fd = false;          ///< CAN FD
    std::uint8_t length = 0;  ///< octets of data, 0..8 (0..64 with `fd`)
    std::array<std::uint8_t, max_payload> data{};

    /// A standard data frame. `payload` has at most 64 octets; CAN FD where more than 8.
    static Frame standard(std::uint32_t id, Bytes payload) {
        assert(payload.size() <= max_payload);
        Frame frame;
        frame.id = id;
        frame.length = static_cast<std::uint8_t>(payload.size());
        frame.fd = payload.size() > max_classic_payload;
        std::copy(payload.begin(), payload.end(), frame.data.begin());
        return frame;
    }

    Bytes payload() const { return Bytes{data.data(), remote ? std::size_t{0} : length}; }

    friend bool operator==(const Frame& a, const Frame& b) {
        return a.id == b.id && a.extended == b.extended && a.remote == b.remote &&
               a.error == b.error && a.fd == b.fd && a.length == b.length &&
               std::equal(a.payload().begin(), a.payload().end(), b.payload().begin(),
                          b.payload().end());
    }
};

/// The largest identifier: of 11 bits, or of 29 where `extended`.
constexpr std::uint32_t highest_id(bool extended) {
    return extended ? 0x1FFFFFFF : 0x7FF;
}

/// Whether classic CAN has such frames: data or remote, an identifier that fits its format, a DLC
/// of 0 to 8.
inline bool is_classic(const Frame& frame) {
    return !frame.fd && !frame.error && frame.length <= Frame::max_classic_payload &&
           frame.id <= highest_id(frame.extended);
}

/// Accepts a frame when its identifier agrees with `value` in every bit that is 1 in `mask` and
/// its kind (standard or extended) is this filter's.
struct Filter {
    std::uint32_t mask = 0;
    std::uint32_t value = 0;
    bool extended = false;
    bool data_only = false;  ///< passes no remote frames

    bool accepts(const Frame& frame) const {
        return frame.extended == extended && (frame.id & mask) == (value & mask) &&
               !(data_only && frame.remote);
    }
    friend bool operator==(const Filter&, const Filter&) = default;
};

}  // namespace canorb::can
