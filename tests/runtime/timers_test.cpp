// Timers, with_sent, and the order of things that happen at the same time.

#include "orb/runtime/timers.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Clockwork : public World {
  protected:
    Orb a{bus, node(1)};
    Orb b{bus, node(2)};
};

TEST_F(Clockwork, AtAndEveryKeepToTheirTimes) {
    std::vector<Duration> once;
    std::vector<Duration> often;
    const auto note = [&](std::vector<Duration>& times) {
        return [&] { times.push_back(simulation.now().time_since_epoch()); };
    };
    simulation.run_for(5ms);
    a.at(TimePoint{7ms}, note(once));
    a.at(TimePoint{1ms}, note(once));  // has passed: at once
    a.every(10ms, note(often));
    simulation.run_until(TimePoint{35ms});
    EXPECT_EQ(once, (std::vector<Duration>{5ms, 7ms}));
    EXPECT_EQ(often, (std::vector<Duration>{15ms, 25ms, 35ms}));
    EXPECT_THROW(a.every(0ms, [] {}), BAD_PARAM);
    EXPECT_THROW(a.every(-1ms, [] {}), BAD_PARAM);
}

TEST_F(Clockwork, CancelledTimersRunNoMore) {
    int runs = 0;
    const TimerId never_runs = a.at(TimePoint{5ms}, [&] { ++runs; });
    TimerId timer{};
    timer = a.every(10ms, [&] {
        if (++runs == 3) a.cancel(timer);  // itself
    });
    a.cancel(never_runs);
    a.cancel(never_runs);
    simulation.run_for(1s);
    EXPECT_EQ(runs, 3);
}

TEST_F(Clockwork, WhatACallbackHoldsMayCallTheOrbWhenItGoes) {
    struct Owner {
        ~Owner() { orb.cancel(other); }
        Orb& orb;
        TimerId other;
    };
    bool ran = false;
    const TimerId other = a.every(10ms, [&] { ran = true; });
    const TimerId timer = a.every(1ms, [owner = std::make_shared<Owner>(a, other)] {});
    a.cancel(timer);
    a.at(TimePoint{1ms}, [owner = std::make_shared<Owner>(a, other)] {});
    a.on_event([owner = std::make_shared<Owner>(a, other)](const Event&) {});
    a.on_event(nullptr);
    simulation.run_for(20ms);
    EXPECT_FALSE(ran);
}

TEST_F(Clockwork, CallbackThatThrowsIsAnEvent) {
    std::vector<Event> events;
    a.on_event([&](const Event& event) { events.push_back(event); });
    a.every(10ms, [] { throw std::runtime_error{"a bug"}; });
    b.root_poa();
    simulation.run_for(25ms);
    ASSERT_EQ(events.size(), 2U);
    EXPECT_EQ(events[0].kind, Event::Kind::servant_exception);
    EXPECT_EQ(events[0].time, TimePoint{10ms});
    EXPECT_EQ(events[0].text, "node-1: a timer raised a bug");
    EXPECT_EQ(log.size(), 2U);
}

TEST_F(Clockwork, TimersCanMakeCalls) {
    TestServant servant{{{0, nothing}}};
    b.root_poa().activate_object_with_id(1, servant);
    a.every(10ms, [&] { at(a, 2, 1).invoke(0, {}); });
    simulation.run_for(100ms);
    EXPECT_EQ(servant.calls, 9 + 1);
}

TEST_F(Clockwork, EqualTimesHaveAnOrder) {
    TestServant servant{{{0, nothing}}};
    b.root_poa().activate_object_with_id(1, servant);
    // The end of this frame, in a world that is the same.
    TimePoint end;
    {
        Simulation twin;
        SimulatedBus& twin_bus = twin.add_bus();
        Orb twin_a{twin_bus, node(1)};
        Orb twin_b{twin_bus, node(2)};
        twin_bus.on_frame([&](const can::Frame&, TimePoint time) {
            if (end == TimePoint{}) end = time;
        });
        call_through(at(twin_a, 2, 7), ring_oneway);
        twin.run_for(1ms);
    }
    std::vector<std::string> order;
    const auto note = [&order](std::string name) {
        return [&order, name] { order.push_back(name); };
    };
    TestServant witness{{{0, [&](ServerCall&) { order.emplace_back("frame"); }}}};
    b.root_poa().activate_object_with_id(7, witness);
    b.at(end, note("timer of b"));
    a.at(end, note("timer of a"));
    a.at(end, note("second timer of a"));
    simulation.at(end, note("simulation"));
    call_through(at(a, 2, 7), ring_oneway);
    simulation.run_for(1ms);
    EXPECT_EQ(order, (std::vector<std::string>{"simulation", "frame", "timer of a",
                                               "second timer of a", "timer of b"}));
}

TEST(Timers, SkipWhatCouldNotRunInItsWholePeriod) {
    runtime::Timers timers;
    timers.add(TimePoint{10ms}, 10ms, [] {});
    EXPECT_EQ(timers.take_due(TimePoint{9ms}), nullptr);
    EXPECT_NE(timers.take_due(TimePoint{10ms}), nullptr);
    EXPECT_EQ(timers.next(), TimePoint{20ms});
    EXPECT_NE(timers.take_due(TimePoint{47ms}), nullptr);
    EXPECT_EQ(timers.take_due(TimePoint{47ms}), nullptr);
    EXPECT_EQ(timers.next(), TimePoint{50ms});
    EXPECT_NE(timers.take_due(TimePoint{60ms}), nullptr);
    EXPECT_EQ(timers.next(), TimePoint{70ms});
}

class Sent : public Clockwork {
  protected:
    Sent() { b.root_poa().activate_object_with_id(1, servant); }
    auto note() {
        return [this] { times.push_back(simulation.now()); };
    }

    TestServant servant{{
        {0, nothing},
        {1, echo},
        {2, [](ServerCall& call) { call.oneway(); }},
    }};
    std::vector<TimePoint> times;
};

TEST_F(Sent, ComesAtTheEndOfTheLastFrame) {
    at(a, 2, 1).with_sent(note()).invoke(0, {});
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_EQ(times, std::vector<TimePoint>{seen[0].end});

    times.clear();
    seen.clear();
    const std::vector<std::uint8_t> octets(20);  // 28 octets of message: 4 frames
    at(a, 2, 1).with_sent(note()).invoke(1, octets);
    ASSERT_GE(seen.size(), 5U);
    EXPECT_EQ(times, std::vector<TimePoint>{seen[3].end});
}

TEST_F(Sent, OfOnewaysAndGroups) {
    constexpr OperationInfo oneway{&lamp_interface, 2, "oneway", true, true};
    call_through(at(a, 2, 1).with_sent(note()), oneway);
    call_through(group(a, 4).with_sent(note()), ring);
    EXPECT_TRUE(times.empty());
    simulation.run_for(10ms);
    EXPECT_EQ(servant.calls, 1);
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_EQ(times, (std::vector<TimePoint>{seen[0].end, seen[1].end}));
}

TEST_F(Sent, OnTheOwnNodeIsAtOnce) {
    at(b, 2, 1).with_sent(note()).invoke(0, {});
    EXPECT_EQ(times.size(), 1U);
    EXPECT_TRUE(seen.empty());
}

TEST_F(Sent, MayCall) {
    int rung = 0;
    const auto again = [&] {
        if (++rung < 5) at(a, 2, 1).invoke(0, {});
    };
    at(a, 2, 1).with_sent(again).invoke(0, {});
    EXPECT_EQ(rung, 1);
    EXPECT_EQ(servant.calls, 2);
}

}  // namespace
}  // namespace canorb::test
