#include "round.hpp"

namespace tank {

namespace {

// A standard data frame with 8 octets, all stuff bits and the intermission.
constexpr std::int64_t longest_frame_bits = 135;
// Slot 5, the fullest: six frames of at most 640 bits in all.
constexpr std::int64_t longest_slot_bits = 5 * longest_frame_bits;

canorb::Duration time_on_bus(std::int64_t bits, std::uint32_t bitrate) {
    const std::int64_t bits_per_second = bitrate == 0 ? 500'000 : bitrate;
    return canorb::Duration{bits * 1'000'000'000 / bits_per_second};
}

}  // namespace

bool slot_fits(std::chrono::milliseconds slot_length, std::uint32_t bitrate) {
    constexpr std::int64_t bits_wanted = 1250;
    return bitrate == 0 || slot_length.count() * bitrate >= bits_wanted * 1000;
}

canorb::Duration latest_start(canorb::Duration slot_length, std::uint32_t bitrate) {
    // Half of what transmission leaves, because the two nodes' delays can add up.
    return (slot_length - time_on_bus(longest_slot_bits, bitrate)) / 2;
}

canorb::Duration value_length(std::uint32_t bitrate) {
    return time_on_bus(2 * longest_frame_bits, bitrate);
}

void SlotClock::advance() {
    if (slot_ == slot::guard) {
        begin_round(end());
    } else {
        start_ += length_;
        ++slot_;
    }
}

void SlotClock::begin_round(canorb::TimePoint start) {
    start_ = start;
    length_ = next_length_;
    slot_ = slot::sync;
    ++round_;
}

}  // namespace tank
