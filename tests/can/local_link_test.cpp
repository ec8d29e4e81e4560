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
