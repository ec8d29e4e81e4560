// Worker threads, event_fd(), and waiting for servants' calls to end: on the machine's clock.
// Nothing here sleeps: threads wait for each other.

#include <poll.h>

#include <atomic>
#include <condition_variable>
#include <latch>
#include <mutex>
#include <set>
#include <thread>

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

class Workers : public testing::Test {
  protected:
    OrbOptions options(int number, std::size_t workers = 0) {
        OrbOptions result;
        result.node = number;
        result.default_timeout = 20s;
        result.inter_frame_timeout = 10s;  // threads may be kept waiting on a busy machine
        result.worker_threads = workers;
        result.log = [](std::string_view) {};
        return result;
    }
    static ObjectRef object(Orb& orb, int index, int number = 1) {
        return orb.string_to_object("corbaloc:caniop:" + std::to_string(number) + "/" +
                                    std::to_string(index));
    }

    std::unique_ptr<Bus> bus = open_bus(
        std::string{"local:"} + testing::UnitTest::GetInstance()->current_test_info()->name() +
        "?bitrate=1000000");
};

TEST_F(Workers, ServeSoManyCallsAtATime) {
    std::latch all_inside{3};
    std::mutex mutex;
    std::set<std::thread::id> threads;
    TestServant meeting{{{0, [&](ServerCall& call) {
                              {
                                  const std::lock_guard lock{mutex};
                                  threads.insert(std::this_thread::get_id());
                              }
                              all_inside.arrive_and_wait();  // for ever, were one served at a time
                              nothing(call);
                          }}}};
    Orb server{*bus, options(1, 3)};
    server.root_poa().activate_object_with_id(1, meeting);
    Orb client{*bus, options(2)};
    std::vector<std::thread> callers;
    for (int i = 0; i < 3; ++i) {
        callers.emplace_back([&] { object(client, 1).invoke(0, {}); });
    }
    for (std::thread& caller : callers) caller.join();
    EXPECT_EQ(threads.size(), 3U);
    EXPECT_EQ(threads.count(std::this_thread::get_id()), 0U);
}

TEST_F(Workers, NeverMoreThanThereAre) {
    std::atomic<int> inside = 0;
    std::atomic<int> most = 0;
    TestServant counter{{{0, [&](ServerCall& call) {
                              const int now = ++inside;
                              int seen = most;
                              while (now > seen && !most.compare_exchange_weak(seen, now)) {
                              }
                              std::this_thread::yield();
                              --inside;
                              nothing(call);
                          }}}};
    Orb server{*bus, options(1, 2)};
    server.root_poa().activate_object_with_id(1, counter);
    std::thread also_runs{[&] { server.run(); }};
    Orb client{*bus, options(2)};
    std::vector<std::thread> callers;
    for (int i = 0; i < 6; ++i) {
        callers.emplace_back([&] {
            for (int n = 0; n < 20; ++n) object(client, 1).invoke(0, {});
        });
    }
    for (std::thread& caller : callers) caller.join();
    server.shutdown();
    also_runs.join();
    EXPECT_EQ(counter.calls, 120);
    EXPECT_LE(most, 2);
}

TEST_F(Workers, NestedCallsDoNotBlockEachOther) {
    // Two clients, each called back by the servant that it waits for.
    Orb server{*bus, options(1, 2)};
    TestServant relay{{{1, [&](ServerCall& call) {
                            std::uint8_t back{};
                            if (!call.read(back)) return;
                            call.reply(RawOctets{object(server, 1, back).invoke(1, {{back}})});
                        }}}};
    server.root_poa().activate_object_with_id(1, relay);
    TestServant listener{{{1, echo}}};
    std::vector<std::thread> callers;
    std::atomic<int> right = 0;
    for (const int number : {2, 3, 4}) {
        callers.emplace_back([&, number] {
            Orb client{*bus, options(number)};
            TestServant own{{{1, echo}}};
            client.root_poa().activate_object_with_id(1, own);
            const std::vector<std::uint8_t> octets{static_cast<std::uint8_t>(number)};
            for (int i = 0; i < 20; ++i) {
                if (object(client, 1).invoke(1, octets) == octets) ++right;
            }
        });
    }
    for (std::thread& caller : callers) caller.join();
    EXPECT_EQ(right, 60);
}

TEST_F(Workers, CallbacksRunOneAtATime) {
    std::atomic<int> inside = 0;
    std::atomic<bool> overlapped = false;
    std::atomic<int> runs = 0;
    std::latch enough{1};
    const auto callback = [&] {
        if (++inside > 1) overlapped = true;
        std::this_thread::yield();
        --inside;
        if (++runs == 50) enough.count_down();
    };
    Orb orb{*bus, options(1, 4)};  // its workers call back until it is gone
    orb.every(100us, callback);
    orb.every(130us, callback);
    enough.wait();
    EXPECT_FALSE(overlapped);
}

TEST_F(Workers, EndWithShutdownAndWithTheOrb) {
    TestServant lamp{{{0, nothing}}};
    {
        Orb unused{*bus, options(1, 4)};
        unused.root_poa().activate_object_with_id(1, lamp);
    }
    Orb server{*bus, options(1, 4)};
    server.root_poa().activate_object_with_id(1, lamp);
    Orb client{*bus, options(2)};
    object(client, 1).invoke(0, {});
    server.shutdown();
    EXPECT_EQ(error_of([&] { object(client, 1).with_timeout(50ms).invoke(0, {}); }).kind,
              SystemErrorKind::timeout);
    EXPECT_EQ(lamp.calls, 1);
}

/// A servant whose call lasts until it is let go.
class Slow {
  public:
    TestServant servant{{{0, [this](ServerCall& call) {
                              inside.count_down();
                              go.wait();
                              done = true;
                              nothing(call);
                          }}}};
    std::latch inside{1};
    std::latch go{1};
    std::atomic<bool> done = false;
};

TEST_F(Workers, DeactivatedObjectsFinishTheirCalls) {
    Slow slow;
    Orb server{*bus, options(1, 1)};
    server.root_poa().activate_object_with_id(1, slow.servant);
    Orb client{*bus, options(2)};
    std::thread caller{[&] { object(client, 1).invoke(0, {}); }};
    slow.inside.wait();
    server.root_poa().deactivate_object(1);  // does not wait
    EXPECT_FALSE(slow.done);
    slow.go.count_down();
    caller.join();  // and the caller has its answer
    EXPECT_TRUE(slow.done);
}

TEST_F(Workers, WaitForCompletion) {
    Slow in_object;
    Slow in_poa;
    Slow in_manager;
    Orb server{*bus, options(1, 3)};
    Poa& poa = server.root_poa().create_POA("poa", &server.root_poa().the_POAManager(), {});
    Poa& managed = server.root_poa().create_POA("managed", nullptr, {});
    managed.the_POAManager().activate();
    server.root_poa().activate_object_with_id(1, in_object.servant);
    const int index = *poa.activate_object(in_poa.servant).index();
    const int managed_index = *managed.activate_object(in_manager.servant).index();
    Orb client{*bus, options(2)};
    std::vector<std::thread> callers;
    for (const int at : {1, index, managed_index}) {
        callers.emplace_back([&client, at] { object(client, at).invoke(0, {}); });
    }
    for (Slow* slow : {&in_object, &in_poa, &in_manager}) slow->inside.wait();
    std::vector<std::thread> openers;
    for (Slow* slow : {&in_object, &in_poa, &in_manager}) {
        openers.emplace_back([slow] { slow->go.count_down(); });
    }
    server.root_poa().deactivate_object(1, true);
    EXPECT_TRUE(in_object.done);
    poa.destroy(true);
    EXPECT_TRUE(in_poa.done);
    managed.the_POAManager().discard_requests(true);
    EXPECT_TRUE(in_manager.done);
    for (std::thread& thread : openers) thread.join();
    for (std::thread& thread : callers) thread.join();
}

TEST_F(Workers, DrainWaitsForTheServant) {
    Slow slow;
    Orb server{*bus, options(1, 1)};
    server.root_poa().activate_object_with_id(1, slow.servant);
    Orb client{*bus, options(2)};
    std::thread caller{[&] { object(client, 1).invoke(0, {}); }};
    slow.inside.wait();
    EXPECT_FALSE(server.drain(1ms));
    slow.go.count_down();
    EXPECT_TRUE(server.drain(20s));
    EXPECT_TRUE(slow.done);
    caller.join();
}

// ---- in somebody else's event loop

/// Waits for the descriptors as a program of its own would, without any thread of the ORB's.
bool wait_for(int fd, Duration limit) {
    pollfd source{fd, POLLIN, 0};
    return ::poll(&source, 1,
                  static_cast<int>(
                      std::chrono::duration_cast<std::chrono::milliseconds>(limit).count())) == 1;
}

TEST_F(Workers, ADescriptorTellsWhenToPoll) {
    TestServant lamp{{{0, nothing}}};
    Orb server{*bus, options(1)};
    server.root_poa().activate_object_with_id(1, lamp);
    const int fd = server.event_fd();
    EXPECT_EQ(server.event_fd(), fd);
    std::atomic<bool> stop = false;
    std::thread loop{[&] {
        while (!stop) {
            if (wait_for(fd, 20s)) server.poll();
        }
    }};
    Orb client{*bus, options(2)};
    for (int i = 0; i < 50; ++i) object(client, 1).invoke(0, {});
    // What another thread begins wakes the loop, too.
    call_through(object(server, 1), ring_oneway);
    std::latch timer{1};
    server.at(server.now() + 1ms, [&] { timer.count_down(); });
    timer.wait();
    server.at(server.now(), [&] { stop = true; });
    loop.join();
    EXPECT_EQ(lamp.calls, 51);
}

TEST_F(Workers, TheDescriptorIsQuietWhenThereIsNothingToDo) {
    Orb orb{*bus, options(1)};
    const int fd = orb.event_fd();
    EXPECT_TRUE(wait_for(fd, 0s));  // what there was before it was asked for
    orb.poll();
    // The links may tell once more that they are up.
    for (int i = 0; i < 3 && wait_for(fd, 0s); ++i) orb.poll();
    EXPECT_FALSE(wait_for(fd, 0s));
    int ticks = 0;
    orb.every(1ms, [&] { ++ticks; });
    int polls = 0;
    while (ticks < 20) {
        ASSERT_TRUE(wait_for(fd, 20s));
        orb.poll();
        ++polls;
    }
    EXPECT_LT(polls, 100);  // it does not spin
}

TEST_F(Workers, AreAtMost256) {
    EXPECT_EQ(what<BAD_PARAM>([&] { Orb{*bus, options(1, 257)}; }),
              "BAD_PARAM (completed NO, minor 24): an option is out of range: worker_threads 257 "
              "is more than 256");
}

}  // namespace
}  // namespace canorb::test
