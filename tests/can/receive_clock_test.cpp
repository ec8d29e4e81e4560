#include "orb/can/link/receive_clock.hpp"

#include <gtest/gtest.h>

namespace canorb::can {
namespace {

using namespace std::chrono_literals;

constexpr Duration epoch = 1'790'000'000s;     // the time of day when our clock was 0
constexpr Duration hardware_epoch = 12'345us;  // and what an interface's clock showed then

ReceiveClock::Present at(Duration time) {
    return {TimePoint{time}, epoch + time};
}

TEST(ReceiveClock, WithoutStampsItIsThePresent) {
    ReceiveClock clock;
    EXPECT_EQ(clock.time_of({}, {}, at(10s)), TimePoint{10s});
}

TEST(ReceiveClock, TheKernelsStampIsBroughtToOurClock) {
    ReceiveClock clock;
    EXPECT_EQ(clock.time_of(epoch + 9s + 3us, {}, at(10s)), TimePoint{9s + 3us});
}

TEST(ReceiveClock, TheTimeOfDayMayBeSet) {
    ReceiveClock clock;
    EXPECT_EQ(clock.time_of(epoch + 9s, {}, at(9s)), TimePoint{9s});
    // Back by an hour between the stamp and the reading: the stamp seems to be in the future.
    EXPECT_EQ(clock.time_of(epoch + 10s, {}, {TimePoint{11s}, epoch + 11s - 1h}), TimePoint{11s});
    // Forward: it seems to be an hour old, but not older than the frame before it.
    EXPECT_EQ(clock.time_of(epoch + 12s, {}, {TimePoint{13s}, epoch + 13s + 1h}), TimePoint{11s});
    EXPECT_EQ(clock.time_of(epoch + 14s, {}, at(14s)), TimePoint{14s}) << "and all is well again";
}

TEST(ReceiveClock, TheHardwaresStampsKeepTheirDistance) {
    ReceiveClock clock;
    // The first frame waited 50 us for the kernel; the second only 10 us, which shows the offset.
    EXPECT_EQ(clock.time_of(epoch + 1s + 50us, hardware_epoch + 1s, at(1s + 60us)),
              TimePoint{1s + 50us});
    EXPECT_EQ(clock.time_of(epoch + 1s + 510us, hardware_epoch + 1s + 500us, at(1s + 520us)),
              TimePoint{1s + 510us});
    // From then on 10 us is added to each, however late the kernel is.
    const TimePoint late =
        clock.time_of(epoch + 1s + 900us, hardware_epoch + 1s + 600us, at(1s + 950us));
    EXPECT_GE(late, TimePoint{1s + 610us});
    EXPECT_LE(late, TimePoint{1s + 611us});
}

TEST(ReceiveClock, FollowsAnInterfaceWhoseClockIsSlow) {
    ReceiveClock clock;
    // 100 parts per million: 360 ms in an hour.
    for (std::int64_t second = 1; second < 3600; ++second) {
        const Duration now = std::chrono::seconds{second};
        const Duration hardware = hardware_epoch + now - now / 10'000;
        const TimePoint time = clock.time_of(epoch + now, hardware, at(now));
        ASSERT_LE(time, TimePoint{now}) << second;
        ASSERT_GE(time, TimePoint{now - 1ms}) << second;
    }
}

TEST(ReceiveClock, StartsAnewWithAnInterfaceThatDoes) {
    ReceiveClock clock;
    EXPECT_EQ(clock.time_of(epoch + 5s, 5s, at(5s)), TimePoint{5s});
    EXPECT_EQ(clock.time_of(epoch + 9s, 1ms, at(9s)), TimePoint{9s});
    EXPECT_EQ(clock.time_of(epoch + 9s + 1ms, 2ms, at(9s + 1ms)), TimePoint{9s + 1ms});
}

TEST(ReceiveClock, NeverRunsAhead) {
    ReceiveClock clock;
    EXPECT_EQ(clock.time_of(epoch + 5s, 5s, at(5s)), TimePoint{5s});
    // The interface's clock is a little fast.
    EXPECT_LE(clock.time_of(epoch + 6s, 6s + 1ms, at(6s)), TimePoint{6s});
}

}  // namespace
}  // namespace canorb::can
