#include "can_cost.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "orb/can/frame_length.hpp"

namespace canorb::bench {
namespace {

// Any two identifiers do.
constexpr std::uint32_t to_receiver = 0x456;
constexpr std::uint32_t to_sender = 0x465;
constexpr std::size_t frame_octets = 8;

void put(std::vector<can::Frame>& frames, std::initializer_list<std::uint8_t> head, Bytes rest) {
    std::array<std::uint8_t, frame_octets> octets{};
    const auto end = std::copy(head.begin(), head.end(), octets.begin());
    std::copy(rest.begin(), rest.end(), end);
    frames.push_back(
        can::Frame::standard(to_receiver, Bytes{octets}.first(head.size() + rest.size())));
}

double milliseconds(std::uint32_t bits, double kilobits_per_second) {
    return bits / kilobits_per_second;
}

nlohmann::ordered_json times(std::uint32_t bits) {
    return {{"125k", milliseconds(bits, 125)},
            {"500k", milliseconds(bits, 500)},
            {"1M", milliseconds(bits, 1000)}};
}

}  // namespace

CanCost& CanCost::operator+=(const CanCost& other) {
    frames += other.frames;
    bits += other.bits;
    worst_bits += other.worst_bits;
    return *this;
}

nlohmann::ordered_json CanCost::json(bool known) const {
    nlohmann::ordered_json result{{"frames", frames}, {"worst_bits", worst_bits}};
    if (known) result["bits"] = bits;
    result["milliseconds"] = times(known ? bits : worst_bits);
    return result;
}

std::uint32_t worst_length(std::size_t octets, bool extended) {
    const std::size_t stuffed = (extended ? 54 : 34) + 8 * octets;
    return static_cast<std::uint32_t>(stuffed + 13 + (stuffed - 1) / 4);
}

CanCost cost_of(const can::Frame& frame) {
    return {1, can::frame_length(frame), worst_length(frame.length, frame.extended)};
}

CanCost cost_of(const std::vector<can::Frame>& frames) {
    CanCost sum;
    for (const can::Frame& frame : frames) sum += cost_of(frame);
    return sum;
}

std::vector<can::Frame> over_iso_tp(Bytes message) {
    constexpr std::size_t longest = 4095;
    if (message.size() > longest) throw std::invalid_argument{"too long for ISO-TP"};
    std::vector<can::Frame> frames;
    const auto length = static_cast<std::uint16_t>(message.size());
    if (message.size() < frame_octets) {
        put(frames, {static_cast<std::uint8_t>(length)}, message);
        return frames;
    }
    const auto high = static_cast<std::uint8_t>(0x10 | length >> 8);
    put(frames, {high, static_cast<std::uint8_t>(length & 0xFF)}, message.first(6));
    frames.push_back(
        can::Frame::standard(to_sender, std::array<std::uint8_t, 3>{0x30, 0x00, 0x00}));
    std::uint8_t number = 1;
    for (Bytes rest = message.subspan(6); !rest.empty();) {
        const std::size_t taken = std::min<std::size_t>(rest.size(), 7);
        put(frames, {static_cast<std::uint8_t>(0x20 | (number++ & 0x0F))}, rest.first(taken));
        rest = rest.subspan(taken);
    }
    return frames;
}

}  // namespace canorb::bench
