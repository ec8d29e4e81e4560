#include "orb/can/sim/fault_injector.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "orb/can/sim/bus.hpp"

namespace canorb::can::sim {
namespace {

using namespace std::chrono_literals;

constexpr NodeIndex a{0};
constexpr NodeIndex b{1};
constexpr NodeIndex c{2};

TimePoint at(Duration since_start) {
    return TimePoint{since_start};
}

/// What a bit was like.
struct Bit {
    std::uint8_t wire = 1;
    std::vector<std::uint8_t> seen;
};

/// Three nodes a, b and c on a wire of 1 Mbit/s, one bit a microsecond, by hand.
class Wire {
  public:
    explicit Wire(std::string_view script, TimePoint start = TimePoint{})
        : injector{*parse_fault_script(script), 1'000'000, start}, now{start} {
        injector.node_attached(a, "a");
        injector.node_attached(b, "b");
        injector.node_attached(c, "c");
    }

    /// The next bit. `driven` has a level for each node.
    Bit bit(std::vector<std::uint8_t> driven, std::optional<FramePosition> position = {}) {
        const BitMoment moment{now, now + 1us, position};
        injector.disturb_driven(moment, driven);
        Bit result;
        for (const std::uint8_t level : driven) result.wire &= level;
        result.seen.assign(driven.size(), result.wire);
        injector.disturb_seen(moment, driven, result.seen);
        now += 1us;
        return result;
    }

    /// What the nodes see of a bit where all send recessive.
    std::vector<std::uint8_t> idle_bit() { return bit({1, 1, 1}).seen; }

    /// A frame begins with the next bit.
    bool begin(const Frame& frame, NodeIndex sender = a, std::size_t bits = 100) {
        return injector.begin_frame({frame, sender, now, now + std::chrono::microseconds{bits}});
    }

    FaultInjector injector;
    TimePoint now;
};

using Levels = std::vector<std::uint8_t>;

const Frame standard_123 = [] {
    Frame frame;
    frame.id = 0x123;
    frame.length = 2;
    return frame;
}();

const Frame extended_123 = [] {
    Frame frame = standard_123;
    frame.extended = true;
    return frame;
}();

TEST(FaultInjector, LeavesABusAloneWithoutFaults) {
    Wire wire{""};
    EXPECT_FALSE(wire.begin(standard_123));
    EXPECT_EQ(wire.injector.next(at(5s)), never);
    EXPECT_EQ(wire.bit({1, 0, 1}).seen, (Levels{0, 0, 0}));
    EXPECT_TRUE(wire.injector.unused().empty());
    EXPECT_TRUE(wire.injector.absent_names().empty());
}

// ---- when

TEST(FaultInjector, ActsInTheBitInWhichAMomentIs) {
    Wire wire{"at 2500ns flip wire"};
    EXPECT_EQ(wire.injector.next(at(0s)), at(2500ns));
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.idle_bit(), (Levels{0, 0, 0}));
    EXPECT_EQ(wire.injector.next(at(3us)), never);
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.injector.acted(0), 1U);
}

TEST(FaultInjector, CountsTimeFromTheStartOfTheBus) {
    Wire wire{"at 1us flip wire", at(1h)};
    EXPECT_EQ(wire.injector.next(at(1h)), at(1h + 1us));
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.idle_bit(), (Levels{0, 0, 0}));
}

TEST(FaultInjector, ActsLateWhereItsMomentWasMissed) {
    Wire wire{"at 1us flip wire"};
    wire.now = at(10us);
    EXPECT_EQ(wire.injector.next(at(10us)), at(10us));
    EXPECT_EQ(wire.idle_bit(), (Levels{0, 0, 0}));
    EXPECT_EQ(wire.injector.next(at(11us)), never);
}

TEST(FaultInjector, ActsAgainAfterEachPeriod) {
    Wire wire{"at 1us every 2 bits flip wire"};
    std::string seen;
    for (int i = 0; i < 8; ++i) seen += wire.idle_bit()[0] == 0 ? '0' : '1';
    EXPECT_EQ(seen, "10101010");
    EXPECT_EQ(wire.injector.next(at(8us)), at(9us));
    EXPECT_EQ(wire.injector.acted(0), 4U);
    wire.now = at(1s);
    wire.idle_bit();
    EXPECT_EQ(wire.injector.next(wire.now), at(1s + 1us)) << "skips what was missed";
}

TEST(FaultInjector, PeriodsInBitsDoNotDrift) {
    // 3 bits of 300 kbit/s are 10 us, 1 bit is 3333.3 ns.
    FaultInjector injector{*parse_fault_script("at 1us every 1 bit flip wire"), 300'000};
    Levels driven{};
    injector.disturb_driven({at(3ms), at(3ms + 3334ns), {}}, driven);
    EXPECT_EQ(injector.next(at(3ms + 3334ns)), at(3ms + 1us + 3333ns));
}

TEST(FaultInjector, WantsTheBitsOfAFrameInWhichAMomentIs) {
    Wire wire{"at 100us flip wire"};
    EXPECT_FALSE(wire.begin(standard_123, a, 100));
    EXPECT_TRUE(wire.begin(standard_123, a, 101));
}

TEST(FaultInjector, FindsAPlaceInAFrame) {
    Wire wire{"frame 123 at data.3 flip wire"};
    EXPECT_EQ(wire.injector.next(at(0s)), never);
    EXPECT_TRUE(wire.begin(standard_123));
    EXPECT_EQ(wire.injector.next(at(0s)), never);
    EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::data, 1}).wire, 1);
    EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::data, 2}).wire, 0);
    EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::data, 2, true}).wire, 1) << "stuffed";
    EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::crc, 2}).wire, 1);
    EXPECT_FALSE(wire.begin(extended_123));
    EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::data, 2}).wire, 1);
}

TEST(FaultInjector, KnowsWhichFieldsAFrameHas) {
    const auto begins = [](const std::string& place, const Frame& frame) {
        return Wire{"frame at " + place + " flip wire"}.begin(frame);
    };
    Frame remote = standard_123;
    remote.remote = true;
    EXPECT_TRUE(begins("data.16", standard_123));
    EXPECT_FALSE(begins("data.17", standard_123));
    EXPECT_FALSE(begins("data.1", remote));
    EXPECT_TRUE(begins("id.11", standard_123));
    EXPECT_FALSE(begins("id.12", standard_123));
    EXPECT_TRUE(begins("id.12", extended_123));
    for (const char* place : {"srr", "r1"}) {
        EXPECT_FALSE(begins(place, standard_123)) << place;
        EXPECT_TRUE(begins(place, extended_123)) << place;
    }
    for (const char* place : {"sof", "rtr", "ide", "r0", "dlc.4", "crc.15", "crc-delimiter", "ack",
                              "ack-delimiter", "eof.7", "intermission.3", "stuff.1", "bit.1"}) {
        EXPECT_TRUE(begins(place, standard_123)) << place;
        EXPECT_TRUE(begins(place, extended_123)) << place;
    }
}

TEST(FaultInjector, FindsEachField) {
    struct Case {
        const char* place;
        const Frame& frame;
        FramePosition position;
    };
    using F = FrameField;
    for (const Case& each : {
             Case{"sof", standard_123, {F::start_of_frame, 0}},
             Case{"id.1", standard_123, {F::identifier, 0}},
             Case{"id.11", extended_123, {F::identifier, 10}},
             Case{"id.12", extended_123, {F::extended_identifier, 0}},
             Case{"id.29", extended_123, {F::extended_identifier, 17}},
             Case{"srr", extended_123, {F::remote_request, 0}},
             Case{"rtr", standard_123, {F::remote_request, 0}},
             Case{"rtr", extended_123, {F::extended_remote_request, 0}},
             Case{"ide", standard_123, {F::identifier_extension, 0}},
             Case{"r1", extended_123, {F::reserved_1, 0}},
             Case{"r0", standard_123, {F::reserved_0, 0}},
             Case{"dlc.4", standard_123, {F::data_length_code, 3}},
             Case{"data.16", standard_123, {F::data, 15}},
             Case{"crc.1", standard_123, {F::crc, 0}},
             Case{"crc-delimiter", standard_123, {F::crc_delimiter, 0}},
             Case{"ack", standard_123, {F::ack_slot, 0}},
             Case{"ack-delimiter", standard_123, {F::ack_delimiter, 0}},
             Case{"eof.6", standard_123, {F::end_of_frame, 5}},
             Case{"eof.7", standard_123, {F::end_of_frame, 6}},
             Case{"intermission.3", standard_123, {F::intermission, 2}},
         }) {
        Wire wire{std::string{"frame at "} + each.place + " dominant wire"};
        ASSERT_TRUE(wire.begin(each.frame)) << each.place;
        EXPECT_EQ(wire.bit({1, 1, 1}).wire, 1) << each.place;
        EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{F::idle, 0}).wire, 1) << each.place;
        EXPECT_EQ(wire.bit({1, 1, 1}, each.position).wire, 0) << each.place;
    }
}

TEST(FaultInjector, CountsStuffBits) {
    Wire wire{"frame at stuff.2 flip wire"};
    for (int attempt = 0; attempt < 2; ++attempt) {
        ASSERT_TRUE(wire.begin(standard_123));
        EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::identifier, 3, true}).wire, 1);
        EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::identifier, 4}).wire, 1);
        EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::data, 3, true}).wire, 0);
        EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::data, 4}).wire, 1);
        EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::data, 7, true}).wire, 1);
    }
}

TEST(FaultInjector, CountsBitsFromSof) {
    Wire wire{"frame at bit.3 flip wire"};
    wire.idle_bit();
    for (int attempt = 0; attempt < 2; ++attempt) {
        ASSERT_TRUE(wire.begin(standard_123));
        EXPECT_EQ(wire.bit({0, 1, 1}, FramePosition{FrameField::start_of_frame, 0}).wire, 0);
        EXPECT_EQ(wire.bit({1, 1, 1}, FramePosition{FrameField::identifier, 0}).wire, 1);
        EXPECT_EQ(wire.bit({1, 1, 1}).wire, 0) << "whatever has happened to the frame";
        EXPECT_EQ(wire.bit({1, 1, 1}).wire, 1);
    }
}

// An idle bus is not simulated unless somebody asks for it.
TEST(FaultInjector, CountsBitsFromSofOnABusThatIsIdleAgain) {
    Wire wire{"frame at bit.200 dominant wire"};
    wire.now = at(1ms);
    ASSERT_TRUE(wire.begin(standard_123));
    EXPECT_EQ(wire.bit({0, 1, 1}, FramePosition{FrameField::start_of_frame, 0}).wire, 0);
    const TimePoint next = wire.injector.next(wire.now);
    EXPECT_GE(next, at(1ms + 199us));
    EXPECT_LT(next, at(1ms + 200us));
    wire.now = at(1ms + 198us);
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.idle_bit(), (Levels{0, 0, 0}));
    EXPECT_EQ(wire.injector.next(wire.now), never);
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.injector.acted(0), 1U);
}

TEST(FaultInjector, CountsBitsFromSofUpToTheNextFrame) {
    Wire wire{"frame 123 at bit.200 dominant wire"};
    ASSERT_TRUE(wire.begin(standard_123));
    wire.now = at(150us);
    EXPECT_FALSE(wire.begin(extended_123));
    EXPECT_EQ(wire.injector.next(wire.now), never);
    wire.now = at(199us);
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
}

TEST(FaultInjector, DoesNotMakeUpForABitOfAFrameThatItWasNotAskedFor) {
    Wire wire{"frame at bit.200 dominant wire"};
    ASSERT_TRUE(wire.begin(standard_123));
    wire.now = at(200us);
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.injector.next(wire.now), never);
}

// The bits of 300 kbit/s begin at 0, 3333, 6666, 10000, 13333 ns.
TEST(FaultInjector, CountsBitsFromSofThatAreNoWholeNanoseconds) {
    FaultInjector injector{*parse_fault_script("frame at bit.4 dominant wire"), 300'000};
    injector.node_attached(a, "a");
    ASSERT_TRUE(injector.begin_frame({standard_123, a, at(3333ns), at(1ms)}));
    EXPECT_GE(injector.next(at(3333ns)), at(13333ns));
    Levels driven{1};
    injector.disturb_driven({at(10000ns), at(13333ns), {}}, driven);
    EXPECT_EQ(driven, Levels{1});
    injector.disturb_driven({at(13333ns), at(16666ns), {}}, driven);
    EXPECT_EQ(driven, Levels{0});
}

TEST(FaultInjector, CountsTheAttemptsThatFit) {
    Wire wire{"frame 123 from a attempt 2..3 at sof flip wire"};
    const auto begins = [&](const Frame& frame, NodeIndex sender) {
        return wire.begin(frame, sender);
    };
    EXPECT_FALSE(begins(extended_123, a)) << "another identifier";
    EXPECT_FALSE(begins(standard_123, b)) << "another sender";
    EXPECT_FALSE(begins(standard_123, a)) << "attempt 1";
    EXPECT_TRUE(begins(standard_123, a));
    EXPECT_FALSE(begins(standard_123, c));
    EXPECT_TRUE(begins(standard_123, a));
    EXPECT_FALSE(begins(standard_123, a)) << "attempt 4";
}

// ---- what

TEST(FaultInjector, DisturbsWhatNodesSee) {
    Wire wire{"at 0s flip a\nat 1us dominant b, c\nat 2us recessive a, c\nat 3us flip each-node"};
    EXPECT_EQ(wire.bit({1, 0, 1}).seen, (Levels{1, 0, 0}));
    const Bit dominant = wire.bit({1, 1, 1});
    EXPECT_EQ(dominant.wire, 1) << "nothing has happened to the wire";
    EXPECT_EQ(dominant.seen, (Levels{1, 0, 0}));
    EXPECT_EQ(wire.bit({1, 0, 1}).seen, (Levels{1, 0, 1}));
    EXPECT_EQ(wire.bit({1, 0, 1}).seen, (Levels{1, 1, 1}));
    EXPECT_EQ(wire.bit({1, 0, 1}).seen, (Levels{0, 0, 0}));
}

TEST(FaultInjector, DisturbsTheWire) {
    Wire wire{"at 0s flip wire\nat 1us flip wire\nat 2us dominant wire\nat 3us recessive wire"};
    EXPECT_EQ(wire.bit({1, 1, 1}).wire, 0);
    EXPECT_EQ(wire.bit({0, 1, 0}).wire, 1);
    EXPECT_EQ(wire.bit({1, 1, 1}).wire, 0);
    EXPECT_EQ(wire.bit({0, 0, 0}).wire, 1);
    EXPECT_EQ(wire.bit({0, 0, 0}).wire, 0);
}

TEST(FaultInjector, ActsForATime) {
    Wire wire{"at 1500ns dominant a for 2 bits\nat 6us recessive wire for 1800ns"};
    std::string seen;
    std::string wanted;  // whether it wants to be asked for the bit from its beginning
    for (int i = 0; i < 10; ++i) {
        wanted += wire.injector.next(wire.now) == wire.now ? 'x' : '.';
        const std::uint8_t level = i < 5 ? 1 : 0;
        seen += wire.bit({1, level, 1}).seen[0] == 0 ? '0' : '1';
    }
    EXPECT_EQ(seen, "1001101100");
    EXPECT_EQ(wanted, "..x...xx..");
}

TEST(FaultInjector, HasTransmittersThatStick) {
    Wire wire{"at 0s stuck-dominant b for 2 bits\nat 4us stuck-dominant wire"};
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{0, 0, 0}));
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{0, 0, 0}));
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{1, 1, 1}));
    wire.idle_bit();
    for (int i = 0; i < 100; ++i) {
        EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{0, 0, 0}));
        EXPECT_EQ(wire.injector.next(wire.now), wire.now) << "for good";
    }
    EXPECT_TRUE(wire.begin(standard_123));
    EXPECT_EQ(wire.injector.acted(1), 1U);
}

TEST(FaultInjector, CutsNodesOff) {
    Wire wire{"at 0s cut-off a, b for 3 bits"};
    const Bit own = wire.bit({0, 1, 1});
    EXPECT_EQ(own.wire, 1) << "a does not reach the wire";
    EXPECT_EQ(own.seen, (Levels{0, 1, 1})) << "it sees what it sends, and b does not see that";
    const Bit others = wire.bit({1, 1, 0});
    EXPECT_EQ(others.wire, 0);
    EXPECT_EQ(others.seen, (Levels{1, 1, 0}));
    wire.bit({1, 1, 1});
    EXPECT_EQ(wire.bit({0, 1, 1}).seen, (Levels{0, 0, 0}));
}

TEST(FaultInjector, AFaultOfTheWireDoesNotReachANodeThatIsCutOff) {
    Wire wire{"at 0s cut-off a\nat 0s stuck-dominant wire\nat 1us stuck-dominant a"};
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{1, 0, 0}));
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{0, 0, 0})) << "it sees its own stuck transmitter";
}

TEST(FaultInjector, ReconnectsNodes) {
    Wire wire{
        "at 0s cut-off a, b\n"
        "at 1us reconnect a\n"
        "at 2us reconnect each-node\n"
        "at 3us cut-off each-node\n"
        "at 4us reconnect b\n"
        "at 5us reconnect c, a\n"
        "at 6us reconnect a\n"};
    const auto seen = [&] { return wire.bit({1, 1, 0}).seen; };
    EXPECT_EQ(seen(), (Levels{1, 1, 0}));
    EXPECT_EQ(seen(), (Levels{0, 1, 0}));
    EXPECT_EQ(seen(), (Levels{0, 0, 0}));
    EXPECT_EQ(wire.bit({1, 1, 0}).wire, 1) << "each is alone";
    EXPECT_EQ(wire.bit({1, 0, 0}).seen, (Levels{1, 0, 0})) << "b is back";
    EXPECT_EQ(wire.bit({1, 1, 0}).seen, (Levels{0, 0, 0}));
    wire.idle_bit();
    ASSERT_EQ(wire.injector.unused().size(), 1U);
    EXPECT_EQ(wire.injector.unused()[0]->line, 7U) << "there was nothing left to reconnect";
}

TEST(FaultInjector, CutsOffAgainAfterAReconnection) {
    Wire wire{"at 0s every 4us cut-off a\nat 2us every 4us reconnect a"};
    std::string seen;
    for (int i = 0; i < 12; ++i) seen += wire.bit({1, 0, 1}).seen[0] == 0 ? '0' : '1';
    EXPECT_EQ(seen, "110011001100");
    EXPECT_EQ(wire.injector.acted(0), 3U);
    EXPECT_EQ(wire.injector.acted(1), 3U);
}

TEST(FaultInjector, ANodeThatIsCutOffCostsNothingWhileTheBusIsIdle) {
    Wire wire{"at 0s cut-off a"};
    for (int i = 0; i < 32; ++i) {
        EXPECT_EQ(wire.injector.next(wire.now), wire.now) << i;
        wire.idle_bit();
    }
    EXPECT_EQ(wire.injector.next(wire.now), never);
    EXPECT_TRUE(wire.begin(standard_123));
    EXPECT_EQ(wire.injector.next(wire.now), wire.now);
    EXPECT_EQ(wire.bit({1, 0, 1}).seen, (Levels{1, 0, 0}));
}

TEST(FaultInjector, TheLaterLineWinsAndFlipsCancel) {
    Wire wire{
        "at 0s dominant a for 3 bits\n"
        "at 1us recessive a\n"
        "at 2us flip a\n"
        "at 3us flip a\n"
        "at 3us flip each-node\n"};
    EXPECT_EQ(wire.idle_bit(), (Levels{0, 1, 1}));
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1}));
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 1, 1})) << "dominant, flipped";
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 0, 0}));
}

TEST(FaultInjector, FlipsComeLastAlsoThoseDrawnByLot) {
    Wire wire{
        "bit-error-rate 1 a, b\n"
        "at 0s flip c for 4 bits\n"
        "at 1us cut-off each-node for 1 bit\n"
        "at 2us dominant each-node\n"
        "at 3us recessive each-node\n"};
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{0, 0, 0}));
    EXPECT_EQ(wire.bit({0, 1, 0}).seen, (Levels{1, 0, 1})) << "each sees itself, flipped";
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{1, 1, 1}));
    EXPECT_EQ(wire.bit({0, 0, 0}).seen, (Levels{0, 0, 0}));
}

// ---- nodes that come and go

TEST(FaultInjector, NeedNotKnowWhoeverTheBusHasAPlaceFor) {
    Wire wire{
        "at 0s dominant wire\n"
        "at 1us cut-off each-node for 1 bit\n"
        "at 2us stuck-dominant each-node for 1 bit\n"
        "at 3us flip each-node\n"
        "bit-error-rate 1e-18 each-node"};
    wire.injector.node_detached(b);
    const std::uint8_t r = 1;
    EXPECT_EQ(wire.bit({r, r, r, r, r}).seen, (Levels{0, 0, 0, 0, 0}));
    EXPECT_EQ(wire.bit({r, 0, r, r, r}).seen, (Levels{1, 0, 1, 0, 0})) << "b is not its node";
    EXPECT_EQ(wire.bit({r, r, r, r, r}).wire, 0);
    EXPECT_EQ(wire.bit({r, r, r, r, r}).seen, (Levels{0, 1, 0, 1, 1}));
    wire.injector.node_detached(NodeIndex{9});
    EXPECT_FALSE(wire.begin(standard_123, NodeIndex{9}));
}

TEST(FaultInjector, MayBeAskedForFewerNodesThanItKnows) {
    Wire wire{
        "at 0s dominant wire for 2 bits\n"
        "at 2us cut-off each-node for 2 bits\n"
        "at 4us stuck-dominant each-node for 2 bits\n"
        "bit-error-rate 1 c"};
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(wire.bit({1}).seen, Levels{i == 1 ? std::uint8_t{1} : std::uint8_t{0}}) << i;
        EXPECT_EQ(wire.bit({}).seen, Levels{}) << i;
    }
}

TEST(FaultInjector, DisturbsTheWireOfABusWithoutNodes) {
    FaultInjector injector{*parse_fault_script("at 0s dominant wire for 2 bits\n"
                                               "at 1us flip wire\n"
                                               "at 2us flip each-node\n"
                                               "at 3us stuck-dominant each-node"),
                           1'000'000};
    std::string wire;
    for (int i = 0; i < 4; ++i) {
        Levels driven{1};
        const BitMoment moment{at(i * 1us), at((i + 1) * 1us), {}};
        injector.disturb_driven(moment, driven);
        Levels seen = driven;
        injector.disturb_seen(moment, driven, seen);
        EXPECT_EQ(seen, driven);
        wire += seen[0] == 0 ? '0' : '1';
    }
    EXPECT_EQ(wire, "0111");
    EXPECT_EQ(injector.unused().size(), 2U);
}

TEST(FaultInjector, ForgetsTheNodesOfAnotherBus) {
    Wire wire{"at 0s stuck-dominant b\nbit-error-rate 1 a, b"};
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{1, 1, 0}));
    wire.injector.bus_entered();
    EXPECT_EQ(wire.injector.next(wire.now), never);
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{1, 1, 1}));
    wire.injector.node_attached(c, "b");
    EXPECT_EQ(wire.injector.next(wire.now), wire.now);
    EXPECT_EQ(wire.bit({1, 1, 1}).seen, (Levels{0, 0, 1}));
}

/// A bus keeps the places of nodes that have left.
TEST(FaultInjector, ComesToABusThatNodesHaveLeft) {
    FaultInjector injector{*parse_fault_script("at 1ms dominant wire for 20 bits\n"
                                               "at 1ms cut-off a\n"
                                               "at 2ms recessive each-node for 20 bits"),
                           1'000'000};
    Bus bus{1'000'000};
    std::vector<NodeIndex> nodes;
    for (const char* name : {"a", "b", "c", "d"}) nodes.push_back(bus.attach({.name = name}));
    while (nodes.size() > 1) {
        bus.detach(nodes.back());
        nodes.pop_back();
    }
    bus.set_disturbance(&injector);
    bus.advance(at(1500us));
    bus.detach(nodes.back());
    bus.advance(at(3ms));
    EXPECT_EQ(injector.acted(0), 1U);
    EXPECT_EQ(injector.acted(1), 1U);
    EXPECT_EQ(injector.acted(2), 0U);
}

TEST(FaultInjector, KnowsNodesByTheirNames) {
    FaultInjector injector{*parse_fault_script("at 0s cut-off pump, valve\nat 0s flip sensor"),
                           1'000'000};
    EXPECT_EQ(injector.absent_names(), (std::vector<std::string>{"pump", "valve", "sensor"}));
    EXPECT_EQ(injector.next(at(0s)), at(0s));
    Levels driven{};
    injector.disturb_driven({at(0s), at(1us), {}}, driven);
    EXPECT_EQ(injector.next(at(1us)), never) << "nobody is there";
    EXPECT_EQ(injector.unused().size(), 2U);

    injector.node_attached(a, "other");
    injector.node_attached(b, "pump");
    injector.node_attached(c, "pump");
    EXPECT_EQ(injector.next(at(5us)), at(5us)) << "the cut waited for them";
    driven = {1, 0, 0};
    const BitMoment moment{at(5us), at(6us), {}};
    injector.disturb_driven(moment, driven);
    EXPECT_EQ(driven, (Levels{1, 1, 1}));
    Levels seen{1, 1, 1};
    injector.disturb_seen(moment, driven, seen);
    EXPECT_EQ(seen, (Levels{1, 0, 0}));
    EXPECT_EQ(injector.acted(0), 1U);

    injector.node_detached(b);
    injector.node_detached(c);
    EXPECT_EQ(injector.absent_names(), (std::vector<std::string>{"valve", "sensor"}));
    ASSERT_EQ(injector.unused().size(), 1U);
    EXPECT_EQ(injector.unused()[0]->line, 2U);
    EXPECT_EQ(injector.next(at(6us)), never);
    injector.node_attached(b, "other");
    driven = {1, 0, 0};
    injector.disturb_driven({at(6us), at(7us), {}}, driven);
    EXPECT_EQ(driven, (Levels{1, 0, 0}));
}

TEST(FaultInjector, KnowsASenderByItsName) {
    Wire wire{"frame from nobody at sof flip wire"};
    EXPECT_FALSE(wire.begin(standard_123, a));
    EXPECT_EQ(wire.injector.absent_names(), std::vector<std::string>{"nobody"});
    wire.injector.node_detached(a);
    wire.injector.node_attached(a, "nobody");
    EXPECT_TRUE(wire.begin(standard_123, a));
    EXPECT_FALSE(wire.begin(standard_123, b));
}

// ---- by lot

/// The numbers of the bits in which somebody sees a wrong level, in the first `count`; skips what
/// the injector does not want to see.
std::vector<std::pair<std::size_t, Levels>> wrong_bits(Wire& wire, std::size_t count) {
    std::vector<std::pair<std::size_t, Levels>> result;
    const TimePoint end = wire.now + std::chrono::microseconds{count};
    while (true) {
        const TimePoint next = wire.injector.next(wire.now);
        if (next >= end) return result;
        wire.now = next;
        const auto number = static_cast<std::size_t>(wire.now.time_since_epoch() / 1us);
        const Levels seen = wire.idle_bit();
        EXPECT_NE(seen, (Levels{1, 1, 1})) << number;
        result.emplace_back(number, seen);
    }
}

TEST(FaultInjector, DrawsAsManyBitsAsItsRateSays) {
    for (const auto& [rate, expected] : std::vector<std::pair<std::string, double>>{
             {"1e-5", 1e2}, {"1e-4", 1e3}, {"1e-3", 1e4}, {"0.05", 5e5}}) {
        Wire wire{"bit-error-rate " + rate + " wire"};
        const auto wrong = wrong_bits(wire, 10'000'000);
        // Five standard deviations of a Poisson distribution.
        EXPECT_NEAR(static_cast<double>(wrong.size()), expected, 5 * std::sqrt(expected)) << rate;
        EXPECT_EQ(wire.injector.acted(0), wrong.size());
    }
    Wire always{"bit-error-rate 1 wire"};
    EXPECT_EQ(wrong_bits(always, 1000).size(), 1000U);
    Wire seldom{"bit-error-rate 1e-18 wire"};
    EXPECT_TRUE(wrong_bits(seldom, 1'000'000'000).empty());
}

/// The distance between two errors is as likely to be n as (1 - p)^n * p.
TEST(FaultInjector, DrawsDistancesFromAGeometricDistribution) {
    Wire wire{"seed 3\nbit-error-rate 0.1 wire"};
    const auto wrong = wrong_bits(wire, 1'000'000);
    std::vector<double> count(40);
    for (std::size_t i = 1; i < wrong.size(); ++i) {
        const std::size_t spared = wrong[i].first - wrong[i - 1].first - 1;
        if (spared < count.size()) ++count[spared];
    }
    double chi_square = 0;
    for (std::size_t n = 0; n < count.size(); ++n) {
        const double expected =
            static_cast<double>(wrong.size()) * 0.1 * std::pow(0.9, static_cast<double>(n));
        chi_square += (count[n] - expected) * (count[n] - expected) / expected;
    }
    EXPECT_LT(chi_square, 73.4) << "0.1 % of a chi-square distribution with 40 degrees of freedom";
}

// They must be the same on every machine and with every compiler. From Python: the numbers u of its
// own mt19937_64, and floor(ln(u / 2^64) / ln(1 - p)) bits spared, with 60 digits.
TEST(FaultInjector, DrawsTheSameBitsEverywhere) {
    const auto first = [](std::string_view script, std::size_t count) {
        Wire wire{script};
        std::vector<std::size_t> bits;
        for (const auto& [number, seen] : wrong_bits(wire, count)) bits.push_back(number);
        return bits;
    };
    EXPECT_EQ(first("bit-error-rate 1e-3 wire", 5'000),
              (std::vector<std::size_t>{2009, 4001, 4797}));
    EXPECT_EQ(first("bit-error-rate 0.01 wire\nseed 42", 500),
              (std::vector<std::size_t>{27, 72, 101, 300, 311}));
}

TEST(FaultInjector, DrawsForEachNodeByItself) {
    Wire wire{"bit-error-rate 1e-3 each-node"};
    std::vector<double> wrong(3);
    std::size_t several = 0;
    for (const auto& [number, seen] : wrong_bits(wire, 10'000'000)) {
        int nodes = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            if (seen[i] != 0) continue;
            ++wrong[i];
            ++nodes;
        }
        several += nodes > 1 ? 1 : 0;
    }
    for (const double count : wrong) EXPECT_NEAR(count, 1e4, 500);
    EXPECT_NEAR(static_cast<double>(several), 30, 27) << "3 pairs, each 1e-6 of 1e7 bits";
}

TEST(FaultInjector, DrawsForNamedNodesOnly) {
    Wire wire{"bit-error-rate 0.01 b"};
    const auto wrong = wrong_bits(wire, 100'000);
    EXPECT_NEAR(static_cast<double>(wrong.size()), 1000, 160);
    for (const auto& [number, seen] : wrong) EXPECT_EQ(seen, (Levels{1, 0, 1}));
    wire.injector.node_detached(b);
    EXPECT_EQ(wire.injector.next(wire.now), never);
    wire.injector.node_attached(b, "b");
    EXPECT_NE(wire.injector.next(wire.now), never);
    EXPECT_GE(wire.injector.next(wire.now), wire.now);
}

TEST(FaultInjector, MayBeToldOfANodeTwice) {
    Wire wire{"bit-error-rate 1 b"};
    wire.injector.node_attached(b, "b");
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 0, 1})) << "two flips would cancel";
}

TEST(FaultInjector, DoesNotMakeUpForBitsThatItWasNotAskedFor) {
    Wire wire{"bit-error-rate 0.01 wire"};
    wire.now = at(10min);
    EXPECT_GE(wire.injector.next(wire.now), wire.now);
    std::size_t wrong = 0;
    for (int i = 0; i < 100'000; ++i) wrong += wire.idle_bit()[0] == 0 ? 1U : 0U;
    EXPECT_NEAR(static_cast<double>(wrong), 1000, 160);
}

TEST(FaultInjector, LotsTakeOutOnlyTheFramesTheyHit) {
    Wire wire{"bit-error-rate 1e-3 wire"};
    std::size_t hit = 0;
    for (int i = 0; i < 10'000; ++i) {
        if (wire.begin(standard_123)) {
            ++hit;
            for (int bit = 0; bit < 100; ++bit) wire.idle_bit();
        } else {
            wire.now += 100us;
        }
    }
    // 1 - 0.999^100 = 0.0952
    EXPECT_NEAR(static_cast<double>(hit), 952, 150);
}

TEST(FaultInjector, DisturbsABusWithoutNodes) {
    for (const bool has_had_one : {false, true}) {
        FaultInjector injector{
            *parse_fault_script("at 10us stuck-dominant wire\nat 0s cut-off each-node"), 1'000'000};
        Bus bus{1'000'000};
        bus.set_disturbance(&injector);
        if (has_had_one) bus.detach(bus.attach());
        bus.advance(at(1ms));
        EXPECT_EQ(bus.statistics().frames, 0U);
        EXPECT_EQ(bus.statistics().error_frames, 0U);
        EXPECT_EQ(bus.statistics().busy_bits, 990U) << has_had_one;
        EXPECT_EQ(injector.acted(0), 1U);
        EXPECT_EQ(injector.acted(1), 0U);
    }
}

// Two lots that hit different places of one bit at once.
TEST(FaultInjector, FlipsOfTheWireAndOfANodeCancelForThatNode) {
    Wire wire{"bit-error-rate 1 wire\nbit-error-rate 1 a"};
    EXPECT_EQ(wire.idle_bit(), (Levels{1, 0, 0}));
}

}  // namespace
}  // namespace canorb::can::sim
