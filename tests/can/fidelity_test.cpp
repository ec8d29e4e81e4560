// Two speeds, one truth: whatever is done to a bus, simulating undisturbed frames in one step shows
// the same as simulating them bit by bit.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "orb/can/sim/controller.hpp"
#include "tests/support/soak.hpp"

namespace canorb::can::sim::test {
namespace {

constexpr std::uint64_t schedules = 10'000;
constexpr std::uint32_t bitrates[] = {5'000, 83'333, 125'000, 500'000, 1'000'000};
constexpr std::array<Filter, 3> filters{Filter{0, 0, false, false}, Filter{0, 0, true, true},
                                        Filter{0x7F0, 0x120, false, false}};

/// Everything that a user of the bus can see, in order, as numbers.
using Log = std::vector<std::uint64_t>;

std::uint64_t number(TimePoint time) {
    return static_cast<std::uint64_t>(time.time_since_epoch().count());
}

class Schedule {
  public:
    Schedule(std::uint64_t seed, Fidelity fidelity) : random_(seed), bus_(pick(bitrates)) {
        bus_.set_fidelity(fidelity);
        bus_.set_trace([this](const CompletedFrame& frame) {
            log_.insert(log_.end(), {number(frame.start), number(frame.time), frame.frame.id,
                                     frame.bits, frame.stuff_bits, frame.lost_arbitrations,
                                     static_cast<std::uint64_t>(frame.sender)});
        });
        if (below(2) == 0) return;  // nobody who wants to know of each fruitless attempt
        bus_.set_error_trace([this](const NodeError& error) {
            log_.insert(log_.end(),
                        {number(error.time), static_cast<std::uint64_t>(error.node),
                         sja1000_error_code(error.capture), error.status.tec, error.status.rec,
                         error.active_flag ? 1U : 0U, error.primary ? 1U : 0U});
        });
    }

    Log run() {
        for (std::uint64_t i = 0, nodes = below(5); i <= nodes; ++i) attach();
        for (std::uint64_t i = 0, actions = 8 + below(20); i < actions; ++i) act();
        for (int i = 0; i < 50 && bus_.advance_one(); ++i) look();
        const BusStatistics statistics = bus_.statistics();
        log_.insert(log_.end(), {statistics.busy_bits, statistics.frames, statistics.error_frames});
        return std::move(log_);
    }

  private:
    std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
    std::uint32_t pick(std::span<const std::uint32_t> choices) {
        return choices[below(choices.size())];
    }

    void attach() {
        NodeOptions options;
        options.mailboxes = 1 + below(4);
        options.receive_capacity = 1 + below(4);
        options.automatic_recovery = below(4) == 0;
        nodes_.push_back(std::make_unique<Controller>(bus_, options));
        if (below(8) != 0) {
            EXPECT_TRUE(nodes_.back()->set_filters(filters));
        }
        if (below(10) == 0) {
            EXPECT_TRUE(nodes_.back()->set_listen_only(true));
        }
    }

    /// Few identifiers and data, so that frames meet, and some are the same.
    Frame frame() {
        static constexpr std::uint32_t ids[] = {0x000, 0x123, 0x124, 0x555, 0x7EF};
        Frame frame;
        frame.id = pick(ids);
        frame.extended = below(4) == 0;
        if (frame.extended && below(2) == 0)
            frame.id = frame.id << 18 | static_cast<std::uint32_t>(below(4));
        frame.remote = below(8) == 0;
        frame.length = static_cast<std::uint8_t>(below(4) == 0 ? below(9) : below(2));
        if (below(3) == 0) frame.data.fill(static_cast<std::uint8_t>(below(2) * 0xFF));
        return frame;
    }

    void act() {
        Controller& node = *nodes_[below(nodes_.size())];
        const std::uint64_t bit = 1'000'000'000 / bus_.bitrate();
        switch (below(24)) {
            default:
                send(node);
                break;
            case 10:
                node.abort(TransmitHandle{1 + below(6)});
                break;
            case 11:
                EXPECT_TRUE(node.set_listen_only(below(3) == 0));
                break;
            case 12:
                attach();
                break;
            case 13:
                if (nodes_.size() > 1) {
                    nodes_.erase(nodes_.begin() +
                                 static_cast<std::ptrdiff_t>(below(nodes_.size())));
                }
                break;
            case 14:
                EXPECT_EQ(node.recover(), std::nullopt);
                break;
            case 15:
            case 16:
                bus_.advance(bus_.now() + Duration{static_cast<Duration::rep>(below(300 * bit))});
                break;
            case 17:
                bus_.advance(bus_.now() + Duration{static_cast<Duration::rep>(below(2 * bit))});
                break;
            case 18:
                bus_.advance(bus_.now() + Duration{static_cast<Duration::rep>(below(5000 * bit))});
                break;
            case 19:
            case 20:
            case 21:
                bus_.advance_one();
                break;
            case 22:
                collide();
                break;
            case 23:
                EXPECT_TRUE(node.set_filters(filters));
                break;
        }
        look();
    }

    void send(Controller& node) {
        const SendResult result = node.send(frame(), {.one_shot = below(4) == 0});
        log_.push_back(result.index());
    }

    /// Frames that differ in their data only: their senders drive each other to bus-off.
    void collide() {
        for (std::uint64_t i = 0; i < nodes_.size(); ++i) {
            Frame frame;
            frame.length = 1;
            frame.data[0] = static_cast<std::uint8_t>(i);
            log_.push_back(nodes_[i]->send(frame).index());
        }
    }

    void look() {
        log_.push_back(number(bus_.now()));
        log_.push_back(number(bus_.next_event()));
        for (const auto& node : nodes_) {
            const ErrorStatus status = node->error_status();
            log_.insert(log_.end(),
                        {static_cast<std::uint64_t>(status.state), status.tec, status.rec});
            const NodeStatistics statistics = bus_.statistics(node->node());
            log_.insert(log_.end(), {statistics.sent, statistics.received, statistics.errors,
                                     statistics.lost_arbitrations, statistics.overruns,
                                     statistics.arbitration_lost_at.value_or(99)});
            if (statistics.last_error) log_.push_back(sja1000_error_code(*statistics.last_error));
            if (below(3) == 0) continue;  // its events wait, and hold its mailboxes
            while (const auto event = node->poll()) std::visit(*this, *event);
        }
    }

  public:
    void operator()(const Received& event) {
        log_.insert(log_.end(), {1, number(event.time), event.frame.id, event.frame.length,
                                 event.frame.data[0]});
    }
    void operator()(const TransmitResult& event) {
        log_.insert(log_.end(), {2, number(event.time), static_cast<std::uint64_t>(event.handle),
                                 static_cast<std::uint64_t>(event.outcome)});
    }
    void operator()(const StateChanged& event) {
        log_.insert(log_.end(),
                    {3, number(event.time), static_cast<std::uint64_t>(event.status.state)});
    }
    void operator()(const FramesLost& event) {
        log_.insert(log_.end(), {4, number(event.time), event.count});
    }

  private:
    std::mt19937_64 random_;
    Bus bus_;
    std::vector<std::unique_ptr<Controller>> nodes_;
    Log log_;
};

/// What a log has at a place and before it.
std::string around(const Log& log, std::ptrdiff_t place) {
    std::string text;
    const std::ptrdiff_t end = std::min(place + 60, static_cast<std::ptrdiff_t>(log.size()));
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(place - 230, 0); i < end; ++i) {
        text += (i == place ? " >" : " ") + std::to_string(log[static_cast<std::size_t>(i)]);
    }
    return text;
}

TEST(Fidelity, FramesInOneStepShowTheSameAsBits) {
    const std::uint64_t runs = schedules * canorb::test::soak_factor();
    std::uint64_t numbers = 0;
    for (std::uint64_t seed = 0; seed < runs; ++seed) {
        canorb::test::show_progress("schedules", seed, runs);
        const Log frames = Schedule{seed, Fidelity::frames}.run();
        const Log bits = Schedule{seed, Fidelity::bits}.run();
        numbers += frames.size();
        const auto [left, right] =
            std::mismatch(frames.begin(), frames.end(), bits.begin(), bits.end());
        ASSERT_TRUE(left == frames.end() && right == bits.end())
            << "schedule " << seed << " differs at number " << left - frames.begin() << " of "
            << frames.size() << " and " << bits.size() << ":\n"
            << around(frames, left - frames.begin()) << "\n"
            << around(bits, right - bits.begin());
    }
    RecordProperty("numbers compared", std::to_string(numbers));
}

}  // namespace
}  // namespace canorb::can::sim::test
