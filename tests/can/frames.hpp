#pragma once

#include <cstdint>
#include <string_view>

#include "orb/can/frame.hpp"
#include "tests/support/octets.hpp"

// Frames in a few words.
namespace canorb::can::test {

inline Frame standard(std::uint32_t id, std::string_view data = "") {
    return Frame::standard(id, canorb::test::octets(data));
}

inline Frame extended(std::uint32_t id, std::string_view data = "") {
    Frame frame = standard(id, data);
    frame.extended = true;
    return frame;
}

inline Frame remote(Frame frame, std::uint8_t dlc = 0) {
    frame.remote = true;
    frame.length = dlc;
    return frame;
}

}  // namespace canorb::can::test

namespace canorb::can::sim::test {

using can::test::extended;
using can::test::remote;
using can::test::standard;

}  // namespace canorb::can::sim::test
