#include "round.hpp"

#include <gtest/gtest.h>

namespace tank {
namespace {

using namespace std::chrono_literals;
using canorb::TimePoint;

TEST(SlotClock, begins_with_the_guard_slot_before_the_first_round) {
    SlotClock clock{TimePoint{1s}, 50ms};
    EXPECT_EQ(clock.slot(), 11);
    EXPECT_EQ(clock.end(), TimePoint{1s});
    EXPECT_EQ(clock.round(), 0U);
    clock.advance();
    EXPECT_EQ(clock.slot(), 0);
    EXPECT_EQ(clock.start(), TimePoint{1s});
    EXPECT_EQ(clock.end(), TimePoint{1050ms});
    EXPECT_EQ(clock.round(), 1U);
}

TEST(SlotClock, counts_twelve_slots) {
    SlotClock clock{TimePoint{}, 50ms};
    clock.advance();
    for (int slot = 0; slot < 12; ++slot) {
        EXPECT_EQ(clock.slot(), slot);
        EXPECT_EQ(clock.start(), TimePoint{slot * 50ms});
        clock.advance();
    }
    EXPECT_EQ(clock.slot(), 0);
    EXPECT_EQ(clock.start(), TimePoint{600ms});
    EXPECT_EQ(clock.round(), 2U);
}

TEST(SlotClock, changes_the_length_with_the_round) {
    SlotClock clock{TimePoint{}, 50ms};
    for (int i = 0; i < 11; ++i) clock.advance();
    ASSERT_EQ(clock.slot(), 10);
    clock.set_next_length(5ms);
    clock.advance();
    EXPECT_EQ(clock.slot(), 11);
    EXPECT_EQ(clock.length(), 50ms);
    clock.advance();
    EXPECT_EQ(clock.start(), TimePoint{600ms});
    EXPECT_EQ(clock.end(), TimePoint{605ms});
    EXPECT_EQ(clock.next_length(), 5ms);
}

TEST(SlotClock, begins_a_round_whenever_told) {
    SlotClock clock{TimePoint{}, 50ms};
    for (int i = 0; i < 4; ++i) clock.advance();
    clock.set_next_length(10ms);
    clock.begin_round(TimePoint{170ms});
    EXPECT_EQ(clock.slot(), 0);
    EXPECT_EQ(clock.end(), TimePoint{180ms});
    EXPECT_EQ(clock.round(), 2U);
}

TEST(SlotLength, needs_room_on_the_bus) {
    EXPECT_TRUE(slot_fits(5ms, 1'000'000));
    EXPECT_TRUE(slot_fits(5ms, 250'000));
    EXPECT_FALSE(slot_fits(5ms, 249'999));
    EXPECT_FALSE(slot_fits(5ms, 125'000));
    EXPECT_TRUE(slot_fits(10ms, 125'000));
    EXPECT_TRUE(slot_fits(5ms, 0));
}

TEST(LatestStart, leaves_time_to_transmit) {
    // 675 bits at 500 kbit/s are 1.35 ms; the rest is halved.
    EXPECT_EQ(latest_start(5ms, 500'000), 1825us);
    EXPECT_EQ(latest_start(50ms, 500'000), 24325us);
    EXPECT_EQ(latest_start(5ms, 250'000), 1150us);
    // Two frames of 135 bits.
    EXPECT_EQ(value_length(500'000), 540us);
    // Sync and node B both late, sync's frame and a value of B: still within the slot.
    for (const auto bitrate : {250'000U, 500'000U, 1'000'000U})
        EXPECT_LT(2 * latest_start(5ms, bitrate) + value_length(bitrate) * 3 / 2, 5ms);
}

}  // namespace
}  // namespace tank
