#include "orb/caniop/segmenter.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "orb/caniop/format.hpp"

namespace canorb::caniop {
namespace {

// Until peers negotiate CAN FD, every frame is a classic one, whatever the link could carry.
constexpr std::size_t first_frame_octets = can::Frame::max_classic_payload;
constexpr std::size_t continuation_octets = first_frame_octets - format::sequence_octets;

constexpr std::size_t offset_of(std::size_t index) {
    return index == 0 ? 0 : first_frame_octets + (index - 1) * continuation_octets;
}

}  // namespace

std::size_t frame_count(std::size_t length) {
    if (length <= first_frame_octets) return 1;
    return 1 + (length - first_frame_octets + continuation_octets - 1) / continuation_octets;
}

std::size_t frame_octets(std::size_t length, std::size_t index) {
    assert(index < frame_count(length));
    return std::min(length - offset_of(index),
                    index == 0 ? first_frame_octets : continuation_octets);
}

can::Frame cut_frame(Identifier identifier, Bytes message, std::size_t index) {
    const Bytes octets = message.subspan(offset_of(index), frame_octets(message.size(), index));
    if (index == 0) return can::Frame::standard(identifier.can_id(), octets);
    std::array<std::uint8_t, first_frame_octets> payload{};
    payload[0] =
        static_cast<std::uint8_t>(format::continuation_bit | (index % format::sequence_modulus));
    std::copy(octets.begin(), octets.end(), payload.begin() + format::sequence_octets);
    return can::Frame::standard(identifier.can_id(),
                                Bytes{payload.data(), format::sequence_octets + octets.size()});
}

}  // namespace canorb::caniop
