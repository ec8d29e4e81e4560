// Futures and callbacks of generated stubs, on virtual time.

#include <deque>
#include <optional>
#include <tuple>

#include "devices.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

constexpr SystemError timeout_maybe{SystemErrorKind::timeout, Completion::maybe, 2};

class MotorImpl : public Devices::MotorServant {
  public:
    std::string model() override { return "M-1"; }
    float speed(std::uint16_t channel) override {
        channels.push_back(channel);
        return static_cast<float>(channel) + 0.5F;
    }
    void start() override { throw Devices::MotorStartException{"no current"}; }
    void stop() override {}
    std::uint32_t ramp() override { return ramp_; }
    void ramp(std::uint32_t value) override { ramp_ = value; }
    Devices::State sample(std::int32_t& range, Devices::Samples& samples) override {
        samples = {1, 200, 30000};
        range = -range;
        return Devices::State::RUNNING;
    }
    void follow(const Devices::Motor& leader) override { leader_ = leader; }
    Devices::Motor leader() override { return leader_; }
    void SetAttributeValueUL(const std::string&, std::uint32_t, std::uint32_t) override {
        throw NO_PERMISSION{"no", Completion::no, 7};
    }

    std::vector<std::uint16_t> channels;

  private:
    std::uint32_t ramp_ = 10;
    Devices::Motor leader_;
};

class Futures : public World {
  protected:
    Futures() {
        server.root_poa().activate_object_with_id(1, servant);
        motor = at(client, 3, 1).unchecked_narrow<Devices::Motor>();
        nobody = at(client, 9, 1).unchecked_narrow<Devices::Motor>().with_timeout(20ms);
    }

    std::uint64_t count(Counter counter) const { return client.counters()[counter]; }

    Orb server{bus, node(3)};
    Orb client{bus, node(5)};
    MotorImpl servant;
    Devices::Motor motor;
    Devices::Motor nobody;
};

TEST_F(Futures, GiveWhatTheCallReturns) {
    Future<float> speed = motor.sendp_speed(1000);
    EXPECT_TRUE(speed.valid());
    EXPECT_FALSE(speed.ready());
    EXPECT_EQ(speed.get(), 1000.5F);
    EXPECT_FALSE(speed.valid());
    motor.sendp_set_ramp(4'000'000'000U).get();
    EXPECT_EQ(motor.sendp_get_ramp().get(), 4'000'000'000U);
    EXPECT_EQ(motor.sendp_get_model().get(), "M-1");
}

TEST_F(Futures, GiveSeveralResultsInTheOrderOfTheReply) {
    EXPECT_EQ(motor.sendp_sample(77).get(),
              std::tuple(Devices::State::RUNNING, -77, Devices::Samples{1, 200, 30000}));
}

TEST_F(Futures, GiveReferencesThatCanBeCalled) {
    motor.sendp_follow(motor).get();
    EXPECT_EQ(motor.sendp_leader().get().speed(3), 3.5F);
}

TEST_F(Futures, ThrowWhatTheCallThrows) {
    try {
        motor.sendp_start().get();
        FAIL();
    } catch (const Devices::MotorStartException& exception) {
        EXPECT_EQ(exception.reason, "no current");
    }
    EXPECT_EQ(error_of([&] { motor.sendp_SetAttributeValueUL("x", 1, 2).get(); }),
              (SystemError{SystemErrorKind::no_permission, Completion::no, 7}));
    EXPECT_EQ(error_of([&] {
                  at(client, 3, 7).unchecked_narrow<Devices::Motor>().sendp_start().get();
              }).kind,
              SystemErrorKind::object_not_exist);
}

TEST_F(Futures, ThrowMarshalForAReplyOfAnotherType) {
    TestServant short_answer{{{1, [](ServerCall& call) { call.reply(std::uint8_t{1}); }}}};
    server.root_poa().activate_object_with_id(2, short_answer);
    EXPECT_EQ(
        error_of([&] { at(client, 3, 2).unchecked_narrow<Devices::Motor>().sendp_speed(1).get(); }),
        (SystemError{SystemErrorKind::marshal, Completion::yes, 21}));
}

TEST_F(Futures, ThrowUnknownForAnExceptionThatIsNotDeclared) {
    TestServant raising{
        {{1, [](ServerCall& call) { call.raise(Devices::MotorStartException{"no"}); }}}};
    server.root_poa().activate_object_with_id(2, raising);
    EXPECT_EQ(
        error_of([&] { at(client, 3, 2).unchecked_narrow<Devices::Motor>().sendp_speed(1).get(); }),
        (SystemError{SystemErrorKind::unknown, Completion::maybe, 41}));
}

TEST_F(Futures, EndAtTheDeadlineThatCountsFromTheCall) {
    const TimePoint start = simulation.now();
    Future<float> speed = nobody.sendp_speed(1);
    simulation.run_for(15ms);
    EXPECT_FALSE(speed.ready());
    EXPECT_EQ(what<TIMEOUT>([&] { speed.get(); }),
              "TIMEOUT (completed MAYBE, minor 2): no answer before the deadline: speed on node 9, "
              "object 1");
    EXPECT_EQ(simulation.now(), start + 20ms);
}

TEST_F(Futures, AreReadyAtTheDeadlineWithoutGet) {
    Future<float> speed = nobody.sendp_speed(1);
    simulation.run_for(1h);
    EXPECT_TRUE(speed.ready());
    const TimePoint before = simulation.now();
    EXPECT_EQ(error_of([&] { speed.get(); }), timeout_maybe);
    EXPECT_EQ(simulation.now(), before);
}

TEST_F(Futures, WaitForATime) {
    const TimePoint start = simulation.now();
    Future<float> speed = nobody.sendp_speed(1);
    EXPECT_FALSE(speed.wait_for(0ms));
    EXPECT_EQ(simulation.now(), start);
    EXPECT_FALSE(speed.wait_for(5ms));
    EXPECT_EQ(simulation.now(), start + 5ms);
    EXPECT_FALSE(speed.wait_for(-1h));
    EXPECT_TRUE(speed.wait_for(1h));
    EXPECT_EQ(simulation.now(), start + 20ms);
    EXPECT_EQ(error_of([&] { speed.get(); }), timeout_maybe);
    Future<float> other = motor.sendp_speed(1);
    EXPECT_TRUE(other.wait_for(1h));
    EXPECT_LT(simulation.now(), start + 21ms);
    EXPECT_EQ(other.get(), 1.5F);
}

TEST_F(Futures, ManyAtOnceAreFetchedInAnyOrder) {
    std::deque<Future<float>> futures;
    for (std::uint16_t i = 0; i < 60; ++i) futures.push_back(motor.sendp_speed(i));
    for (std::uint16_t i = 59; i >= 30; --i) {
        EXPECT_EQ(futures.back().get(), static_cast<float>(i) + 0.5F);
        futures.pop_back();
    }
    for (std::uint16_t i = 0; i < 30; ++i) {
        EXPECT_EQ(futures.front().get(), static_cast<float>(i) + 0.5F);
        futures.pop_front();
    }
    EXPECT_EQ(servant.channels.size(), 60U);
}

TEST_F(Futures, WhatIsKnownAtOnceIsThrownAtOnce) {
    EXPECT_THROW(static_cast<void>(Devices::Motor{}.sendp_speed(1)), INV_OBJREF);
    EXPECT_THROW(
        static_cast<void>(group(client, 7).unchecked_narrow<Devices::Motor>().sendp_speed(1)),
        BAD_OPERATION);
    OrbOptions options = node(6);
    options.max_outstanding_calls = 1;
    Orb small{bus, options};
    const auto target = at(small, 9, 1).unchecked_narrow<Devices::Motor>();
    Future<float> first = target.sendp_speed(1);
    EXPECT_THROW(static_cast<void>(target.sendp_speed(2)), NO_RESOURCES);
    EXPECT_THROW(target.sendc_speed([](Future<float>) { ADD_FAILURE(); }, 2), NO_RESOURCES);
}

TEST_F(Futures, OfNoCall) {
    Future<float> none;
    EXPECT_FALSE(none.valid());
    EXPECT_THROW(none.get(), BAD_INV_ORDER);
    EXPECT_THROW(static_cast<void>(none.ready()), BAD_INV_ORDER);
    EXPECT_THROW(none.wait_for(1ms), BAD_INV_ORDER);
    EXPECT_THROW(none.then([](Future<float>) {}), BAD_INV_ORDER);
    none.cancel();
    Future<float> speed = motor.sendp_speed(1);
    none = std::move(speed);
    EXPECT_EQ(none.get(), 1.5F);
    EXPECT_THROW(none.get(), BAD_INV_ORDER);
    PendingCall{}.cancel();
}

// ---- cancellation

TEST_F(Futures, CancelledBeforeItIsBegunIsNeverSent) {
    bool sent = false;
    const auto token = std::make_shared<int>();
    Future<float> first = motor.sendp_speed(1);
    Future<float> second = motor.sendp_speed(2);
    Future<float> third =
        Devices::Motor{motor.with_sent([&sent, token] { sent = true; })}.sendp_speed(3);
    third.cancel();
    EXPECT_FALSE(third.valid());
    EXPECT_EQ(second.get(), 2.5F);
    EXPECT_EQ(first.get(), 1.5F);
    simulation.run_for(1s);
    EXPECT_EQ(servant.channels, (std::vector<std::uint16_t>{1, 2}));
    EXPECT_EQ(seen.size(), 8U);  // two requests and two replies, of two frames each
    EXPECT_FALSE(sent);
    EXPECT_EQ(token.use_count(), 1);
    EXPECT_EQ(count(Counter::replies_to_cancelled_calls), 0U);
}

TEST_F(Futures, CancelledAfterItIsSentIsAnsweredInVain) {
    Future<float> speed = motor.sendp_speed(1);
    speed.cancel();
    simulation.run_for(1s);
    EXPECT_EQ(servant.channels.size(), 1U);
    EXPECT_EQ(count(Counter::replies_to_cancelled_calls), 1U);
    EXPECT_EQ(count(Counter::unmatched_replies), 0U);
    EXPECT_EQ(count(Counter::calls_timed_out), 0U);
}

TEST_F(Futures, DestroyedOrReplacedIsCancelled) {
    {
        const Future<float> speed = motor.sendp_speed(1);
    }
    Future<float> other = motor.sendp_speed(2);  // not begun
    other = motor.sendp_speed(3);
    EXPECT_EQ(other.get(), 3.5F);
    EXPECT_EQ(servant.channels, (std::vector<std::uint16_t>{1, 3}));
    EXPECT_EQ(count(Counter::replies_to_cancelled_calls), 1U);
}

TEST_F(Futures, CancelledWhileItIsWaitedFor) {
    Future<float> speed = nobody.sendp_speed(1);
    client.at(client.now() + 5ms, [&] { speed.cancel(); });
    EXPECT_THROW(speed.get(), BAD_INV_ORDER);
    EXPECT_EQ(simulation.now(), TimePoint{5ms});
    EXPECT_FALSE(speed.valid());
}

TEST_F(Futures, ReplacedWhileItIsWaitedFor) {
    Future<float> speed = nobody.sendp_speed(1);
    client.at(client.now() + 5ms, [&] { speed = motor.sendp_speed(2); });
    EXPECT_THROW(speed.get(), BAD_INV_ORDER);
    EXPECT_EQ(speed.get(), 2.5F);
}

TEST_F(Futures, OfTheOwnNode) {
    Devices::Motor own = at(server, 3, 1).unchecked_narrow<Devices::Motor>();
    Future<float> first = own.sendp_speed(1);
    EXPECT_TRUE(servant.channels.empty());  // not within the caller's stack
    Future<float> second = own.sendp_speed(2);
    second.cancel();
    EXPECT_EQ(first.get(), 1.5F);
    simulation.run_for(1ms);
    EXPECT_EQ(servant.channels, (std::vector<std::uint16_t>{1}));
    EXPECT_TRUE(seen.empty());
}

TEST_F(Futures, OfAGroupAreReadyOnceTheMessageIsQueued) {
    server.object_join(at(server, 3, 1), GroupId{7});
    const auto all = group(client, 7).unchecked_narrow<Devices::Motor>();
    Future<void> set = all.sendp_set_ramp(99);
    EXPECT_TRUE(set.ready());
    EXPECT_TRUE(set.wait_for(1h));
    set.get();
    EXPECT_FALSE(set.valid());
    EXPECT_EQ(simulation.now(), TimePoint{});
    simulation.run_for(1ms);
    EXPECT_EQ(servant.ramp(), 99U);
    bool called = false;
    all.sendc_set_ramp(
        [&](Future<void> done) {
            done.get();
            called = true;
        },
        100);
    EXPECT_FALSE(called);
    simulation.run_for(1ms);
    EXPECT_TRUE(called);
    all.sendp_set_ramp(101).cancel();  // too late: it is queued
    simulation.run_for(1ms);
    EXPECT_EQ(servant.ramp(), 101U);
}

// ---- callbacks

TEST_F(Futures, CallbackGetsTheReadyFutureOnce) {
    std::vector<float> speeds;
    motor.sendc_speed(
        [&](Future<float> speed) {
            EXPECT_TRUE(speed.ready());
            speeds.push_back(speed.get());
        },
        1);
    EXPECT_TRUE(speeds.empty());
    simulation.run_for(1h);
    EXPECT_EQ(speeds, std::vector<float>{1.5F});
}

TEST_F(Futures, CallbackGetsExceptions) {
    std::string caught;
    motor.sendc_start([&](Future<void> started) {
        try {
            started.get();
        } catch (const Devices::MotorStartException& exception) {
            caught = exception.reason;
        }
    });
    std::optional<SystemError> error;
    TimePoint when;
    nobody.sendc_speed(
        [&](Future<float> speed) {
            when = simulation.now();
            error = error_of([&] { speed.get(); });
        },
        1);
    simulation.run_for(1s);
    EXPECT_EQ(caught, "no current");
    EXPECT_EQ(error, timeout_maybe);
    EXPECT_EQ(when, TimePoint{20ms});
}

TEST_F(Futures, CallbacksComeInTheOrderOfTheEnds) {
    std::vector<int> order;
    nobody.sendc_speed([&](Future<float>) { order.push_back(9); }, 1);
    motor.sendc_SetAttributeValueUL([&](Future<void>) { order.push_back(1); }, "a long text", 1, 2);
    motor.sendc_speed([&](Future<float>) { order.push_back(2); }, 1);
    at(server, 3, 1)
        .unchecked_narrow<Devices::Motor>()
        .sendc_speed([&](Future<float>) { order.push_back(0); }, 1);
    simulation.run_for(1s);
    EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 9}));
}

TEST_F(Futures, CallbackThatDoesNotLookIsNoFault) {
    OrbOptions options = node(6);
    options.max_outstanding_calls = 1;
    Orb small{bus, options};
    int called = 0;
    for (int i = 0; i < 3; ++i) {
        at(small, 3, 1)
            .unchecked_narrow<Devices::Motor>()
            .sendc_speed([&](const Future<float>&) { ++called; }, 1);
        simulation.run_for(10ms);
    }
    EXPECT_EQ(called, 3);
    EXPECT_TRUE(log.empty());
}

TEST_F(Futures, ThenOnOneThatIsReadyIsNotCalledWithin) {
    Future<float> speed = motor.sendp_speed(1);
    simulation.run_for(10ms);
    ASSERT_TRUE(speed.ready());
    float result = 0;
    speed.then([&](Future<float> ready) { result = ready.get(); });
    EXPECT_FALSE(speed.valid());
    EXPECT_EQ(result, 0);
    simulation.run_for(0ms);
    EXPECT_EQ(result, 1.5F);
}

TEST_F(Futures, CallbackRunsWhileAnotherCallIsWaitedFor) {
    float first = 0;
    motor.sendc_speed([&](Future<float> speed) { first = speed.get(); }, 1);
    EXPECT_EQ(motor.speed(2), 2.5F);
    EXPECT_EQ(first, 1.5F);
}

TEST_F(Futures, CallsFromWithinACallback) {
    std::vector<float> results;
    motor.sendc_speed(
        [&](Future<float> first) {
            results.push_back(first.get());
            results.push_back(motor.speed(2));              // nested
            results.push_back(motor.sendp_speed(3).get());  // nested
            motor.sendc_speed([&](Future<float> last) { results.push_back(last.get()); }, 4);
            results.push_back(-1);
        },
        1);
    simulation.run_for(1s);
    EXPECT_EQ(results, (std::vector<float>{1.5F, 2.5F, 3.5F, -1, 4.5F}));
}

TEST_F(Futures, CancelledCallbackIsNotCalled) {
    const auto token = std::make_shared<int>();
    const PendingCall call = motor.sendc_speed([token](Future<float>) { ADD_FAILURE(); }, 1);
    EXPECT_EQ(token.use_count(), 2);
    const PendingCall copy = call;
    copy.cancel();
    EXPECT_EQ(token.use_count(), 1);
    simulation.run_for(1s);
    EXPECT_EQ(count(Counter::replies_to_cancelled_calls), 1U);
    call.cancel();
}

TEST_F(Futures, CallbackCancelsCallsThatWait) {
    std::vector<PendingCall> calls;
    int called = 0;
    motor.sendc_speed(
        [&](Future<float>) {
            ++called;
            for (const PendingCall& call : calls) call.cancel();
        },
        1);
    calls.push_back(motor.sendc_speed([](Future<float>) { ADD_FAILURE(); }, 2));
    calls.push_back(nobody.sendc_speed([](Future<float>) { ADD_FAILURE(); }, 3));
    simulation.run_for(1s);
    EXPECT_EQ(called, 1);
    EXPECT_EQ(count(Counter::replies_to_cancelled_calls), 1U);
}

TEST_F(Futures, CallbackCancelsOneThatHasEnded) {
    PendingCall second;
    int called = 0;
    nobody.sendc_speed(
        [&](Future<float>) {
            ++called;
            EXPECT_EQ(count(Counter::calls_timed_out), 2U);  // both, at one time
            second.cancel();
        },
        1);
    second = nobody.sendc_speed([](Future<float>) { ADD_FAILURE(); }, 2);
    simulation.run_for(1s);
    EXPECT_EQ(called, 1);
}

TEST_F(Futures, CallbackThatThrowsIsAnEvent) {
    motor.sendc_start([](Future<void> started) { started.get(); });
    simulation.run_for(10ms);
    ASSERT_EQ(log.size(), 1U);
    EXPECT_EQ(log[0], "node-5: the callback of a call raised IDL:Devices/MotorStartException:1.0");
}

// ---- the Orb goes

TEST_F(Futures, OutliveTheirOrb) {
    const auto token = std::make_shared<int>();
    std::optional<Orb> orb{std::in_place, bus, node(6)};
    const auto target = at(*orb, 3, 1).unchecked_narrow<Devices::Motor>();
    const auto silent = at(*orb, 9, 1).unchecked_narrow<Devices::Motor>();
    Future<float> ended = target.sendp_speed(1);
    simulation.run_for(10ms);
    Future<float> waiting = silent.sendp_speed(2);
    Future<float> told = silent.sendp_speed(3);
    Future<float> cancelled = silent.sendp_speed(4);
    const PendingCall call = silent.sendc_speed([token](Future<float>) { ADD_FAILURE(); }, 5);
    orb.reset();
    EXPECT_EQ(token.use_count(), 1);
    call.cancel();
    cancelled.cancel();
    EXPECT_EQ(ended.get(), 1.5F);  // it had come
    EXPECT_TRUE(waiting.ready());
    EXPECT_TRUE(waiting.wait_for(1h));
    EXPECT_EQ(error_of([&] { waiting.get(); }),
              (SystemError{SystemErrorKind::bad_inv_order, Completion::maybe, 39}));
    EXPECT_THROW(told.then([](Future<float>) { ADD_FAILURE(); }), BAD_INV_ORDER);
    EXPECT_THROW(static_cast<void>(target.sendp_speed(1)), BAD_INV_ORDER);
}

// What a callback holds may be the last that keeps something which calls the ORB when it goes.
TEST_F(Futures, CallbacksOfAnOrbThatGoesMayCallIt) {
    std::optional<Orb> orb{std::in_place, bus, node(6)};
    const auto silent = at(*orb, 9, 1).unchecked_narrow<Devices::Motor>();
    bool destroyed = false;
    std::shared_ptr<void> last{nullptr, [&](void*) {
                                   EXPECT_THROW(silent.stop(), BAD_INV_ORDER);
                                   destroyed = true;
                               }};
    silent.sendc_speed([held = std::move(last)](Future<float>) { ADD_FAILURE(); }, 1);
    EXPECT_FALSE(destroyed);
    orb.reset();
    EXPECT_TRUE(destroyed);
}

}  // namespace
}  // namespace canorb::test
