// Faults on a whole bus, by script: who detects what, who gets which frame how often, and the bits.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "orb/can/sim/fault_injector.hpp"
#include "tests/can/bus_fixture.hpp"

namespace canorb::can::sim {
namespace {

using namespace test;

/// 115 bits from SOF to the end of EOF: the CRC delimiter is bit 106, EOF bits 109 to 115.
Frame frame_123() {
    return standard(0x123, "DE AD BE EF 00 00 00 00");
}

std::string example(const std::string& name) {
    std::ifstream file{std::filesystem::path{CANORB_FAULT_EXAMPLES} / name};
    EXPECT_TRUE(file.is_open()) << name;
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

FaultScript parse(const std::string& text) {
    auto script = parse_fault_script(text);
    if (script) return *script;
    for (const FaultScriptError& error : script.error()) ADD_FAILURE() << format(error);
    return {};
}

/// The wire as text, one character for each bit.
class WireRecorder : public BitObserver {
  public:
    void node_attached(NodeIndex, std::string_view) override {}
    void node_detached(NodeIndex) override {}
    void bit(const BusBit& bit) override {
        const auto number = static_cast<std::size_t>(bit.start.time_since_epoch() / bits(1));
        levels_.resize(number, '1');
        levels_ += bit.bus == 0 ? '0' : '1';
    }
    /// Bits `first` to `last`, counted from 1.
    std::string between(std::size_t first, std::size_t last) {
        levels_.resize(std::max(levels_.size(), last), '1');
        return levels_.substr(first - 1, last - first + 1);
    }

  private:
    std::string levels_;
};

/// A pump and two valves at 500 kbit/s, on a bus with faults.
class Plant {
  public:
    explicit Plant(const std::string& script) : faults{parse(script), 500'000} {
        bus.set_disturbance(&faults);
        bus.set_error_trace([this](const NodeError& error) {
            if (error.primary) primary_errors.push_back(error);
        });
    }

    void record() { bus.set_bit_observer(&wire); }

    void run_for(Duration time) {
        bus.advance(bus.now() + time);
        for (TestNode* node : {&pump, &left, &right}) node->drain();
    }

    FaultInjector faults;
    WireRecorder wire;
    Bus bus{500'000};
    std::vector<NodeError> primary_errors;
    TestNode pump{bus, {.name = "pump-3"}};
    TestNode left{bus, {.name = "valve-left"}};
    TestNode right{bus, {.name = "valve-right"}};
};

std::vector<TimePoint> times(const TestNode& node) {
    std::vector<TimePoint> result;
    for (const Received& each : node.received) {
        EXPECT_EQ(each.frame, frame_123());
        result.push_back(each.time);
    }
    return result;
}

using Times = std::vector<TimePoint>;

// ---- the two traps, and their harmless relatives

TEST(FaultTraps, ADominantLastButOneBitAtOneReceiverMakesTheOthersGetTheFrameTwice) {
    Plant plant{example("same-frame-twice.fault")};
    plant.record();
    plant.pump.must_send(frame_123());
    plant.run_for(bits(400));

    EXPECT_EQ(plant.wire.between(106, 114), "101111111")
        << "CRC delimiter to the last but one bit of EOF";
    EXPECT_EQ(plant.wire.between(115, 121), "0000000")
        << "flag of valve-left, and of the others after it";
    EXPECT_EQ(plant.wire.between(122, 132), "11111111111") << "delimiter, intermission";
    EXPECT_EQ(plant.wire.between(133, 246), plant.wire.between(1, 114)) << "the frame again";
    EXPECT_EQ(plant.wire.between(247, 400), std::string(154, '1'));

    EXPECT_EQ(times(plant.left), (Times{at(bits(247))})) << "once, the second";
    EXPECT_EQ(times(plant.right), (Times{at(bits(115)), at(bits(247))})) << "twice";
    EXPECT_EQ(plant.pump.results.size(), 1U);
    EXPECT_EQ(plant.pump.results[0].outcome, TransmitOutcome::sent);
    EXPECT_EQ(plant.pump.results[0].time, at(bits(247)));

    ASSERT_EQ(plant.primary_errors.size(), 1U);
    EXPECT_EQ(plant.primary_errors[0].node, plant.left.node());
    EXPECT_EQ(plant.primary_errors[0].time, at(bits(114)));
    EXPECT_EQ(plant.primary_errors[0].capture,
              (ErrorCapture{ErrorKind::form, {FrameField::end_of_frame, 5}, false}));
    EXPECT_EQ(plant.pump.error_status().tec, 8 - 1);
    EXPECT_EQ(plant.left.error_status().rec, 1 + 8 - 1)
        << "the flags of the others follow its own: it was first";
    EXPECT_EQ(plant.right.error_status().rec, 0) << "an overload, no error";
    EXPECT_TRUE(plant.faults.unused().empty());
}

TEST(FaultTraps, IfTheSenderThenDiesOnlySomeGetTheFrame) {
    Plant plant{example("frame-only-some-got.fault")};
    plant.record();
    plant.pump.must_send(frame_123());
    plant.run_for(bits(400));

    EXPECT_EQ(plant.wire.between(106, 114), "101111111");
    EXPECT_EQ(plant.wire.between(115, 121), "0000000");
    EXPECT_EQ(plant.wire.between(122, 400), std::string(279, '1')) << "nobody repeats it";

    EXPECT_EQ(times(plant.left), Times{}) << "never";
    EXPECT_EQ(times(plant.right), (Times{at(bits(115))})) << "once";
    EXPECT_EQ(plant.left.error_status().rec, 1 + 8);
    EXPECT_EQ(plant.right.error_status().rec, 0);
    EXPECT_TRUE(plant.faults.unused().empty());

    // The pump is dead for all: it sends and hears nobody.
    plant.left.must_send(standard(0x200));
    plant.run_for(1ms);
    EXPECT_TRUE(plant.pump.received.empty());
    EXPECT_EQ(plant.right.received.size(), 2U);
}

TEST(FaultTraps, ADominantLastBitAtTheSenderMakesAllReceiversGetTheFrameTwice) {
    Plant plant{example("last-bit-of-eof.fault")};
    plant.record();
    plant.pump.must_send(frame_123());
    plant.run_for(bits(400));

    EXPECT_EQ(plant.wire.between(109, 115), "1111111") << "the wire's EOF is intact";
    EXPECT_EQ(plant.wire.between(116, 122), "0000000") << "error flag, then overload flags";
    EXPECT_EQ(plant.wire.between(123, 133), "11111111111");
    EXPECT_EQ(plant.wire.between(134, 248), plant.wire.between(1, 115));

    for (const TestNode* node : {&plant.left, &plant.right}) {
        EXPECT_EQ(times(*node), (Times{at(bits(115)), at(bits(248))}));
        EXPECT_EQ(node->error_status().rec, 0);
    }
    EXPECT_EQ(plant.pump.error_status().tec, 8 - 1);
}

TEST(FaultTraps, ADominantLastBitAtAReceiverIsHarmless) {
    Plant plant{"frame 123 at eof.7 dominant valve-left"};
    plant.record();
    plant.pump.must_send(frame_123());
    plant.run_for(bits(400));

    EXPECT_EQ(plant.wire.between(109, 115), "1111111");
    EXPECT_EQ(plant.wire.between(116, 122), "0000000") << "overload flags of all";
    EXPECT_EQ(plant.wire.between(123, 400), std::string(278, '1'));

    for (const TestNode* node : {&plant.left, &plant.right}) {
        EXPECT_EQ(times(*node), (Times{at(bits(115))})) << "once";
    }
    for (const TestNode* node : {&plant.pump, &plant.left, &plant.right}) {
        EXPECT_EQ(node->error_status(), ErrorStatus{});
    }
    EXPECT_TRUE(plant.primary_errors.empty());
    EXPECT_EQ(plant.faults.acted(0), 1U);
}

// ---- every kind of fault, end to end

TEST(Faults, AFlippedBitOnTheWireCostsOneAttempt) {
    Plant plant{"frame 123 attempt 1 at data.3 flip wire"};
    plant.pump.must_send(frame_123());
    plant.run_for(1ms);
    ASSERT_EQ(plant.primary_errors.size(), 1U);
    EXPECT_EQ(plant.primary_errors[0].node, plant.pump.node());
    EXPECT_EQ(plant.primary_errors[0].capture,
              (ErrorCapture{ErrorKind::bit, {FrameField::data, 2}, true}));
    EXPECT_EQ(plant.left.received.size(), 1U);
    EXPECT_EQ(plant.right.received.size(), 1U);
}

TEST(Faults, TheFiveKindsOfError) {
    Plant plant{example("each-kind-of-error.fault")};
    plant.pump.must_send(frame_123());
    plant.run_for(4ms);
    std::vector<std::pair<ErrorKind, NodeIndex>> errors;
    for (const NodeError& error : plant.primary_errors) {
        errors.emplace_back(error.capture.kind, error.node);
    }
    EXPECT_EQ(errors, (std::vector<std::pair<ErrorKind, NodeIndex>>{
                          {ErrorKind::bit, plant.pump.node()},
                          {ErrorKind::stuff, plant.left.node()},
                          {ErrorKind::crc, plant.left.node()},
                          {ErrorKind::form, plant.left.node()},
                          {ErrorKind::acknowledgment, plant.pump.node()},
                      }));
    EXPECT_EQ(plant.left.received.size(), 1U);
    EXPECT_EQ(plant.right.received.size(), 1U);
    EXPECT_TRUE(plant.faults.unused().empty());
}

TEST(Faults, EveryFrameOfOneNodeDisturbed) {
    Plant plant{example("destroy-one-sender.fault")};
    plant.pump.must_send(frame_123());
    plant.right.must_send(standard(0x200, "01 02"));
    plant.run_for(20ms);
    EXPECT_EQ(plant.faults.acted(0), 32U) << "16 attempts to error passive, 16 to bus-off";
    EXPECT_EQ(plant.pump.error_status().state, ControllerState::bus_off);
    ASSERT_EQ(plant.pump.results.size(), 1U);
    EXPECT_EQ(plant.pump.results[0].outcome, TransmitOutcome::failed);
    EXPECT_EQ(plant.left.received_ids(), std::vector<std::uint32_t>{0x200});
}

TEST(Faults, SixteenDisturbedAttemptsMakeANodeErrorPassive) {
    Plant plant{example("error-passive.fault")};
    plant.pump.must_send(frame_123());
    plant.run_for(20ms);
    ASSERT_EQ(plant.pump.states.size(), 2U);
    EXPECT_EQ(plant.pump.states[0].status.state, ControllerState::error_passive);
    EXPECT_EQ(plant.pump.states[0].status.tec, 128);
    EXPECT_EQ(plant.pump.states[1].status.tec, 127) << "the 17th attempt gets through";
    EXPECT_EQ(plant.left.received.size(), 1U);
}

TEST(Faults, NoAcknowledgment) {
    Plant plant{example("no-acknowledgment.fault")};
    plant.pump.must_send(frame_123());
    plant.run_for(5ms);
    ASSERT_FALSE(plant.primary_errors.empty());
    EXPECT_EQ(plant.primary_errors[0].capture.kind, ErrorKind::acknowledgment);
    EXPECT_TRUE(plant.left.received.empty());
    EXPECT_TRUE(plant.pump.results.empty());
}

TEST(Faults, ATransmitterThatSticks) {
    Plant plant{"at 1ms stuck-dominant pump-3 for 100 bits"};
    plant.record();
    plant.run_for(1ms);
    plant.left.must_send(standard(0x200));
    plant.run_for(5ms);
    EXPECT_EQ(plant.wire.between(501, 601), std::string(100, '0') + "1");
    EXPECT_EQ(plant.right.received.size(), 1U) << "afterwards";
    EXPECT_GT(plant.left.error_status().rec, 8) << "so many dominant bits after its error flag";
    EXPECT_EQ(plant.faults.acted(0), 1U);
}

TEST(Faults, AShortedWire) {
    Plant plant{"at 100 bits stuck-dominant wire"};
    plant.run_for(1ms);
    plant.left.must_send(standard(0x200));
    plant.run_for(50ms);
    EXPECT_TRUE(plant.right.received.empty());
    EXPECT_EQ(plant.bus.statistics().frames, 0U);
}

TEST(Faults, ForcedLevelsAtNodes) {
    Plant plant{
        "at 100 bits dominant valve-left for 20 bits\n"
        "at 1ms recessive valve-left for 500us\n"};
    plant.run_for(500us);
    ASSERT_FALSE(plant.primary_errors.empty());
    EXPECT_EQ(plant.primary_errors[0].node, plant.left.node());
    EXPECT_EQ(plant.primary_errors[0].capture.kind, ErrorKind::stuff) << "six dominant bits";
    plant.run_for(500us);
    plant.pump.must_send(frame_123());
    plant.run_for(2ms);
    EXPECT_EQ(times(plant.left), Times{}) << "it was deaf";
    EXPECT_EQ(times(plant.right).size(), 1U);
}

TEST(Faults, ANodeThatIsCutOffAndComesBack) {
    Plant plant{"at 1ms cut-off pump-3\nat 20ms reconnect pump-3"};
    plant.run_for(1100us);
    plant.left.must_send(standard(0x200));
    plant.pump.must_send(frame_123());
    plant.run_for(10ms);
    EXPECT_TRUE(plant.pump.received.empty());
    EXPECT_EQ(plant.right.received_ids(), std::vector<std::uint32_t>{0x200});
    EXPECT_EQ(plant.pump.error_status().state, ControllerState::error_passive)
        << "nobody acknowledges";
    EXPECT_EQ(plant.left.error_status(), ErrorStatus{}) << "nobody else notices";
    plant.run_for(20ms);
    EXPECT_EQ(plant.right.received_ids(), (std::vector<std::uint32_t>{0x200, 0x123}));
    ASSERT_EQ(plant.pump.results.size(), 1U);
    EXPECT_EQ(plant.pump.results[0].outcome, TransmitOutcome::sent);
    EXPECT_TRUE(plant.faults.unused().empty());
}

TEST(Faults, ANodeIsCutOffInTheMiddleOfItsFrame) {
    Plant plant{"frame 123 at data.9 cut-off pump-3 for 300us"};
    plant.pump.must_send(frame_123());
    plant.run_for(2ms);
    ASSERT_FALSE(plant.primary_errors.empty());
    EXPECT_EQ(plant.primary_errors[0].capture.kind, ErrorKind::stuff);
    EXPECT_NE(plant.primary_errors[0].node, plant.pump.node()) << "six recessive bits";
}

TEST(Faults, IntermissionCanBeDisturbed) {
    Plant plant{"frame 123 at intermission.1 dominant wire"};
    plant.record();
    plant.pump.must_send(frame_123());
    plant.run_for(1ms);
    EXPECT_EQ(plant.wire.between(109, 122), "11111110000000") << "an overload frame";
    EXPECT_EQ(plant.wire.between(123, 200), std::string(78, '1'));
    EXPECT_EQ(times(plant.left).size(), 1U);
    EXPECT_TRUE(plant.primary_errors.empty());
}

TEST(Faults, ADominantBitOnAnIdleBus) {
    Plant plant{"at 1ms flip wire"};
    plant.run_for(2ms);
    ASSERT_FALSE(plant.primary_errors.empty());
    EXPECT_EQ(plant.primary_errors[0].capture.kind, ErrorKind::stuff) << "SOF, and then nothing";
    plant.pump.must_send(frame_123());
    plant.run_for(1ms);
    EXPECT_EQ(times(plant.left).size(), 1U);
}

/// 115 bits of the frame and 3 of intermission are over at bit 150.
TEST(Faults, ABitAfterAFrameIsDisturbedWhoeverLooks) {
    for (const Fidelity fidelity : {Fidelity::frames, Fidelity::bits}) {
        Plant plant{"frame 123 at bit.150 dominant pump-3\nat 30ms recessive wire for 100 bits"};
        plant.bus.set_fidelity(fidelity);
        plant.pump.must_send(frame_123());
        plant.run_for(bits(149));
        EXPECT_EQ(plant.faults.acted(0), 0U);
        plant.run_for(bits(1));
        EXPECT_EQ(plant.faults.acted(0), 1U);
        plant.run_for(40ms);
        EXPECT_EQ(plant.faults.acted(0), 1U);
        EXPECT_EQ(plant.faults.acted(1), 1U);
    }
}

TEST(Faults, NoiseIsTheSameEachTime) {
    const auto run = [](const std::string& script) {
        Plant plant{script};
        for (int i = 0; i < 200; ++i) {
            plant.pump.must_send(frame_123());
            plant.run_for(1ms);
        }
        return std::pair{plant.primary_errors.size(), times(plant.left)};
    };
    for (const char* name : {"noisy-wire.fault", "noisy-nodes.fault"}) {
        EXPECT_EQ(run(example(name)), run(example(name)));
    }
    const auto noisy = run("bit-error-rate 1e-3 wire");
    EXPECT_GT(noisy.first, 10U);
    EXPECT_EQ(noisy, run("bit-error-rate 1e-3 wire"));
    EXPECT_NE(noisy, run("seed 2\nbit-error-rate 1e-3 wire"));
}

}  // namespace
}  // namespace canorb::can::sim
