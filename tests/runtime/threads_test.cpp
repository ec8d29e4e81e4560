// The Orb on the machine's clock, with real threads. Nothing here sleeps: threads wait for each
// other, and deadlines are long where they must not pass.

#include <atomic>
#include <future>
#include <thread>

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

OrbOptions quiet(int number) {
    OrbOptions options;
    options.node = number;
    options.default_timeout = 20s;
    options.inter_frame_timeout = 10s;  // threads may be kept waiting on a busy machine
    options.log = [](std::string_view) {};
    return options;
}

ObjectRef object(Orb& orb, int number) {
    return orb.string_to_object("corbaloc:caniop:" + std::to_string(number) + "/1");
}

/// A bus of its own for each test, and a server whose event loop has a thread.
class Threads : public testing::Test {
  protected:
    ~Threads() override { end(); }

    void serve() {
        server.root_poa().activate_object_with_id(1, servant);
        thread = std::thread{[this] { server.run(); }};
    }
    void end() {
        server.shutdown();
        if (thread.joinable()) thread.join();
    }

    std::unique_ptr<Bus> bus = open_bus(
        std::string{"local:"} + testing::UnitTest::GetInstance()->current_test_info()->name() +
        "?bitrate=1000000");
    TestServant servant{{{0, nothing}, {1, echo}}};
    Orb server{*bus, quiet(1)};
    std::thread thread;
};

/// Many calls from many threads; each answer must be the caller's own.
void call_from_many_threads(Orb& client) {
    constexpr int thread_count = 8;
    constexpr int calls = 25;
    std::vector<std::thread> threads;
    std::atomic<int> right = 0;
    for (int t = 0; t < thread_count; ++t) {
        threads.emplace_back([&, t] {
            const ObjectRef target = object(client, 1);
            for (int i = 0; i < calls; ++i) {
                std::vector<std::uint8_t> octets(static_cast<std::size_t>(i % 12));
                for (auto& octet : octets) octet = static_cast<std::uint8_t>(t * 30 + i);
                if (target.invoke(1, octets) == octets) ++right;
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(right, thread_count * calls);
}

TEST_F(Threads, ManyCallThroughOneOrb) {
    serve();
    Orb client{*bus, quiet(2)};
    call_from_many_threads(client);
    EXPECT_EQ(client.counters()[Counter::calls_timed_out], 0U);
}

TEST_F(Threads, ManyCallWhileAnotherRunsTheLoop) {
    serve();
    Orb client{*bus, quiet(2)};
    std::atomic<int> ticks = 0;
    client.every(1ms, [&] { ++ticks; });
    std::thread loop{[&] { client.run(); }};
    call_from_many_threads(client);
    client.shutdown();
    loop.join();
    EXPECT_GT(ticks, 0);
}

TEST_F(Threads, ManyCallTheirOwnNode) {
    serve();
    std::thread second{[&] { server.run(); }};
    call_from_many_threads(server);
    end();
    second.join();
    EXPECT_EQ(servant.calls, 200);
}

TEST_F(Threads, ManyCallTheirOwnNodeThatNobodyElseServes) {
    server.root_poa().activate_object_with_id(1, servant);
    call_from_many_threads(server);
    EXPECT_EQ(servant.calls, 200);
}

TEST_F(Threads, ServantCallsBackIntoTheWaitingClient) {
    TestServant listener{{{1, echo}}};
    TestServant relay{{{1, [this](ServerCall& call) {
                            const auto answer =
                                object(server, 2).invoke(1, call.remaining_parameters());
                            call.reply(RawOctets{answer});
                        }}}};
    server.root_poa().activate_object_with_id(1, relay);
    thread = std::thread{[this] { server.run(); }};
    Orb client{*bus, quiet(2)};
    client.root_poa().activate_object_with_id(1, listener);
    for (int i = 0; i < 20; ++i) {
        const std::vector<std::uint8_t> octets{static_cast<std::uint8_t>(i)};
        EXPECT_EQ(object(client, 1).invoke(1, octets), octets);
    }
    EXPECT_EQ(listener.calls, 20);
}

TEST_F(Threads, ShutdownFromAServant) {
    TestServant stopper{{{0, [this](ServerCall& call) {
                              server.shutdown();
                              nothing(call);
                          }}}};
    server.root_poa().activate_object_with_id(1, stopper);
    std::promise<bool> ran;
    thread = std::thread{[&] { ran.set_value(server.run_for(1h)); }};
    Orb client{*bus, quiet(2)};
    object(client, 1).invoke(0, {});
    EXPECT_FALSE(ran.get_future().get());
    EXPECT_FALSE(server.run_for(1h));  // now and later
}

TEST_F(Threads, ShutdownEndsEveryLoop) {
    std::vector<std::thread> loops;
    std::promise<void> running;
    server.at(server.now(), [&] { running.set_value(); });
    for (int i = 0; i < 4; ++i) loops.emplace_back([this] { server.run(); });
    running.get_future().wait();
    server.shutdown();
    for (std::thread& loop : loops) loop.join();
}

TEST_F(Threads, TimersRunInTheLoopAndNotBeforeTheirTime) {
    const TimePoint start = server.now();
    std::vector<Duration> times;
    server.every(2ms, [&] {
        times.push_back(server.now() - start);
        if (times.size() == 5) server.shutdown();
    });
    server.run();
    ASSERT_EQ(times.size(), 5U);
    for (std::size_t i = 0; i < times.size(); ++i) {
        EXPECT_GE(times[i], 2ms * static_cast<int>(i + 1));
    }
}

TEST_F(Threads, RunForEndsByItself) {
    const TimePoint start = server.now();
    EXPECT_TRUE(server.run_for(3ms));
    EXPECT_GE(server.now() - start, 3ms);
    EXPECT_TRUE(server.run_for(0ms));
    EXPECT_TRUE(server.run_for(-1ms));
}

TEST_F(Threads, TimerMadeByAnotherThreadWakesTheLoop) {
    serve();
    for (int i = 0; i < 10; ++i) {
        std::promise<void> ran;
        server.at(server.now() + 1us, [&] { ran.set_value(); });
        ran.get_future().wait();
    }
}

TEST_F(Threads, PollServesTwoOrbsInOneThread) {
    server.root_poa().activate_object_with_id(1, servant);
    Orb client{*bus, quiet(2)};
    bool sent = false;
    call_through(object(client, 1).with_sent([&] { sent = true; }), ring_oneway);
    bool ticked = false;
    client.at(client.now() + 1ms, [&] { ticked = true; });
    while (servant.calls == 0 || !sent || !ticked) {
        server.poll();
        client.poll();
    }
    EXPECT_EQ(servant.calls, 1);
}

TEST_F(Threads, SentIsToldBeforeTheCallReturns) {
    serve();
    Orb client{*bus, quiet(2)};
    int sent = 0;
    for (int i = 1; i <= 20; ++i) {
        object(client, 1).with_sent([&] { ++sent; }).invoke(0, {});
        EXPECT_EQ(sent, i);
    }
}

TEST_F(Threads, OwnObjectThatIsBusyIsTimeoutNo) {
    std::promise<void> busy;
    std::promise<void> go;
    TestServant slow{{{0, nothing}, {1, [&](ServerCall& call) {
                                         busy.set_value();
                                         go.get_future().wait();
                                         nothing(call);
                                     }}}};
    server.root_poa().activate_object_with_id(1, slow);
    thread = std::thread{[this] { server.run(); }};
    std::thread first{[&] { object(server, 1).invoke(1, {}); }};
    busy.get_future().wait();
    EXPECT_EQ(error_of([&] { object(server, 1).with_timeout(5ms).invoke(0, {}); }),
              (SystemError{SystemErrorKind::timeout, Completion::no, 3}));
    go.set_value();
    first.join();
    end();
    EXPECT_EQ(slow.calls, 1);
}

TEST_F(Threads, ServantTooSlowIsTimeoutMaybeAtTheClient) {
    std::promise<void> go;
    TestServant slow{{{0, [&](ServerCall& call) {
                           go.get_future().wait();
                           nothing(call);
                       }}}};
    server.root_poa().activate_object_with_id(1, slow);
    thread = std::thread{[this] { server.run(); }};
    Orb client{*bus, quiet(2)};
    EXPECT_EQ(error_of([&] { object(client, 1).with_timeout(20ms).invoke(0, {}); }),
              (SystemError{SystemErrorKind::timeout, Completion::maybe, 2}));
    go.set_value();
    while (client.counters()[Counter::unmatched_replies] == 0) client.run_for(1ms);
}

TEST_F(Threads, DestructorSendsWhatIsQueued) {
    std::promise<void> all;
    TestServant counting{{{0, [&](ServerCall& call) {
                               call.oneway();  // nobody would be there for an answer
                               if (counting.calls == 20) all.set_value();
                           }}}};
    server.root_poa().activate_object_with_id(1, counting);
    thread = std::thread{[this] { server.run(); }};
    {
        Orb client{*bus, quiet(2)};
        const std::vector<std::uint8_t> none;
        for (int i = 0; i < 20; ++i) call_through(object(client, 1), ring_oneway, none);
    }
    all.get_future().wait();
}

TEST_F(Threads, DestructorEndsLoopsAndCallsOfOtherThreads) {
    std::promise<void> running;
    auto orb = std::make_unique<Orb>(*bus, quiet(2));
    orb->at(orb->now(), [&] { running.set_value(); });
    const ObjectRef nobody = object(*orb, 9);
    Orb& loop_orb = *orb;
    std::thread loop{[&] { loop_orb.run(); }};
    running.get_future().wait();
    std::promise<void> calling;
    std::thread caller{[&] {
        const ObjectRef target = nobody.with_sent([&] { calling.set_value(); });
        EXPECT_EQ(error_of([&] { target.invoke(0, {}); }),
                  (SystemError{SystemErrorKind::bad_inv_order, Completion::maybe, 39}));
    }};
    calling.get_future().wait();
    orb.reset();
    loop.join();
    caller.join();
}

TEST_F(Threads, ObjectsComeAndGoWhileOthersCall) {
    serve();
    Orb client{*bus, quiet(2)};
    std::atomic<bool> done = false;
    std::thread changer{[&] {
        TestServant other{{{0, nothing}}};
        while (!done) {
            const ObjectRef self = server.root_poa().activate_object_with_id(2, other);
            server.object_join(self, GroupId{5});
            static_cast<void>(server.group_to_string(GroupId{5}));
            static_cast<void>(server.counters());
            server.root_poa().deactivate_object(2);
            server.cancel(server.every(1s, [] {}));
        }
    }};
    call_from_many_threads(client);
    done = true;
    changer.join();
}

}  // namespace
}  // namespace canorb::test
