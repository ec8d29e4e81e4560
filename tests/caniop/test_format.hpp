#pragma once

#include <cstddef>
#include <optional>

#include "orb/base/bytes.hpp"
#include "orb/caniop/reassembler.hpp"

namespace canorb::caniop::test {

/// A message format for tests, with the shape that CANIOP expects of one: an octet that is not
/// 0x3F, the number of octets after the header in two octets, then those.
inline constexpr MessageFormat message_format{
    .header_octets = 3, .measure = [](Bytes first_frame) -> std::optional<std::size_t> {
        if (first_frame[0] == 0x3F) return std::nullopt;
        return std::size_t{3} + read_be16(&first_frame[1]);
    }};

}  // namespace canorb::caniop::test
