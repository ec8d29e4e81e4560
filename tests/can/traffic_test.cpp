// Random traffic of many nodes: nothing is lost, nothing comes twice, the most urgent goes first,
// and the bus is busy for exactly as long as its frames.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "orb/can/frame_length.hpp"
#include "orb/can/sim/controller.hpp"
#include "tests/support/soak.hpp"

namespace canorb::can::sim::test {
namespace {

constexpr std::uint32_t bitrate = 1'000'000;
constexpr Duration bit_time{1'000};
constexpr std::size_t node_count = 32;
constexpr std::array<Filter, 2> everything{Filter{0, 0, false}, Filter{0, 0, true}};

/// The length of a frame as can-utils' canframelen counts it, "exact": CRC by division and stuff
/// bits by looking, with nothing of the code under test.
std::uint64_t independent_length(const Frame& frame) {
    std::string bits = "0";
    const auto put = [&bits](std::uint64_t value, int width) {
        for (int i = width - 1; i >= 0; --i) bits += (value >> i & 1U) != 0 ? '1' : '0';
    };
    if (frame.extended) {
        put(frame.id >> 18, 11);
        put(0b11, 2);
        put(frame.id & 0x3FFFF, 18);
        put(0, 3);
    } else {
        put(frame.id, 11);
        put(0, 3);
    }
    put(frame.length, 4);
    for (std::size_t i = 0; i < frame.length; ++i) put(frame.data[i], 8);

    std::string dividend = bits + std::string(15, '0');
    const std::string divisor =
        "1100010110011001";  // x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1
    for (std::size_t i = 0; i < bits.size(); ++i) {
        if (dividend[i] == '0') continue;
        for (std::size_t k = 0; k < divisor.size(); ++k) {
            dividend[i + k] = dividend[i + k] == divisor[k] ? '0' : '1';
        }
    }
    bits += dividend.substr(bits.size());

    std::uint64_t stuffed = 0;
    char last = '-';
    int run = 0;
    for (const char bit : bits) {
        run = bit == last ? run + 1 : 1;
        last = bit;
        if (run < 5) continue;
        ++stuffed;
        last = bit == '0' ? '1' : '0';
        run = 1;
    }
    return bits.size() + stuffed + 10 + 3;  // CRC delimiter to EOF, intermission
}

class Traffic {
  public:
    explicit Traffic(Fidelity fidelity) : bus_(bitrate) {
        bus_.set_fidelity(fidelity);
        bus_.set_trace([this](const CompletedFrame& frame) { complete(frame); });
        for (std::size_t i = 0; i < node_count; ++i) {
            Node& node = nodes_[i];
            // As many mailboxes as there may be, and as few.
            node.controller =
                std::make_unique<Controller>(bus_, NodeOptions{.mailboxes = 1 + i, .name = {}});
            EXPECT_TRUE(node.controller->set_filters(everything));
        }
    }

    void run(std::uint64_t bits) {
        const TimePoint end = bus_.now() + static_cast<std::int64_t>(bits) * bit_time;
        while (bus_.now() < end) {
            canorb::test::show_progress("bits", (number(bus_.now()) / 1000) & ~std::uint64_t{1023},
                                        bits);
            bus_.advance(bus_.now() + Duration{static_cast<Duration::rep>(random_() % 250'000)});
            for (std::uint64_t i = random_() % 4; i > 0; --i) send(random_() % node_count);
            for (Node& node : nodes_) read(node);
            if (testing::Test::HasFailure()) return;
        }
        while (bus_.advance_one()) {
            for (Node& node : nodes_) read(node);
        }
        for (Node& node : nodes_) {
            EXPECT_TRUE(node.waiting.empty());
            EXPECT_EQ(node.expected, completed_.size());
            EXPECT_EQ(node.controller->error_status(), ErrorStatus{});
        }
        bus_.advance(bus_.now() + 3 * bit_time);
        std::uint64_t lengths = 0;
        for (const CompletedFrame& each : completed_) lengths += independent_length(each.frame);
        EXPECT_EQ(bus_.statistics().busy_bits, lengths);
        EXPECT_GT(lengths, bits * 9 / 10);
    }

    std::size_t frames() const { return completed_.size(); }

  private:
    struct Waiting {
        Frame frame;
        TimePoint since;
    };
    struct Node {
        std::unique_ptr<Controller> controller;
        std::vector<Waiting> waiting;
        std::size_t expected = 0;  ///< index in completed_ of what it should read next
    };

    static std::uint64_t number(TimePoint time) {
        return static_cast<std::uint64_t>(time.time_since_epoch().count());
    }

    void send(std::size_t index) {
        Frame frame;
        frame.extended = random_() % 4 == 0;
        frame.id = static_cast<std::uint32_t>(random_() % 63 * 32 + index);  // of this node only
        if (frame.extended) frame.id = frame.id << 18 | static_cast<std::uint32_t>(random_() % 9);
        frame.length = 8;
        ++sent_;
        for (std::size_t i = 0; i < 8; ++i) {
            frame.data[i] = static_cast<std::uint8_t>(sent_ >> (8 * i));
        }
        const SendResult result = nodes_[index].controller->send(frame);
        if (std::holds_alternative<TransmitHandle>(result)) {
            nodes_[index].waiting.push_back({frame, bus_.now()});
        } else {
            EXPECT_EQ(result, SendResult{SendError::full});
        }
    }

    void complete(const CompletedFrame& completed) {
        const std::uint32_t urgency = arbitration_field(completed.frame);
        std::size_t found = 0;
        for (Node& node : nodes_) {
            std::erase_if(node.waiting, [&](const Waiting& each) {
                const bool is_it = each.frame == completed.frame;
                found += is_it ? 1U : 0U;
                return is_it;
            });
            for (const Waiting& each : node.waiting) {
                if (each.since <= completed.start) {
                    EXPECT_GE(arbitration_field(each.frame), urgency)
                        << "frame " << completed_.size();
                }
            }
        }
        EXPECT_EQ(found, 1U) << "frame " << completed_.size();
        completed_.push_back(completed);
    }

    /// Every other node's frames, each once, in the order in which they were on the bus.
    void read(Node& node) {
        while (const auto event = node.controller->poll()) {
            const auto* received = std::get_if<Received>(&*event);
            if (received == nullptr) continue;
            skip_own(node);
            ASSERT_LT(node.expected, completed_.size());
            ASSERT_EQ(received->frame, completed_[node.expected].frame);
            ASSERT_EQ(received->time, completed_[node.expected].time);
            ++node.expected;
        }
        skip_own(node);
    }

    void skip_own(Node& node) {
        while (node.expected < completed_.size() &&
               completed_[node.expected].sender == node.controller->node()) {
            ++node.expected;
        }
    }

    std::mt19937_64 random_{20'011'123};
    Bus bus_;
    std::vector<CompletedFrame> completed_;
    std::uint64_t sent_ = 0;
    std::array<Node, node_count> nodes_;
};

TEST(Traffic, Of32NodesArrivesOnceEverywhereInTheOrderOfPriority) {
    Traffic traffic{Fidelity::frames};
    traffic.run(10'000'000);
    RecordProperty("frames", static_cast<int>(traffic.frames()));
}

TEST(Traffic, Of32NodesDoesSoBitByBit) {
    Traffic traffic{Fidelity::bits};
    traffic.run(std::min<std::uint64_t>(10'000'000, 1'000'000 * canorb::test::soak_factor()));
    RecordProperty("frames", static_cast<int>(traffic.frames()));
}

}  // namespace
}  // namespace canorb::can::sim::test
