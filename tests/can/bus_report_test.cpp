// What a report says of a bus, in virtual time: 123#DEADBEEF00000000 takes 115 bits and 3 of
// intermission, at 1 Mbit/s a microsecond each.

#include "orb/can/link/bus_report.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "orb/can/sim/controller.hpp"
#include "tests/support/octets.hpp"

namespace canorb::can {
namespace {

using namespace std::chrono_literals;

class BusReports : public testing::Test {
  protected:
    BusReports() {
        sender_.emplace(bus_, named("sender"));
        receiver_.emplace(bus_, named("receiver"));
        frame_ = Frame::standard(0x123, canorb::test::octets("DEADBEEF00000000"));
    }

    static sim::NodeOptions named(const std::string& name) {
        sim::NodeOptions options;
        options.name = name;
        return options;
    }

    void send() { ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender_->send(frame_))); }
    void advance_to(Duration since_start) {
        bus_.advance(start_ + since_start);
        reporter_.sample();
        while (sender_->poll()) continue;
        while (receiver_ && receiver_->poll()) continue;
    }
    /// Frame after frame, as often as a daemon would wake.
    void saturate_until(Duration since_start) {
        send();
        while (bus_.now() < start_ + since_start) {
            send();
            advance_to(bus_.next_event() - start_);
        }
    }
    BusReport report() const {
        const std::array<sim::NodeIndex, 2> nodes{sender_->node(), receiver_->node()};
        return reporter_.report(nodes);
    }

    const TimePoint start_ = TimePoint{12345678900ns};
    sim::Bus bus_{1'000'000, start_};
    BusReporter reporter_{bus_};
    std::optional<sim::Controller> sender_;
    std::optional<sim::Controller> receiver_;
    Frame frame_;
};

TEST_F(BusReports, AtTheStart) {
    const BusReport first = report();
    EXPECT_EQ(first.bitrate, 1'000'000U);
    EXPECT_EQ(first.bus.time, start_);
    EXPECT_EQ(first.bus.bits, 0U);
    EXPECT_EQ(first.bus.busy_bits, 0U);
    EXPECT_EQ(first.bus.recent_bits, 0U);
    EXPECT_EQ(first.bus.nodes, 2);
    ASSERT_EQ(first.nodes.size(), 2U);
    EXPECT_EQ(first.nodes[0].name, "sender");
    EXPECT_EQ(first.nodes[1].name, "receiver");
}

TEST_F(BusReports, CountsFromSofToTheEndOfTheIntermission) {
    send();
    advance_to(100us);
    EXPECT_EQ(report().bus.busy_bits, 100U);
    advance_to(115us);
    EXPECT_EQ(report().bus.frames, 1U);
    advance_to(117us);
    EXPECT_EQ(report().bus.busy_bits, 117U);
    advance_to(300us);
    const BusReport after = report();
    EXPECT_EQ(after.bus.bits, 300U);
    EXPECT_EQ(after.bus.busy_bits, 118U);
    EXPECT_EQ(after.bus.recent_bits, 300U);
    EXPECT_EQ(after.bus.recent_busy_bits, 118U);
    EXPECT_EQ(after.nodes[0].sent, 1U);
    EXPECT_EQ(after.nodes[1].received, 1U);
    EXPECT_EQ(after.nodes[1].status, ErrorStatus{});
}

TEST_F(BusReports, ASaturatedBusHasNoIdleBit) {
    saturate_until(2500ms);
    const BusReport full = report();
    EXPECT_GE(full.bus.bits, 2'500'000U);
    EXPECT_EQ(full.bus.busy_bits, full.bus.bits);
    EXPECT_EQ(full.bus.recent_bits, 1'000'000U);
    EXPECT_EQ(full.bus.recent_busy_bits, 1'000'000U);
}

TEST_F(BusReports, KnowTheLastSecondAfterALongRest) {
    saturate_until(1s);
    advance_to(1s + 1ms);                               // what still waited is sent
    const std::uint64_t busy = report().bus.busy_bits;  // without a break from the start
    EXPECT_GE(busy, 1'000'000U);
    advance_to(1500ms);
    EXPECT_EQ(report().bus.busy_bits, busy);
    // The second began between two samples.
    EXPECT_NEAR(static_cast<double>(report().bus.recent_busy_bits),
                static_cast<double>(busy - 500'000), 1);
    advance_to(60s);
    EXPECT_EQ(report().bus.recent_bits, 1'000'000U);
    EXPECT_EQ(report().bus.recent_busy_bits, 0U);
    EXPECT_EQ(report().bus.busy_bits, busy);
}

// At rates whose bit time is no whole number of nanoseconds, too.
TEST_F(BusReports, AreNeverBusierThanTheyAreOld) {
    for (const std::uint32_t bitrate : {300'000U, 333'333U, 123'457U, 999'983U, 5'000U}) {
        sim::Bus bus{bitrate, start_};
        BusReporter reporter{bus};
        sim::Controller sender{bus};
        const sim::Controller receiver{bus};
        for (int frame = 0; frame < 3; ++frame) {
            ASSERT_TRUE(std::holds_alternative<TransmitHandle>(sender.send(frame_)));
        }
        const TimePoint end = start_ + 118 * 3 * Duration{1s} / bitrate;
        while (bus.now() < end) {
            bus.advance(bus.now() + 777ns);
            reporter.sample();
            const BusReport report = reporter.report({});
            ASSERT_LE(report.bus.busy_bits, report.bus.bits) << bitrate;
            ASSERT_LE(report.bus.recent_busy_bits, report.bus.recent_bits) << bitrate;
            ASSERT_GE(report.bus.busy_bits + 1, report.bus.bits) << bitrate;
        }
        EXPECT_EQ(reporter.report({}).bus.busy_bits, 354U);
    }
}

// The second begins in the middle of what went before, long ago.
TEST_F(BusReports, KnowWhereASecondBeganThatNobodySampled) {
    advance_to(10s);
    send();
    advance_to(10s + 118us);
    advance_to(10s + 900ms);
    EXPECT_EQ(report().bus.recent_busy_bits, 118U);
    advance_to(11s + 1ms);
    EXPECT_EQ(report().bus.recent_busy_bits, 0U);
}

TEST_F(BusReports, CountErrorsAndLostArbitrations) {
    Frame lower = frame_;
    lower.id = 0x001;
    send();
    ASSERT_TRUE(std::holds_alternative<TransmitHandle>(receiver_->send(lower)));
    advance_to(10ms);
    const BusReport after = report();
    EXPECT_EQ(after.bus.frames, 2U);
    EXPECT_EQ(after.nodes[0].lost_arbitrations, 1U);
    EXPECT_EQ(after.nodes[1].lost_arbitrations, 0U);
    EXPECT_EQ(after.nodes[0].received, 1U);
    EXPECT_EQ(after.nodes[1].sent, 1U);
    receiver_.reset();  // nobody acknowledges
    send();
    advance_to(20ms);
    const std::array<sim::NodeIndex, 1> alone{sender_->node()};
    const BusReport lone = reporter_.report(alone);
    EXPECT_EQ(lone.nodes[0].status.state, ControllerState::error_passive);
    EXPECT_EQ(lone.nodes[0].status.tec, 128);
    EXPECT_GE(lone.nodes[0].errors, 16U);
    EXPECT_EQ(lone.bus.error_frames, lone.nodes[0].errors);
}

}  // namespace
}  // namespace canorb::can
