// Noise on the wire, and at each node by itself: what is delivered is what was sent, or passes an
// independent check that shows that CAN's CRC cannot tell.
//
// The bits of all runs together are 10 million times CANORB_SOAK_FACTOR (1 where it is not set).

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <deque>
#include <optional>
#include <ostream>
#include <random>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orb/can/sim/fault_injector.hpp"
#include "tests/can/bus_fixture.hpp"
#include "tests/support/soak.hpp"

namespace canorb::can::sim {
namespace {

using namespace test;

using Levels = std::vector<std::uint8_t>;

// ---- the independent check

/// Whether CAN's generator polynomial divides the bits, most significant first: long division.
bool is_divisible(Levels bits) {
    constexpr std::string_view generator = "1100010110011001";
    for (std::size_t i = 0; i + generator.size() <= bits.size(); ++i) {
        if (bits[i] == 0) continue;
        for (std::size_t k = 0; k < generator.size(); ++k) {
            if (generator[k] == '1') bits[i + k] ^= 1U;
        }
    }
    return std::count(bits.begin(), bits.end(), 1) == 0;
}

std::uint32_t number(const Levels& bits, std::size_t first, std::size_t count) {
    std::uint32_t value = 0;
    for (std::size_t i = first; i < first + count; ++i) value = value * 2 + bits[i];
    return value;
}

/// SOF to the end of the CRC without stuff bits, of a frame that begins with `header`; 0: too few
/// to tell.
std::size_t unstuffed_size(const Levels& header) {
    constexpr std::size_t ide = 13;
    if (header.size() <= ide) return 0;
    const std::size_t rtr = header[ide] == 1 ? 32 : 12;
    const std::size_t dlc = header[ide] == 1 ? 35 : 15;
    if (header.size() < dlc + 4) return 0;
    const std::size_t octets = std::min<std::size_t>(number(header, dlc, 4), 8);
    return dlc + 4 + (header[rtr] == 1 ? 0 : 8 * octets) + 15;
}

/// What a receiver that sees these bits, from SOF to the end of EOF, must take for a frame.
std::optional<Frame> decode(const Levels& seen) {
    Levels bits;
    std::size_t at = 0;
    std::size_t run = 0;
    std::uint8_t last = 2;
    while (unstuffed_size(bits) == 0 || bits.size() < unstuffed_size(bits) || run == 5) {
        if (at == seen.size()) return std::nullopt;
        const std::uint8_t level = seen[at++];
        if (run == 5) {
            if (level == last) return std::nullopt;
            run = 1;
        } else {
            bits.push_back(level);
            run = level == last ? run + 1 : 1;
        }
        last = level;
    }
    // CRC delimiter, ACK slot, ACK delimiter, EOF, whose last bit may be anything.
    constexpr std::string_view tail = "1?1111111?";
    if (seen.size() - at != tail.size()) return std::nullopt;
    for (std::size_t i = 0; i < tail.size(); ++i) {
        if (tail[i] == '1' && seen[at + i] != 1) return std::nullopt;
    }
    if (bits[0] != 0 || !is_divisible(bits)) return std::nullopt;
    Frame frame;
    frame.extended = bits[13] == 1;
    frame.id = number(bits, 1, 11);
    if (frame.extended) frame.id = (frame.id << 18) | number(bits, 14, 18);
    frame.remote = bits[frame.extended ? 32 : 12] == 1;
    const std::size_t dlc = frame.extended ? 35 : 15;
    frame.length = static_cast<std::uint8_t>(std::min<std::uint32_t>(number(bits, dlc, 4), 8));
    for (std::size_t i = 0; i < frame.length && !frame.remote; ++i) {
        frame.data[i] = static_cast<std::uint8_t>(number(bits, dlc + 4 + 8 * i, 8));
    }
    return frame;
}

Levels levels(std::string_view text) {
    Levels result;
    for (const char c : text) {
        if (c != ' ') result.push_back(c == '1' ? 1 : 0);
    }
    return result;
}

// 123#DEADBEEF00000000 has CRC 0x6777 and 7 stuff bits. The ACK slot is dominant.
constexpr std::string_view bits_of_123 =
    "0 00100100011 0 0 0 1000 11011110 10101101 101111100 11101111"
    "000001 000001 000001 000001 000001 000001 00 110011101110111 1 0 1 1111111";

TEST(IndependentCheck, TakesAFrame) {
    EXPECT_EQ(decode(levels(bits_of_123)), standard(0x123, "DE AD BE EF 00 00 00 00"));
}

TEST(IndependentCheck, RefusesAnySingleWrongBit) {
    const Levels right = levels(bits_of_123);
    ASSERT_EQ(right.size(), 115U);
    constexpr std::size_t ack_slot = 106;
    constexpr std::size_t last_bit_of_eof = 114;
    for (std::size_t i = 0; i < right.size(); ++i) {
        Levels wrong = right;
        wrong[i] ^= 1U;
        EXPECT_EQ(decode(wrong).has_value(), i == ack_slot || i == last_bit_of_eof) << i;
    }
    EXPECT_FALSE(decode(Levels{right.begin(), right.end() - 1}));
    EXPECT_FALSE(decode(Levels{right.begin() + 1, right.end()}));
}

// ---- the bus under noise

constexpr std::size_t node_count = 4;
constexpr std::uint32_t bitrate = 1'000'000;  // a bit is a microsecond

/// A script's faults, and what each node saw around them.
class RecordedFaults : public Disturbance {
  public:
    explicit RecordedFaults(std::string_view script)
        : injector_{*parse_fault_script(script), bitrate} {}

    std::uint64_t flips() const { return injector_.acted(0); }

    /// Whether the node has seen the frame with correct stuffing, CRC and form, up to `end`.
    bool has_seen(std::size_t node, const Frame& frame, TimePoint end) const {
        constexpr std::uint64_t shortest = 44;
        constexpr std::uint64_t longest = 157;
        Levels seen;
        for (std::uint64_t bit = bit_number(end); bit > 0 && seen.size() < longest;) {
            const Slot& slot = slots_[--bit % slots_.size()];
            if (slot.bit != bit) return false;
            seen.insert(seen.begin(), slot.seen[node]);
            if (seen.size() >= shortest && decode(seen) == frame) return true;
        }
        return false;
    }

    void node_attached(NodeIndex node, std::string_view name) override {
        injector_.node_attached(node, name);
    }
    void node_detached(NodeIndex node) override { injector_.node_detached(node); }

    bool begin_frame(const PlannedFrame& planned) override {
        const bool disturbed = injector_.begin_frame(planned);
        return disturbed || planned.start < recorded_until_;
    }
    TimePoint next(TimePoint from) const override {
        return from < recorded_until_ ? from : injector_.next(from);
    }
    void disturb_driven(const BitMoment& moment, std::span<std::uint8_t> driven) override {
        // A node may take a wrong bit for SOF, and the frame that begins next for the rest of it.
        if (injector_.next(moment.start) < moment.end) recorded_until_ = moment.end + 24us;
        injector_.disturb_driven(moment, driven);
    }
    void disturb_seen(const BitMoment& moment, std::span<const std::uint8_t> driven,
                      std::span<std::uint8_t> seen) override {
        injector_.disturb_seen(moment, driven, seen);
        Slot& slot = slots_[bit_number(moment.start) % slots_.size()];
        slot.bit = bit_number(moment.start);
        std::copy(seen.begin(), seen.end(), slot.seen.begin());
    }

  private:
    struct Slot {
        std::uint64_t bit = UINT64_MAX;
        std::array<std::uint8_t, node_count> seen{};
    };

    static std::uint64_t bit_number(TimePoint time) {
        return static_cast<std::uint64_t>(time.time_since_epoch() / 1us);
    }

    FaultInjector injector_;
    TimePoint recorded_until_;
    std::array<Slot, 1024> slots_;
};

struct Counts {
    std::uint64_t sent = 0;
    std::uint64_t received = 0;
    std::uint64_t undetectable = 0;      ///< with wrong content, and every check right
    std::uint64_t wrong = 0;             ///< with wrong content that a check should have told
    std::uint64_t repeated = 0;          ///< received, and its sender did not think so
    std::uint64_t missed = 0;            ///< not received by a node that was there, though sent
    std::uint64_t missed_by_active = 0;  ///< and it could have destroyed the frame for all
    std::uint64_t bus_off = 0;
};

/// Four nodes that always have something to send.
class NoisyBus {
  public:
    explicit NoisyBus(std::string_view script) : faults_{script} {
        bus_.set_disturbance(&faults_);
        bus_.set_trace([this](const CompletedFrame& frame) { completed_.push_back(frame); });
        bus_.set_error_trace([this](const NodeError& error) {
            if (error.capture == last_bit_of_eof) repeats_.insert(error.time);
        });
    }

    void run(std::uint64_t bits) {
        const TimePoint end = bus_.now() + std::chrono::microseconds{bits};
        while (bus_.now() < end) {
            for (std::size_t i = 0; i < node_count; ++i) refill(i);
            bus_.advance(bus_.now() + 100us);
            judge();
        }
    }

    /// One frame, and nothing else.
    void run_one(std::size_t node, const Frame& frame) {
        send(node, frame);
        bus_.advance(bus_.now() + 1ms);
        judge();
    }

    const Counts& counts() const { return counts_; }
    std::uint64_t flips() const { return faults_.flips(); }
    BusStatistics statistics() const { return bus_.statistics(); }

    /// All nodes see the same bits, so that more can be said.
    bool all_see_the_same = false;

  private:
    static constexpr ErrorCapture last_bit_of_eof{
        ErrorKind::form, {FrameField::end_of_frame, 6}, true};

    /// A frame in a node's mailbox.
    struct Sending {
        Frame frame;
        TimePoint from;
        TimePoint until;
    };

    struct Sender {
        std::deque<Sending> frames;
        ControllerState state = ControllerState::error_active;
        TimePoint since;
        bool was_off = false;  ///< until then
    };

    void send(std::size_t node, const Frame& frame) {
        nodes_[node].must_send(frame);
        senders_[node].frames.push_back({frame, bus_.now(), never});
    }

    std::uint32_t draw(std::uint32_t below) {
        return static_cast<std::uint32_t>(random_() >> 32) % below;
    }

    /// The identifier tells the node, so that no two collide.
    Frame random_frame(std::size_t node) {
        Frame frame;
        frame.extended = draw(2) == 0;
        frame.id = draw(frame.extended ? 1U << 27 : 1U << 9) * std::uint32_t{node_count} +
                   static_cast<std::uint32_t>(node);
        frame.remote = draw(16) == 0;
        frame.length = static_cast<std::uint8_t>(draw(9));
        const bool has_runs = draw(2) == 0;  // and with them stuff bits
        for (std::size_t i = 0; i < frame.length && !frame.remote; ++i) {
            const std::uint32_t octet = draw(256);
            frame.data[i] = static_cast<std::uint8_t>(has_runs ? (octet % 2) * 0xFF : octet);
        }
        return frame;
    }

    void refill(std::size_t node) {
        Sender& state = senders_[node];
        const bool is_free = state.frames.empty() || state.frames.back().until != never;
        if (state.state == ControllerState::bus_off || !is_free) return;
        send(node, random_frame(node));
        if (state.frames.size() > 3) state.frames.pop_front();
    }

    void judge() {
        for (TestNode& node : nodes_) node.drain();
        for (std::size_t i = 0; i < node_count; ++i) {
            for (const Received& each : nodes_[i].received) judge(i, each);
        }
        for (const CompletedFrame& each : completed_) look_for_misses(each);
        counts_.sent += completed_.size();
        for (std::size_t i = 0; i < node_count; ++i) note_results(i);
        completed_.clear();
        repeats_.clear();
    }

    void judge(std::size_t receiver, const Received& received) {
        ++counts_.received;
        const bool was_sent =
            std::any_of(completed_.begin(), completed_.end(),
                        [&](const CompletedFrame& each) { return each.time == received.time; });
        if (!was_sent) {
            ++counts_.repeated;
            if (all_see_the_same) {
                EXPECT_TRUE(repeats_.contains(received.time)) << place(receiver, received);
            }
        }
        if (was_on_its_way(receiver, received)) return;
        const bool is_undetectable = faults_.has_seen(receiver, received.frame, received.time);
        ++(is_undetectable ? counts_.undetectable : counts_.wrong);
        EXPECT_TRUE(is_undetectable) << place(receiver, received);
        // Its sender must have seen it as well.
        EXPECT_FALSE(all_see_the_same) << place(receiver, received);
    }

    static std::string place(std::size_t receiver, const Received& received) {
        return "node " + std::to_string(receiver) + " at " +
               std::to_string(received.time.time_since_epoch().count()) + " ns";
    }

    bool was_on_its_way(std::size_t receiver, const Received& received) const {
        for (std::size_t i = 0; i < node_count; ++i) {
            if (i == receiver) continue;
            for (const Sending& each : senders_[i].frames) {
                if (each.frame == received.frame && each.from < received.time &&
                    each.until >= received.time) {
                    return true;
                }
            }
        }
        return false;
    }

    void look_for_misses(const CompletedFrame& frame) {
        for (std::size_t i = 0; i < node_count; ++i) {
            const TestNode& node = nodes_[i];
            if (node.node() == frame.sender) continue;
            const bool has_it =
                std::any_of(node.received.begin(), node.received.end(),
                            [&](const Received& each) { return each.time == frame.time; });
            if (has_it || was_off(i, frame)) continue;
            ++counts_.missed;
            const bool is_steady = node.states.empty() && senders_[i].since < frame.start;
            if (!is_steady || senders_[i].state != ControllerState::error_active) continue;
            ++counts_.missed_by_active;
            EXPECT_FALSE(all_see_the_same) << "node " << i << " missed a frame";
        }
    }

    /// Whether the node was bus-off at some moment of the frame.
    bool was_off(std::size_t node, const CompletedFrame& frame) const {
        const Sender& sender = senders_[node];
        const auto& changes = nodes_[node].states;
        return sender.state == ControllerState::bus_off ||
               (sender.was_off && sender.since > frame.start) ||
               std::any_of(changes.begin(), changes.end(), [&](const StateChanged& change) {
                   return change.status.state == ControllerState::bus_off &&
                          change.time < frame.time;
               });
    }

    void note_results(std::size_t node) {
        Sender& sender = senders_[node];
        for (const TransmitResult& each : nodes_[node].results) {
            sender.frames.back().until = each.time;
        }
        for (const StateChanged& each : nodes_[node].states) {
            const ControllerState state = each.status.state;
            if (state == ControllerState::bus_off) ++counts_.bus_off;
            sender.was_off = sender.state == ControllerState::bus_off;
            sender.state = state;
            sender.since = each.time;
        }
        nodes_[node].received.clear();
        nodes_[node].results.clear();
        nodes_[node].states.clear();
    }

    RecordedFaults faults_;
    Bus bus_{bitrate};
    std::deque<TestNode> nodes_ = [this] {
        std::deque<TestNode> nodes;
        for (std::size_t i = 0; i < node_count; ++i) {
            nodes.emplace_back(
                bus_, NodeOptions{.automatic_recovery = true, .name = "node-" + std::to_string(i)});
        }
        return nodes;
    }();
    std::array<Sender, node_count> senders_;
    std::mt19937_64 random_{11};
    std::vector<CompletedFrame> completed_;
    std::set<TimePoint> repeats_;
    Counts counts_;
};

// Wrong in eight bits of the data, and these a multiple of the generator polynomial: 1 1 0 0 0 1 0
// 1 1 0 0 1 1 0 0 1. Neither frame has five equal bits there.
TEST(UndetectableError, IsDeliveredAndCounted) {
    std::string script;
    for (const int bit : {17, 18, 22, 24, 25, 28, 29, 32}) {
        script += "frame 123 at data." + std::to_string(bit) + " flip node-2\n";
    }
    NoisyBus bus{script};
    bus.run_one(0, standard(0x123, "AA AA AA AA AA AA AA AA"));
    EXPECT_EQ(bus.counts().sent, 1U);
    EXPECT_EQ(bus.counts().received, 3U);
    EXPECT_EQ(bus.counts().undetectable, 1U);
    EXPECT_EQ(bus.counts().wrong, 0U);
    EXPECT_EQ(bus.statistics().error_frames, 0U);
}

struct Noise {
    const char* rate;
    const char* where;
};

void PrintTo(const Noise& noise, std::ostream* out) {
    *out << noise.rate << " " << noise.where;
}

class BitErrors : public testing::TestWithParam<Noise> {};

TEST_P(BitErrors, DeliverNothingWrongThatACheckCouldTell) {
    constexpr std::uint64_t bits_at_factor_1 = 10'000'000 / 6;
    constexpr std::uint64_t bits_between_reports = 20'000'000;
    const std::uint64_t bits = bits_at_factor_1 * canorb::test::soak_factor();

    const std::string label = std::string{GetParam().rate} + " " + GetParam().where;
    NoisyBus bus{"bit-error-rate " + label};
    bus.all_see_the_same = std::string_view{GetParam().where} == "wire";
    for (std::uint64_t done = 0; done < bits && !HasFailure();) {
        const std::uint64_t part = std::min(bits - done, bits_between_reports);
        bus.run(part);
        done += part;
        if (done < bits) {
            std::printf("%s: %llu million bits\n", label.c_str(),
                        static_cast<unsigned long long>(done / 1'000'000));
            std::fflush(stdout);
        }
    }
    const Counts& counts = bus.counts();
    const auto print = [&](const char* what, std::uint64_t count) {
        std::printf("  %-22s %llu\n", what, static_cast<unsigned long long>(count));
    };
    std::printf("bit error rate %s\n", label.c_str());
    print("bits", bits);
    print("wrong bits", bus.flips());
    print("error frames", bus.statistics().error_frames);
    print("frames sent", counts.sent);
    print("frames received", counts.received);
    print("of them undetectable", counts.undetectable);
    print("repeated though there", counts.repeated);
    print("missed though sent", counts.missed);
    print("by error active nodes", counts.missed_by_active);
    print("times bus-off", counts.bus_off);
    EXPECT_EQ(counts.wrong, 0U);
    EXPECT_GT(counts.sent, 0U);
    EXPECT_GT(bus.flips(), 0U);
}

INSTANTIATE_TEST_SUITE_P(, BitErrors,
                         testing::Values(Noise{"1e-5", "wire"}, Noise{"1e-4", "wire"},
                                         Noise{"1e-3", "wire"}, Noise{"1e-5", "each-node"},
                                         Noise{"1e-4", "each-node"}, Noise{"1e-3", "each-node"}),
                         [](const testing::TestParamInfo<Noise>& noise) {
                             const std::string_view where = noise.param.where;
                             return (where == "wire" ? "Wire" : "EachNode") +
                                    std::string{noise.param.rate}.replace(1, 2, "em");
                         });

}  // namespace
}  // namespace canorb::can::sim
