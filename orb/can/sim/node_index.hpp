#pragma once

#include <cstdint>

namespace canorb::can::sim {

/// A node of one Bus, from its attach() until it has left. Numbers are used again.
enum class NodeIndex : std::uint16_t {};

}  // namespace canorb::can::sim
