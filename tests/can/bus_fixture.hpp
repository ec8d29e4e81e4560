#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "orb/can/sim/bus.hpp"
#include "orb/can/sim/controller.hpp"
#include "tests/can/frames.hpp"

namespace canorb::can::sim::test {

using namespace std::chrono_literals;

inline constexpr std::array<Filter, 2> everything{Filter{0, 0, false}, Filter{0, 0, true}};

/// A node that accepts everything.
class TestNode : public Controller {
  public:
    explicit TestNode(Bus& bus, const NodeOptions& options = {}) : Controller(bus, options) {
        EXPECT_TRUE(set_filters(everything));
    }

    TransmitHandle must_send(const Frame& frame, SendOptions options = {}) {
        const SendResult result = send(frame, options);
        EXPECT_TRUE(std::holds_alternative<TransmitHandle>(result));
        const auto* handle = std::get_if<TransmitHandle>(&result);
        return handle != nullptr ? *handle : TransmitHandle{};
    }

    /// Takes all events and sorts them.
    void drain() {
        while (const auto event = poll()) {
            if (const auto* frame = std::get_if<Received>(&*event)) received.push_back(*frame);
            if (const auto* done = std::get_if<TransmitResult>(&*event)) results.push_back(*done);
            if (const auto* change = std::get_if<StateChanged>(&*event)) states.push_back(*change);
            if (const auto* loss = std::get_if<FramesLost>(&*event)) lost += loss->count;
        }
    }

    std::vector<std::uint32_t> received_ids() {
        drain();
        std::vector<std::uint32_t> ids;
        for (const Received& each : received) ids.push_back(each.frame.id);
        return ids;
    }

    std::vector<Received> received;
    std::vector<TransmitResult> results;
    std::vector<StateChanged> states;
    std::uint64_t lost = 0;
};

inline TimePoint at(Duration since_start) {
    return TimePoint{} + since_start;
}

/// Bit times at 500 kbit/s.
inline Duration bits(std::int64_t count) {
    return count * 2us;
}

inline void run_until_quiet(Bus& bus) {
    while (bus.advance_one()) {
    }
}

/// Base of the tests whose outcome must not depend on how frames are simulated. 500 kbit/s.
class WithFidelity : public testing::TestWithParam<Fidelity> {
  protected:
    WithFidelity() {
        bus_.set_fidelity(GetParam());
        bus_.set_trace([this](const CompletedFrame& frame) { frames_.push_back(frame); });
        bus_.set_error_trace([this](const NodeError& error) { errors_.push_back(error); });
    }

    Bus bus_{500'000};
    std::vector<CompletedFrame> frames_;
    std::vector<NodeError> errors_;
};

inline std::string fidelity_name(const testing::TestParamInfo<Fidelity>& info) {
    return info.param == Fidelity::frames ? "Frames" : "Bits";
}

#define CANORB_WITH_BOTH_FIDELITIES(suite)                                               \
    INSTANTIATE_TEST_SUITE_P(, suite, testing::Values(Fidelity::frames, Fidelity::bits), \
                             fidelity_name)

}  // namespace canorb::can::sim::test
