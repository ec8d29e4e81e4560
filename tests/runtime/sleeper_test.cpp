#include "orb/runtime/sleeper.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <string>
#include <thread>

#include "canorb/orb.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

using runtime::Sleeper;

constexpr Duration for_ever = Duration::max();

// A test that hangs fails: none of these sleeps ends by itself.

TEST(Sleeper, WokenBeforehandItDoesNotSleep) {
    Sleeper sleeper;
    sleeper.wake();
    sleeper.wake();
    sleeper.sleep(for_ever);
    sleeper.wake();
    const can::Signal never_raised;
    EXPECT_FALSE(sleeper.sleep_for(never_raised.fd(), for_ever));
}

TEST(Sleeper, SleepsUntilItsTimeAndAWakeIsUsedUp) {
    Sleeper sleeper;
    const can::Signal never_raised;
    sleeper.wake();
    sleeper.sleep(for_ever);
    sleeper.sleep(1ms);
    EXPECT_FALSE(sleeper.sleep_for(never_raised.fd(), 1ms));
    sleeper.sleep(Duration::zero());
    sleeper.sleep(-1s);
}

TEST(Sleeper, EndsWhenTheDescriptorIsReadable) {
    Sleeper sleeper;
    const can::Signal signal;
    signal.raise();
    EXPECT_TRUE(sleeper.sleep_for(signal.fd(), for_ever));
    EXPECT_TRUE(sleeper.sleep_for(signal.fd(), for_ever));
}

TEST(Sleeper, AnyThreadWakesIt) {
    Sleeper sleeper;
    const can::Signal never_raised;
    std::atomic<int> slept = 0;
    std::thread other{[&] {
        for (int i = 0; i < 2'000; ++i) {
            while (slept < i) std::this_thread::yield();
            sleeper.wake();
        }
    }};
    // Each wake ends one sleep, whether it comes before or during it.
    for (int i = 0; i < 2'000; ++i) {
        if (i % 2 == 0) {
            sleeper.sleep(for_ever);
        } else {
            EXPECT_FALSE(sleeper.sleep_for(never_raised.fd(), for_ever));
        }
        ++slept;
    }
    other.join();
}

// Two Orbs on a bus without a pace, where nothing but what they wake each other with tells them.
TEST(LocalCalls, WithoutAPaceBothWaysAtOnce) {
    const auto bus = open_bus("local:calls?paced=no");
    TestServant here{{{0, nothing}}};
    TestServant there{{{0, nothing}}};
    Orb first{*bus, {.node = 1}};
    Orb second{*bus, {.node = 2}};
    first.root_poa().activate_object_with_id(1, here);
    second.root_poa().activate_object_with_id(1, there);
    const auto call = [](Orb& orb, int node) {
        const ObjectRef target =
            orb.string_to_object("corbaloc:caniop:" + std::to_string(node) + "/1");
        for (int i = 0; i < 500; ++i) target.with_timeout(20s).invoke(0, {});
    };
    std::atomic<int> calling = 2;
    const auto run = [&](Orb& orb, int peer) {
        call(orb, peer);
        --calling;
        while (calling > 0) orb.run_for(1ms);
    };
    std::thread other{[&] { run(second, 1); }};
    run(first, 2);
    other.join();
    EXPECT_EQ(here.calls, 500);
    EXPECT_EQ(there.calls, 500);
}

// By somebody else's loop: its descriptor is readable although the bus wakes without one.
TEST(LocalCalls, WithoutAPaceThroughADescriptor) {
    const auto bus = open_bus("local:watched?paced=no");
    TestServant servant{{{0, nothing}}};
    Orb server{*bus, {.node = 1}};
    server.root_poa().activate_object_with_id(1, servant);
    const int fd = server.event_fd();
    std::atomic<bool> done = false;
    std::thread loop{[&] {
        while (!done) {
            pollfd source{fd, POLLIN, 0};
            if (::poll(&source, 1, 10) > 0) server.poll();
        }
    }};
    Orb client{*bus, {.node = 2}};
    const ObjectRef target = client.string_to_object("corbaloc:caniop:1/1");
    for (int i = 0; i < 500; ++i) target.with_timeout(20s).invoke(0, {});
    done = true;
    loop.join();
    EXPECT_EQ(servant.calls, 500);
}

}  // namespace
}  // namespace canorb::test
