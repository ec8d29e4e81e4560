// Each frame of a message doubled, lost, or swapped with its neighbour: never a call with wrong
// parameters, never one twice, and the next message works.

#include <deque>

#include "tests/runtime/forwarding_controller.hpp"
#include "tests/runtime/world.hpp"

namespace canorb::test {
namespace {

enum class Fault { none, doubled, lost, swapped };

/// What happens to the frames that one controller receives.
struct Plan {
    Fault fault = Fault::none;
    int frame = 0;  ///< to the frame with this number, from 0
    int seen = 0;
};

class FaultyController final : public ForwardingController {
  public:
    FaultyController(std::unique_ptr<can::Controller> real, Plan& plan)
        : ForwardingController(std::move(real)), plan_(plan) {}

    std::optional<can::ControllerEvent> poll() override {
        while (auto event = ForwardingController::poll()) {
            if (!std::holds_alternative<can::Received>(*event)) {
                ready_.push_back(*event);
                continue;
            }
            if (plan_.seen++ == plan_.frame) {
                if (plan_.fault == Fault::lost) continue;
                if (plan_.fault == Fault::doubled) ready_.push_back(*event);
                if (plan_.fault == Fault::swapped) {
                    held_ = *event;
                    continue;
                }
            }
            ready_.push_back(*event);
            if (held_) ready_.push_back(*std::exchange(held_, std::nullopt));
        }
        if (ready_.empty()) return std::nullopt;
        can::ControllerEvent event = ready_.front();
        ready_.pop_front();
        return event;
    }

  private:
    Plan& plan_;
    std::deque<can::ControllerEvent> ready_;
    std::optional<can::ControllerEvent> held_;
};

class FaultyBus final : public Bus {
  public:
    FaultyBus(Bus& real, Plan& plan) : real_(real), plan_(plan) {}
    std::unique_ptr<can::Controller> attach(std::string_view name) override {
        return std::make_unique<FaultyController>(real_.attach(name), plan_);
    }
    TimePoint now() const override { return real_.now(); }
    Simulation* simulation() override { return real_.simulation(); }

  private:
    Bus& real_;
    Plan& plan_;
};

class Faults : public World,
               public testing::WithParamInterface<std::tuple<Fault, int, bool, std::size_t>> {};

TEST_P(Faults, NeverGiveACallWrongParameters) {
    const auto [fault, frame, at_server, size] = GetParam();
    Plan plan;
    FaultyBus faulty{bus, plan};
    Orb server{at_server ? static_cast<Bus&>(faulty) : bus, node(1)};
    Orb client{at_server ? bus : static_cast<Bus&>(faulty), node(2)};
    std::vector<std::uint8_t> sent(size);
    for (std::size_t i = 0; i < size; ++i) sent[i] = static_cast<std::uint8_t>(i + 1);
    TestServant servant{{{1, [&](ServerCall& call) {
                              const Bytes octets = call.remaining_parameters();
                              EXPECT_THAT(octets, testing::ElementsAreArray(sent));
                              call.reply(RawOctets{sent});
                          }}}};
    server.root_poa().activate_object_with_id(1, servant);
    const ObjectRef target = at(client, 1, 1).with_timeout(50ms);

    plan = {fault, frame};
    bool answered = false;
    try {
        EXPECT_EQ(target.invoke(1, sent), sent);
        answered = true;
    } catch (const TIMEOUT& exception) {
        EXPECT_EQ(exception.completed(), Completion::maybe);
    }
    EXPECT_LE(servant.calls, 1);
    if (fault != Fault::swapped) {
        EXPECT_EQ(answered, fault == Fault::doubled);
    }

    plan = {};
    const int before = servant.calls;
    EXPECT_EQ(target.invoke(1, sent), sent);
    EXPECT_EQ(servant.calls, before + 1);
}

// 20 octets: 4 frames there, 4 back. 0: one frame each way.
INSTANTIATE_TEST_SUITE_P(EachFrame, Faults,
                         testing::Combine(testing::Values(Fault::doubled, Fault::lost),
                                          testing::Values(0, 1, 2, 3), testing::Bool(),
                                          testing::Values(std::size_t{20})));
INSTANTIATE_TEST_SUITE_P(Neighbours, Faults,
                         testing::Combine(testing::Values(Fault::swapped), testing::Values(0, 1, 2),
                                          testing::Bool(), testing::Values(std::size_t{20})));
INSTANTIATE_TEST_SUITE_P(OneFrame, Faults,
                         testing::Combine(testing::Values(Fault::doubled, Fault::lost),
                                          testing::Values(0), testing::Bool(),
                                          testing::Values(std::size_t{0})));

}  // namespace
}  // namespace canorb::test
