// When a thread wakes that keeps a bus to the clock; the clock is the test's.

#include "orb/can/link/pacer.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "orb/can/sim/controller.hpp"
#include "orb/can/sim/fault_injector.hpp"

namespace canorb::can {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t bitrate = 1'000'000;

/// A thread that is always in time.
std::size_t wakes_until(sim::Bus& bus, Pacer& pacer, TimePoint end) {
    std::size_t wakes = 0;
    while (true) {
        const TimePoint next = pacer.wake_at(bus);
        if (next > end) break;
        bus.advance(next);
        ++wakes;
    }
    bus.advance(end);
    return wakes;
}

TEST(Pacer, SleepsWhileABusIsQuiet) {
    sim::Bus bus{bitrate};
    Pacer pacer;
    EXPECT_EQ(pacer.wake_at(bus), never);
    const sim::Controller lone{bus};
    EXPECT_EQ(pacer.wake_at(bus), never);
}

TEST(Pacer, WakesAtTheEndOfEachFrame) {
    sim::Bus bus{bitrate};
    sim::Controller sender{bus};
    const sim::Controller receiver{bus};
    Pacer pacer;
    std::vector<TimePoint> ends;
    bus.set_trace([&](const sim::CompletedFrame& frame) { ends.push_back(frame.time); });
    for (int i = 0; i < 8; ++i) {
        ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender.send(Frame::standard(1, {}))));
    }
    for (std::size_t frame = 0; frame < 8; ++frame) {
        const TimePoint next = pacer.wake_at(bus);
        bus.advance(next);
        ASSERT_EQ(ends.size(), frame + 1);
        EXPECT_EQ(ends.back(), next);
    }
}

// Others act on the bus in the middle of frames.
TEST(Pacer, IsAsSharpWhenSomebodyElseMovesTheBus) {
    sim::Bus bus{bitrate};
    sim::Controller sender{bus};
    const sim::Controller receiver{bus};
    Pacer pacer;
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender.send(Frame::standard(1, {}))));
    const TimePoint end = pacer.wake_at(bus);
    for (TimePoint now = bus.now(); now < end; now += 1us) {
        bus.advance(now);
        EXPECT_EQ(pacer.wake_at(bus), end);
    }
}

TEST(Pacer, DoesNotWakeForEachBitOfAStuckBus) {
    sim::Bus bus{bitrate};
    sim::FaultInjector injector{*sim::parse_fault_script("at 1ms stuck-dominant wire for 1s"),
                                bitrate};
    bus.set_disturbance(&injector);
    sim::Controller sender{bus};
    const sim::Controller receiver{bus};
    Pacer pacer;
    wakes_until(bus, pacer, TimePoint{2ms});
    EXPECT_LE(wakes_until(bus, pacer, TimePoint{12ms}), 165U);  // 10 000 bits

    // When it is over, frames are told sharply again, after the first.
    wakes_until(bus, pacer, TimePoint{1100ms});
    std::vector<TimePoint> ends;
    bus.set_trace([&](const sim::CompletedFrame& frame) { ends.push_back(frame.time); });
    for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender.send(Frame::standard(1, {}))));
    }
    std::vector<Duration> delays;
    while (ends.size() < 3) {
        const std::size_t before = ends.size();
        bus.advance(pacer.wake_at(bus));
        if (ends.size() > before) delays.push_back(bus.now() - ends.back());
    }
    ASSERT_EQ(delays.size(), 3U);
    EXPECT_LE(delays[0], 100us);
    EXPECT_EQ(delays[1], 0us);
    EXPECT_EQ(delays[2], 0us);
}

constexpr TimePoint at_once = TimePoint::min();  // a deadline that is over after the first step

TEST(PacedClock, MovesABusToThePresent) {
    sim::Bus bus{bitrate};
    PacedClock clock;
    EXPECT_TRUE(clock.advance(bus, TimePoint{100us}, at_once));
    EXPECT_EQ(bus.now(), TimePoint{100us});
    EXPECT_TRUE(clock.advance(bus, TimePoint{50us}, at_once));
    EXPECT_EQ(bus.now(), TimePoint{100us}) << "never back";
    // Where nothing happens there are no steps.
    EXPECT_TRUE(clock.advance(bus, TimePoint{1h}, at_once));
    EXPECT_EQ(bus.now(), TimePoint{1h});
    EXPECT_FALSE(clock.slip(bus, TimePoint{1h}));
    EXPECT_EQ(clock.slipped(), 0ns);
    EXPECT_EQ(clock.machine_time(never), never);
}

TEST(PacedClock, GivesUpAtItsDeadlineAndSlips) {
    sim::Bus bus{bitrate};
    sim::FaultInjector injector{*sim::parse_fault_script("at 0s stuck-dominant wire"), bitrate};
    bus.set_disturbance(&injector);
    const sim::Controller node{bus};
    PacedClock clock;
    EXPECT_FALSE(clock.advance(bus, TimePoint{1s}, at_once));
    EXPECT_EQ(bus.now(), TimePoint{200us});
    EXPECT_FALSE(clock.slip(bus, TimePoint{1s + 200us})) << "a second may be caught up with";
    EXPECT_TRUE(clock.slip(bus, TimePoint{1s + 201us}));
    EXPECT_EQ(clock.slipped(), 1s + 1us);
    EXPECT_EQ(clock.machine_time(bus.now()), TimePoint{1s + 201us});
    EXPECT_EQ(bus.now(), TimePoint{200us}) << "nothing is left out";
    // On from there, on the machine's clock.
    EXPECT_TRUE(clock.advance(bus, TimePoint{1s + 301us}, at_once));
    EXPECT_EQ(bus.now(), TimePoint{300us});
    const ControllerEvent event = StateChanged{{}, bus.now()};
    EXPECT_EQ(std::get<StateChanged>(clock.machine_time(event)).time, TimePoint{1s + 301us});
}

}  // namespace
}  // namespace canorb::can
