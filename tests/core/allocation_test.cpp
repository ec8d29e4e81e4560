// A call does not touch the heap once as many buffers have been made as are in use at a time.

#include <gtest/gtest.h>

#include <array>

#include "orb/core/engine.hpp"
#include "orb/giop/message.hpp"
#include "tests/support/allocations.hpp"

namespace canorb::core {
namespace {

using canorb::test::allocations;

using namespace std::chrono_literals;

constexpr InterfaceInfo bell{"IDL:Test/Bell:1.0"};
constexpr GroupId group{7};

EngineOptions options_of(std::uint8_t node) {
    EngineOptions options;
    options.node = NodeId{node};
    return options;
}

class Pair {
  public:
    /// A call of each kind, answered, refused, late, and a message that is malformed.
    void round() {
        std::array<std::uint8_t, giop::request_header_size + 40> message{};
        const auto handle =
            client.call(ObjectKey{NodeId{3}, 1}, 2, MutableBytes{message}.first(28), now + 1s);
        const auto refused = client.call(ObjectKey{NodeId{3}, 1}, 3, message, now + 1s);
        const auto foreign = client.call(ObjectKey{NodeId{3}, 2}, 2, message, now + 1s);
        const auto own = client.call(ObjectKey{NodeId{5}, 1}, 2, message, now + 1s);
        const auto late = client.call(ObjectKey{NodeId{5}, 1}, 4, message, now + 1ms);
        const auto withdrawn = server.call(ObjectKey{NodeId{9}, 1}, 2, message, now);
        ASSERT_TRUE(client.send(ObjectKey{NodeId{3}, 1}, 5, message, now + 1s).ok());
        ASSERT_TRUE(client.multicast(group, 0, 6, message, now + 1s).ok());
        const can::Frame malformed =
            can::Frame::standard(0x4A9, std::array<std::uint8_t, 3>{0x13, 0, 0});
        client.on_event(can::Received{malformed, now}, now);
        client.on_time(now);
        for (int i = 0; i < 100; ++i) {
            exchange(client, server);
            exchange(server, client);
        }
        now += 1s;
        client.on_time(now);
        server.on_time(now);
        for (const auto* call : {&handle, &refused, &foreign, &own, &late}) {
            ASSERT_TRUE(call->ok());
            auto result = client.take_result(**call);
            ASSERT_TRUE(result.has_value());
            if (auto* answer = std::get_if<CallAnswer>(&*result)) {
                ++answered;
                client.buffers().release(std::move(answer->body));
            }
        }
        ASSERT_TRUE(server.take_result(*withdrawn).has_value());
    }

    Engine client{options_of(5)};
    Engine server{options_of(3)};
    TimePoint now{1s};
    std::size_t answered = 0;

  private:
    void exchange(Engine& from, Engine& to) {
        while (const auto frame = from.next_frame(now)) {
            const can::TransmitHandle handle{++last_frame_};
            from.handed_over(handle);
            from.on_event(can::TransmitResult{handle, can::TransmitOutcome::sent, now}, now);
            to.on_event(can::Received{*frame, now}, now);
        }
        while (auto request = to.next_request(now)) {
            std::array<std::uint8_t, giop::reply_header_size + 30> reply{};
            if (request->operation == 3) {
                to.refuse(request->answer_to, {SystemErrorKind::no_permission, Completion::no},
                          now);
            } else if (request->operation != 4) {
                to.answer(request->answer_to, giop::ReplyStatus::no_exception, reply, now);
            }
            to.buffers().release(std::move(request->parameters));
        }
        while (from.next_notice()) {
        }
    }

    std::uint64_t last_frame_ = 0;
};

TEST(Allocation, NoneForACallOnceWarm) {
    Pair pair;
    ASSERT_TRUE(pair.client.join(group, {1, &bell}));
    ASSERT_TRUE(pair.server.join(group, {1, &bell}));
    for (int i = 0; i < 10; ++i) pair.round();
    ASSERT_FALSE(HasFailure());
    const std::size_t before = allocations;
    for (int i = 0; i < 100; ++i) pair.round();
    EXPECT_EQ(allocations - before, 0U);
    EXPECT_EQ(pair.answered, 110U * 3);
    EXPECT_EQ(pair.client.counters()[Counter::message_errors_sent], 110U);
}

TEST(Allocation, NoneForTracingThatIsOff) {
    Pair pair;
    for (int i = 0; i < 10; ++i) pair.round();
    pair.client.tracer().turn(true);
    pair.round();
    EXPECT_TRUE(pair.client.tracer().has_next());
    pair.client.tracer().turn(false);
    ASSERT_FALSE(HasFailure());
    const std::size_t before = allocations;
    for (int i = 0; i < 100; ++i) pair.round();
    EXPECT_EQ(allocations - before, 0U);
    EXPECT_FALSE(pair.client.tracer().has_next());
}

}  // namespace
}  // namespace canorb::core
