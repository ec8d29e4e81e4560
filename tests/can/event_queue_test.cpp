#include "orb/can/sim/event_queue.hpp"

#include <gtest/gtest.h>

namespace canorb::can::sim {
namespace {

using namespace std::chrono_literals;

Received received(std::uint32_t id) {
    return Received{Frame::standard(id, {}), TimePoint{}};
}

TransmitResult result(std::uint64_t handle) {
    return TransmitResult{TransmitHandle{handle}, TransmitOutcome::sent, TimePoint{}};
}

StateChanged change(ControllerState state) {
    return StateChanged{{.state = state}, TimePoint{}};
}

std::uint32_t id_of(const std::optional<ControllerEvent>& event) {
    return std::get<Received>(event.value()).frame.id;
}

std::uint64_t lost_of(const std::optional<ControllerEvent>& event) {
    return std::get<FramesLost>(event.value()).count;
}

TEST(EventQueue, KeepsTheOrder) {
    EventQueue queue{10};
    EXPECT_TRUE(queue.empty());
    queue.push(received(1));
    queue.push(result(7));
    queue.push(change(ControllerState::error_passive));
    queue.push(received(2));
    EXPECT_EQ(queue.received(), 2U);
    EXPECT_EQ(queue.results(), 1U);
    EXPECT_EQ(id_of(queue.pop()), 1U);
    EXPECT_EQ(std::get<TransmitResult>(queue.pop().value()).handle, TransmitHandle{7});
    EXPECT_EQ(std::get<StateChanged>(queue.pop().value()).status.state,
              ControllerState::error_passive);
    EXPECT_EQ(id_of(queue.pop()), 2U);
    EXPECT_EQ(queue.pop(), std::nullopt);
    EXPECT_EQ(queue.received() + queue.results(), 0U);
}

TEST(EventQueue, CountsTheFramesBeyondItsCapacityInOneEvent) {
    EventQueue queue{2};
    for (std::uint32_t id = 1; id <= 5; ++id) queue.push(received(id));
    EXPECT_TRUE(queue.receive_full());
    EXPECT_EQ(queue.lost(), 3U);
    EXPECT_EQ(id_of(queue.pop()), 1U);
    queue.push(received(6));
    EXPECT_EQ(id_of(queue.pop()), 2U);
    EXPECT_EQ(lost_of(queue.pop()), 3U);
    EXPECT_EQ(id_of(queue.pop()), 6U);
    EXPECT_TRUE(queue.empty());
}

TEST(EventQueue, LossesBeforeAndAfterAFrameAreToldApart) {
    EventQueue queue{1};
    queue.push(received(1));
    queue.push(received(2));
    EXPECT_EQ(id_of(queue.pop()), 1U);
    queue.push(received(3));
    queue.push(received(4));
    queue.push(received(5));
    EXPECT_EQ(lost_of(queue.pop()), 1U);
    EXPECT_EQ(id_of(queue.pop()), 3U);
    EXPECT_EQ(lost_of(queue.pop()), 2U);
    queue.push(received(6));
    EXPECT_EQ(id_of(queue.pop()), 6U);
}

TEST(EventQueue, DoubtsFoldIntoOneEventAndIntoALoss) {
    EventQueue queue{1};
    queue.push_doubt(TimePoint{1ms});
    queue.push(change(ControllerState::error_passive));
    queue.push_doubt(TimePoint{2ms});
    queue.push(change(ControllerState::error_passive));
    queue.push(received(1));
    queue.push_doubt(TimePoint{3ms});
    queue.push(received(2));
    const auto doubt = queue.pop();
    EXPECT_EQ(lost_of(doubt), 0U);
    EXPECT_EQ(std::get<FramesLost>(doubt.value()).time, TimePoint{1ms});
    EXPECT_TRUE(std::holds_alternative<StateChanged>(queue.pop().value()));
    EXPECT_EQ(id_of(queue.pop()), 1U);
    EXPECT_EQ(lost_of(queue.pop()), 1U);
    EXPECT_TRUE(queue.empty());
    EXPECT_EQ(queue.lost(), 1U);
}

TEST(EventQueue, ALossAfterItsEventWasTakenIsANewEvent) {
    EventQueue queue{1};
    queue.push(received(1));
    queue.push(received(2));
    queue.push(result(1));
    EXPECT_EQ(id_of(queue.pop()), 1U);
    EXPECT_EQ(lost_of(queue.pop()), 1U);
    queue.push(received(3));
    queue.push(received(4));
    EXPECT_TRUE(std::holds_alternative<TransmitResult>(queue.pop().value()));
    EXPECT_EQ(id_of(queue.pop()), 3U);
    EXPECT_EQ(lost_of(queue.pop()), 1U);
}

TEST(EventQueue, TellsOnlyTheLatestOfTwoChangesInARow) {
    EventQueue queue{1};
    queue.push(change(ControllerState::error_passive));
    queue.push(change(ControllerState::error_active));
    EXPECT_EQ(std::get<StateChanged>(queue.pop().value()).status.state,
              ControllerState::error_active);
    EXPECT_TRUE(queue.empty());
}

TEST(EventQueue, GrowsForResultsAndKeepsTheOrder) {
    EventQueue queue{1};
    for (std::uint64_t i = 0; i < 10; ++i) queue.push(result(i));
    for (std::uint64_t i = 0; i < 10; ++i) ASSERT_TRUE(queue.pop());
    for (std::uint64_t i = 0; i < 100; ++i) queue.push(result(i));
    for (std::uint64_t i = 0; i < 100; ++i) {
        EXPECT_EQ(std::get<TransmitResult>(queue.pop().value()).handle, TransmitHandle{i});
    }
}

}  // namespace
}  // namespace canorb::can::sim
