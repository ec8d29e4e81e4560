#pragma once

#include <cstddef>

#include "orb/base/bytes.hpp"
#include "orb/can/frame.hpp"
#include "orb/caniop/identifier.hpp"

namespace canorb::caniop {

// How a message is cut into frames (doc/wire/caniop.md, "Segmentation"). Pure functions; nobody
// else knows how many octets a frame carries. Frame 0 is the first frame; frame i of the others
// has the sequence number i modulo 128.

/// How many frames a message of `length` octets (1 or more) takes.
std::size_t frame_count(std::size_t length);

/// How many message octets frame `index` of a message of `length` octets carries.
/// Precondition: index < frame_count(length).
std::size_t frame_octets(std::size_t length, std::size_t index);

/// Frame `index` of the message. Precondition: index < frame_count(message.size()).
can::Frame cut_frame(Identifier identifier, Bytes message, std::size_t index);

}  // namespace canorb::caniop
