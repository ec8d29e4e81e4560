#pragma once

/// The TDMA round: twelve slots of equal length. Only a slot's owner transmits in it, so nobody
/// ever loses arbitration.

#include <canorb/types.hpp>
#include <chrono>
#include <cstdint>

namespace tank {

namespace slot {
inline constexpr int sync = 0;          ///< A
inline constexpr int level = 1;         ///< B
inline constexpr int inlet_state = 2;   ///< B
inline constexpr int outlet_state = 3;  ///< B
inline constexpr int control = 4;       ///< A calculates
inline constexpr int actuation = 5;     ///< A
inline constexpr int apply = 6;         ///< B opens and closes; A writes to the operator
inline constexpr int applied = 7;
inline constexpr int slot_duration = 10;  ///< A takes an order, and transmits
inline constexpr int guard = 11;          ///< B's timer stands still
}  // namespace slot

inline constexpr int slots_in_round = 12;
inline constexpr std::chrono::milliseconds default_slot_length{50};

/// A node without actuations for so many of its own rounds closes both valves.
inline constexpr int rounds_without_actuation_limit = 3;

/// Whether slots of this length leave room for everything that is sent in one, twice over. An
/// unknown bitrate (0) is taken for a sufficient one.
bool slot_fits(std::chrono::milliseconds slot_length, std::uint32_t bitrate);

/// A node that comes to a slot later than this after its begin must not transmit in it: so late,
/// and its frames could reach into the next one, or meet those of a node that is early.
canorb::Duration latest_start(canorb::Duration slot_length, std::uint32_t bitrate);

/// How long a message with one value, two frames, is on the bus at most.
canorb::Duration value_length(std::uint32_t bitrate);

/// Which slot it is. A new length takes effect with the next round.
class SlotClock {
  public:
    /// In the guard slot before the first round, which begins at `first_round`.
    SlotClock(canorb::TimePoint first_round, canorb::Duration slot_length)
        : start_(first_round - slot_length), length_(slot_length), next_length_(slot_length) {}

    int slot() const { return slot_; }
    canorb::TimePoint start() const { return start_; }
    canorb::TimePoint end() const { return start_ + length_; }
    canorb::Duration length() const { return length_; }
    /// The first is 1.
    std::uint64_t round() const { return round_; }

    canorb::Duration next_length() const { return next_length_; }
    void set_next_length(canorb::Duration length) { next_length_ = length; }

    /// On to the next slot, which may be that of a new round.
    void advance();
    /// A new round begins at `start`, whatever slot it was.
    void begin_round(canorb::TimePoint start);

  private:
    canorb::TimePoint start_;
    canorb::Duration length_;
    canorb::Duration next_length_;
    int slot_ = slot::guard;
    std::uint64_t round_ = 0;
};

}  // namespace tank
