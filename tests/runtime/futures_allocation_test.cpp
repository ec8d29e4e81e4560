// A call with a future touches the heap no more once it has been made a few times.

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <tuple>

#include "canorb/orb.hpp"
#include "canorb/stub.hpp"
#include "orb/base/fifo.hpp"
#include "orb/can/link/descriptor.hpp"
#include "tests/support/allocations.hpp"

namespace canorb::test {
namespace {

using Text = BoundedString<20>;

constexpr InterfaceInfo lamp{"IDL:Test/Lamp:1.0"};
constexpr OperationInfo label{&lamp, 1, "label"};

/// A controller on whose bus node 3 answers each Request of two frames at once: with the octet 7
/// and the text "A".
class AnsweringController final : public can::Controller {
  public:
    can::Capabilities capabilities() const override { return {.filter_list = 8}; }
    can::SendResult send(const can::Frame& frame, can::SendOptions) override {
        const Bytes payload = frame.payload();
        if (payload[0] == 0x10) {
            request_id_ = {payload[3], payload[4]};
        } else {
            const std::array<std::uint8_t, 8> first{0x11,           0, 7, request_id_[0],
                                                    request_id_[1], 0, 7, 2};
            const std::array<std::uint8_t, 3> second{0x81, 'A', 0};
            receive(first);
            receive(second);
        }
        return can::TransmitResult{
            can::TransmitHandle{++last_frame_}, can::TransmitOutcome::sent, {}};
    }
    void abort(can::TransmitHandle) override {}
    bool set_filters(std::span<const can::Filter>) override { return true; }
    bool set_listen_only(bool) override { return false; }
    can::ErrorStatus error_status() const override { return {}; }
    std::optional<std::string> recover() override { return {}; }
    std::optional<can::ControllerEvent> poll() override {
        auto event = events_.pop();
        if (!event) signal_.clear();
        return event;
    }
    int event_fd() const override { return signal_.fd(); }

  private:
    void receive(Bytes payload) {
        events_.push(can::Received{can::Frame::standard(0x4A3, payload), {}});
        signal_.raise();
    }

    Fifo<can::ControllerEvent> events_{64};
    const can::Signal signal_;
    std::array<std::uint8_t, 2> request_id_{};
    std::uint64_t last_frame_ = 0;
};

class AnsweringBus final : public Bus {
  public:
    std::unique_ptr<can::Controller> attach(std::string_view) override {
        return std::make_unique<AnsweringController>();
    }
    /// It stands still, so that nothing ends by time.
    TimePoint now() const override { return TimePoint{std::chrono::seconds{1}}; }
};

using Labelled = std::tuple<std::uint8_t, Text>;

Future<Labelled> sendp_label(const ObjectRef& target, const Text& text) {
    return send_request<Returns<std::uint8_t, Text>>(target, label, text);
}

/// Two calls at once, answered; and one that is cancelled when it is sent.
int round(const ObjectRef& target) {
    Future<Labelled> first = sendp_label(target, Text{""});
    Future<Labelled> second = sendp_label(target, Text{""});
    sendp_label(target, Text{""}).cancel();
    int right = 0;
    for (Future<Labelled>* future : {&second, &first}) {
        right += future->wait_for(std::chrono::hours{1}) ? 1 : 0;
        right += future->get() == Labelled{7, "A"} ? 1 : 0;
    }
    return right;
}

TEST(FuturesAllocation, NoneForACallOnceWarm) {
    AnsweringBus bus;
    Orb orb{bus, {.node = 5}};
    const ObjectRef target = orb.string_to_object("corbaloc:caniop:3/1");
    for (int i = 0; i < 10; ++i) ASSERT_EQ(round(target), 4);
    const std::size_t before = allocations;
    int right = 0;
    for (int i = 0; i < 100; ++i) right += round(target);
    EXPECT_EQ(allocations - before, 0U);
    EXPECT_EQ(right, 400);
    EXPECT_EQ(orb.counters()[Counter::replies_to_cancelled_calls], 110U);
}

}  // namespace
}  // namespace canorb::test
