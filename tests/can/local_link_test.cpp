#include "orb/can/link/local_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <array>

namespace canorb::can {
namespace {

constexpr std::array<Filter, 1> accept_all{Filter{}};

std::unique_ptr<Link> opened(std::string_view address) {
    auto link = open_link(address);
    EXPECT_TRUE(link) << link.error();
    return link ? std::move(*link) : nullptr;
}

std::unique_ptr<Controller> attached(Link& link) {
    auto controller = link.attach("test");
    EXPECT_TRUE(controller) << controller.error();
    return controller ? std::move(*controller) : nullptr;
}

bool receives(Controller& controller, std::uint32_t id) {
    pollfd descriptor{controller.event_fd(), POLLIN, 0};
    while (::poll(&descriptor, 1, 20'000) == 1) {
        while (const auto event = controller.poll()) {
            const auto* received = std::get_if<Received>(&*event);
            if (received != nullptr && received->frame.id == id) return true;
        }
    }
    return false;
}

TEST(LocalLink, ThoseWhoOpenTheSameNameShareABus) {
    const auto first = opened("local:shared");
    const auto second = opened("local:shared");
    const auto sender = attached(*first);
    const auto receiver = attached(*second);
    ASSERT_TRUE(receiver->set_filters(accept_all));
    EXPECT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x123, {}))));
    EXPECT_TRUE(receives(*receiver, 0x123));
}

TEST(LocalLink, OtherNamesAreOtherBuses) {
    const auto here = opened("local:here");
    const auto there = opened("local:there");
    const auto sender = attached(*here);
    const auto receiver = attached(*here);
    const auto stranger = attached(*there);
    ASSERT_TRUE(receiver->set_filters(accept_all));
    ASSERT_TRUE(stranger->set_filters(accept_all));
    EXPECT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x123, {}))));
    EXPECT_TRUE(receives(*receiver, 0x123));
    EXPECT_EQ(stranger->poll(), std::nullopt);
}

TEST(LocalLink, ControllersOutliveTheirLink) {
    auto link = opened("local:outlive");
    const auto sender = attached(*link);
    const auto receiver = attached(*link);
    link.reset();
    ASSERT_TRUE(receiver->set_filters(accept_all));
    EXPECT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x123, {}))));
    EXPECT_TRUE(receives(*receiver, 0x123));
}

// The frame is there when send() returns: nobody has to wait for the bus.
TEST(LocalLink, WithoutAPaceAFrameArrivesAtOnce) {
    const auto link = opened("local:fast?paced=no&bitrate=5000");
    const auto sender = attached(*link);
    const auto receiver = attached(*link);
    ASSERT_TRUE(receiver->set_filters(accept_all));
    for (std::uint32_t id = 0; id < 3; ++id) {
        const SendResult sent = sender->send(Frame::standard(id, {}));
        EXPECT_EQ(std::get<TransmitResult>(sent).outcome, TransmitOutcome::sent);
        EXPECT_EQ(sender->poll(), std::nullopt);
        const auto event = receiver->poll();
        ASSERT_TRUE(event);
        EXPECT_EQ(std::get<Received>(*event).frame.id, id);
    }
    EXPECT_EQ(receiver->poll(), std::nullopt);
}

TEST(LocalLink, WithoutAPaceAFrameWaitsForSomebodyToAcknowledgeIt) {
    const auto link = opened("local:alone?paced=no");
    const auto sender = attached(*link);
    const auto is_sent = [&] {
        while (const auto event = sender->poll()) {
            if (std::holds_alternative<TransmitResult>(*event)) return true;
        }
        return false;
    };
    EXPECT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x123, {}))));
    EXPECT_FALSE(is_sent());
    const auto receiver = attached(*link);
    EXPECT_TRUE(is_sent());
}

TEST(LocalLink, WithoutAPaceASlowReaderIsWaitedForButNotForEver) {
    const auto link = opened("local:slow?paced=no");
    const auto sender = attached(*link);
    const auto reader = attached(*link);
    ASSERT_TRUE(reader->set_filters(accept_all));
    std::uint32_t sent = 0;
    std::uint32_t lost = 0;
    std::uint32_t received = 0;
    // Until the bus gives the reader up; what is sent meanwhile waits in the sender's mailboxes.
    while (sent < 2'000) {
        if (!std::holds_alternative<SendError>(sender->send(Frame::standard(sent, {})))) ++sent;
        while (sender->poll()) continue;
    }
    while (const auto event = reader->poll()) {
        if (std::holds_alternative<Received>(*event)) ++received;
        if (const auto* loss = std::get_if<FramesLost>(&*event)) {
            lost += static_cast<std::uint32_t>(loss->count);
        }
    }
    EXPECT_GT(lost, 0U);
    EXPECT_EQ(received + lost, 2'000U);
}

TEST(LocalLink, WithoutAPaceNobodyHasToTouchTheBusForItToGoOn) {
    const auto link = opened("local:asleep?paced=no");
    const auto sender = attached(*link);
    const auto reader = attached(*link);
    const auto deaf = attached(*link);
    ASSERT_TRUE(reader->set_filters(accept_all));
    ASSERT_TRUE(deaf->set_filters(accept_all));
    constexpr std::uint32_t capacity = 512;
    for (std::uint32_t id = 0; id < capacity; ++id) {
        EXPECT_TRUE(std::holds_alternative<TransmitResult>(sender->send(Frame::standard(id, {}))));
        EXPECT_TRUE(reader->poll());
    }
    EXPECT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x7FF, {}))));
    EXPECT_TRUE(receives(*reader, 0x7FF));
    // Who was waited for in vain does not spoil it for the others.
    EXPECT_TRUE(std::holds_alternative<TransmitResult>(sender->send(Frame::standard(1, {}))) ||
                receives(*reader, 1));
}

TEST(LocalLink, HasThePaceOfWhoOpenedItFirst) {
    const auto first = opened("local:pace?paced=no");
    EXPECT_TRUE(open_link("local:pace"));
    EXPECT_TRUE(open_link("local:pace?paced=no"));
    const auto other = open_link("local:pace?paced=yes");
    ASSERT_FALSE(other);
    EXPECT_THAT(other.error(), testing::HasSubstr("local:pace is not paced"));
}

TEST(LocalLink, HasTheBitrateOfWhoOpenedItFirst) {
    auto first = opened("local:rate?bitrate=125000");
    EXPECT_EQ(attached(*first)->capabilities().bitrate, 125'000U);
    EXPECT_EQ(attached(*opened("local:rate"))->capabilities().bitrate, 125'000U);
    const auto other = open_link("local:rate?bitrate=250000");
    ASSERT_FALSE(other);
    EXPECT_THAT(other.error(), testing::HasSubstr("runs at 125000 bit/s, not at 250000"));
    first.reset();
    EXPECT_EQ(attached(*opened("local:rate"))->capabilities().bitrate, 500'000U)
        << "a bus that nobody uses is gone";
}

TEST(LocalLink, KeepsToTheClock) {
    const auto link = opened("local:clock");
    const auto sender = attached(*link);
    const auto receiver = attached(*link);
    const TimePoint before = link->now();
    EXPECT_TRUE(std::holds_alternative<TransmitHandle>(sender->send(Frame::standard(0x555, {}))));
    pollfd descriptor{sender->event_fd(), POLLIN, 0};
    ASSERT_EQ(::poll(&descriptor, 1, 20'000), 1);
    const TimePoint after = link->now();
    const auto event = sender->poll();
    ASSERT_TRUE(event);
    const TimePoint end = std::get<TransmitResult>(*event).time;
    EXPECT_GE(end - before, std::chrono::microseconds{90});  // 45 bits at 500 kbit/s
    EXPECT_LE(end, after);
}

}  // namespace
}  // namespace canorb::can
