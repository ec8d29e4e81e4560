#include "published_formats.hpp"

#include <algorithm>

#include "can_cost.hpp"

namespace canorb::bench {
namespace {

constexpr std::size_t frame_octets = 8;

CanCost frames_of(std::size_t count, std::size_t octets, bool extended) {
    const auto frames = static_cast<std::uint32_t>(count);
    return {frames, 0, frames * worst_length(octets, extended)};
}

/// SDO frames always have 8 octets. One transfer, in either direction.
CanCost sdo(std::size_t octets) {
    constexpr std::size_t expedited = 4;
    constexpr std::size_t segment = 7;
    const std::size_t segments = octets <= expedited ? 0 : (octets + segment - 1) / segment;
    return frames_of(2 + 2 * segments, frame_octets, false);
}

CanCost transfer(std::size_t octets) {
    constexpr std::size_t room = frame_octets - 1;  // a tail octet
    if (octets <= room) return frames_of(1, octets + 1, true);
    const std::size_t with_crc = octets + 2;
    CanCost cost = frames_of(with_crc / room, frame_octets, true);
    if (const std::size_t rest = with_crc % room; rest > 0) cost += frames_of(1, rest + 1, true);
    return cost;
}

}  // namespace

nlohmann::ordered_json with_canopen(const Values& values) {
    const std::size_t request = values.request + values.strings + values.long_ones;
    CanCost cost;
    if (!values.answered) {
        cost = frames_of(1, request, false);
    } else if (values.raises) {
        cost = sdo(std::max<std::size_t>(request, 1));  // the abort is its last frame
    } else {
        if (request > 0 || values.reply == 0) cost += sdo(std::max<std::size_t>(request, 1));
        if (values.reply > 0) cost += sdo(values.reply);
    }
    return cost.json(false);
}

nlohmann::ordered_json with_cyphal(const Values& values) {
    // The length of a string or sequence takes one octet, or two.
    const std::size_t request = values.request + values.strings + (values.strings > 0 ? 1 : 0) +
                                values.long_ones + (values.long_ones > 0 ? 2 : 0);
    CanCost cost = transfer(request);
    if (values.answered) cost += transfer(values.reply + (values.raises ? 1 : 0));
    return cost.json(false);
}

}  // namespace canorb::bench
