// Futures and callbacks on the machine's clock, with real threads.

#include <atomic>
#include <deque>
#include <future>
#include <thread>
#include <tuple>

#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

constexpr OperationInfo add{&lamp_interface, 1, "add"};

/// The sum of two numbers, as a stub would ask for it.
Future<std::uint32_t> sendp_add(const ObjectRef& target, std::uint32_t a, std::uint32_t b) {
    return send_request<Returns<std::uint32_t>>(target, add, a, b);
}

OrbOptions quiet(int number) {
    OrbOptions options;
    options.node = number;
    options.default_timeout = 20s;
    options.inter_frame_timeout = 10s;  // threads may be kept waiting on a busy machine
    options.inter_frame_timeout = 20s;  // however busy the machine is
    options.log = [](std::string_view) {};
    return options;
}

ObjectRef object(Orb& orb, int number) {
    return orb.string_to_object("corbaloc:caniop:" + std::to_string(number) + "/1");
}

class FutureThreads : public testing::Test {
  protected:
    FutureThreads() { server.root_poa().activate_object_with_id(1, servant); }
    ~FutureThreads() override {
        server.shutdown();
        serving.join();
    }

    /// Calls from many threads, each with several futures at once.
    static void call_from_many_threads(Orb& client, int number) {
        constexpr std::uint32_t thread_count = 8;
        constexpr std::uint32_t rounds = 10;
        std::vector<std::thread> threads;
        std::atomic<std::uint32_t> right = 0;
        for (std::uint32_t t = 0; t < thread_count; ++t) {
            threads.emplace_back([&, t] {
                const ObjectRef target = object(client, number);
                for (std::uint32_t i = 0; i < rounds; ++i) {
                    Future<std::uint32_t> first = sendp_add(target, t, i);
                    Future<std::uint32_t> cancelled = sendp_add(target, t, i);
                    Future<std::uint32_t> second = sendp_add(target, 1000 * t, i);
                    cancelled.cancel();
                    right += second.get() == 1000 * t + i ? 1 : 0;
                    right += first.get() == t + i ? 1 : 0;
                }
            });
        }
        for (std::thread& thread : threads) thread.join();
        EXPECT_EQ(right, 2 * thread_count * rounds);
        EXPECT_EQ(client.counters()[Counter::unmatched_replies], 0U);
    }

    std::unique_ptr<Bus> bus = open_bus(
        std::string{"local:"} + testing::UnitTest::GetInstance()->current_test_info()->name() +
        "?bitrate=1000000");
    TestServant servant{{{1, [](ServerCall& call) {
                              std::uint32_t a{};
                              std::uint32_t b{};
                              if (call.read(a, b)) call.reply(a + b);
                          }}}};
    Orb server{*bus, quiet(1)};
    std::thread serving{[this] { server.run(); }};
};

TEST_F(FutureThreads, ManyThroughOneOrb) {
    Orb client{*bus, quiet(2)};
    call_from_many_threads(client, 1);
}

TEST_F(FutureThreads, ManyWhileAnotherRunsTheLoop) {
    Orb client{*bus, quiet(2)};
    std::thread loop{[&] { client.run(); }};
    call_from_many_threads(client, 1);
    client.shutdown();
    loop.join();
}

TEST_F(FutureThreads, ManyToTheirOwnNode) {
    call_from_many_threads(server, 1);
}

TEST_F(FutureThreads, CallbacksRunInTheLoopOneAtATime) {
    OrbOptions options = quiet(2);
    options.worker_threads = 3;
    Orb client{*bus, options};
    constexpr std::uint32_t thread_count = 4;
    constexpr std::uint32_t calls = 12;
    std::atomic<int> inside = 0;
    std::uint32_t sum = 0;  // without a lock: callbacks run one at a time
    std::uint32_t called = 0;
    std::promise<void> all;
    std::vector<std::thread> threads;
    for (std::uint32_t t = 0; t < thread_count; ++t) {
        threads.emplace_back([&] {
            const ObjectRef target = object(client, 1);
            for (std::uint32_t i = 0; i < calls; ++i) {
                sendp_add(target, i, 1).then([&](Future<std::uint32_t> result) {
                    EXPECT_EQ(++inside, 1);
                    sum += result.get();
                    --inside;
                    if (++called == thread_count * calls) all.set_value();
                });
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    all.get_future().wait();
    EXPECT_EQ(sum, thread_count * (calls * (calls - 1) / 2 + calls));
}

TEST_F(FutureThreads, CallbackInSomebodyElsesLoop) {
    Orb client{*bus, quiet(2)};
    bool called = false;
    sendp_add(object(client, 1), 1, 2).then([&](Future<std::uint32_t> sum) {
        EXPECT_EQ(sum.get(), 3U);
        called = true;
    });
    while (!called) client.poll();
}

TEST_F(FutureThreads, CallbackMakesACallOfItsOwn) {
    Orb client{*bus, quiet(2)};
    std::promise<std::uint32_t> result;
    sendp_add(object(client, 1), 1, 2).then([&](Future<std::uint32_t> first) {
        const std::uint32_t sum = first.get();
        result.set_value(sendp_add(object(client, 1), sum, 4).get());
        client.shutdown();
    });
    client.run();
    EXPECT_EQ(result.get_future().get(), 7U);
}

// Each call is cancelled or told, whoever is first; nothing is told twice.
TEST_F(FutureThreads, CancelledWhileTheyEnd) {
    Orb client{*bus, quiet(2)};
    std::thread loop{[&] { client.run(); }};
    const ObjectRef target = object(client, 1);
    std::deque<std::atomic<int>> told(60);
    for (std::size_t i = 0; i < told.size(); ++i) {
        const PendingCall call =
            sendp_add(target, 1, 1).then([&told, i](Future<std::uint32_t> sum) {
                EXPECT_EQ(sum.get(), 2U);
                ++told[i];
            });
        // Time for some of the answers to come.
        if (i % 3 != 0) sendp_add(target, 1, 1).get();
        call.cancel();
    }
    EXPECT_TRUE(client.drain(20s));
    client.shutdown();
    loop.join();
    for (const std::atomic<int>& times : told) EXPECT_LE(times, 1);
    EXPECT_EQ(client.counters()[Counter::unmatched_replies], 0U);
}

TEST_F(FutureThreads, TheDeadlineHoldsWhileAnotherThreadRunsTheLoop) {
    Orb client{*bus, quiet(2)};
    std::thread loop{[&] { client.run(); }};
    Future<std::uint32_t> silent = sendp_add(object(client, 9).with_timeout(5ms), 1, 2);
    EXPECT_THROW(silent.get(), TIMEOUT);
    std::promise<void> told;
    sendp_add(object(client, 9).with_timeout(5ms), 1, 2).then([&](Future<std::uint32_t> sum) {
        EXPECT_THROW(sum.get(), TIMEOUT);
        told.set_value();
    });
    told.get_future().wait();
    client.shutdown();
    loop.join();
}

TEST_F(FutureThreads, TheOrbGoesWhileAThreadWaits) {
    auto client = std::make_unique<Orb>(*bus, quiet(2));
    const auto token = std::make_shared<int>();
    sendp_add(object(*client, 9), 1, 2).then([token](Future<std::uint32_t>) { ADD_FAILURE(); });
    std::promise<void> waiting;
    Future<std::uint32_t> silent =
        sendp_add(object(*client, 9).with_sent([&] { waiting.set_value(); }), 1, 2);
    std::thread thread{[&] {
        EXPECT_EQ(error_of([&] { silent.get(); }),
                  (SystemError{SystemErrorKind::bad_inv_order, Completion::maybe, 39}));
    }};
    waiting.get_future().wait();
    client.reset();
    thread.join();
    EXPECT_EQ(token.use_count(), 1);
}

}  // namespace
}  // namespace canorb::test
