// How fast the simulated bus is, against the bus that it simulates: 1 Mbit/s, saturated by all of
// its nodes. `real_time` is simulated time over processor time of one core.

#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "orb/can/sim/controller.hpp"

namespace canorb::can::sim {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t bitrate = 1'000'000;
constexpr std::array<Filter, 1> everything{Filter{}};

/// Nodes that always have a frame waiting, each with identifiers of its own.
class SaturatedBus {
  public:
    SaturatedBus(std::size_t nodes, Fidelity fidelity) : bus_(bitrate) {
        bus_.set_fidelity(fidelity);
        for (std::size_t i = 0; i < nodes; ++i) {
            nodes_.push_back(std::make_unique<Controller>(bus_, NodeOptions{.name = {}}));
            if (!nodes_.back()->set_filters(everything)) std::abort();
            send(i);
        }
    }

    /// Until the frame on the bus is over and everybody has read it.
    void next_frame() {
        bus_.advance_one();
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            while (const auto event = nodes_[i]->poll()) {
                if (std::holds_alternative<TransmitResult>(*event)) send(i);
            }
        }
    }

    const Bus& bus() const { return bus_; }

  private:
    void send(std::size_t node) {
        Frame frame;
        // The order of the nodes changes from frame to frame, so that all of them send.
        frame.id = static_cast<std::uint32_t>((sent_++ % 32) * 32 + node);
        frame.length = 8;
        for (std::uint8_t& octet : frame.data) octet = static_cast<std::uint8_t>(random_ >>= 1);
        random_ = (random_ ^ sent_) * 0x9E3779B97F4A7C15U;
        benchmark::DoNotOptimize(nodes_[node]->send(frame));
    }

    Bus bus_;
    std::vector<std::unique_ptr<Controller>> nodes_;
    std::uint64_t sent_ = 0;
    std::uint64_t random_ = 1;
};

void saturated(benchmark::State& state, Fidelity fidelity) {
    SaturatedBus saturated{static_cast<std::size_t>(state.range(0)), fidelity};
    const TimePoint start = saturated.bus().now();
    for (auto _ : state) saturated.next_frame();
    const std::chrono::duration<double> simulated = saturated.bus().now() - start;
    state.counters["times_real_time"] =
        benchmark::Counter(simulated.count(), benchmark::Counter::kIsRate);
    state.counters["bit/s"] =
        benchmark::Counter(simulated.count() * bitrate, benchmark::Counter::kIsRate);
    const BusStatistics statistics = saturated.bus().statistics();
    if (statistics.error_frames != 0) state.SkipWithError("there were errors on the bus");
    state.counters["load_percent"] =
        100 * static_cast<double>(statistics.busy_bits) / (simulated.count() * bitrate);
}
BENCHMARK_CAPTURE(saturated, bit_by_bit, Fidelity::bits)->Arg(2)->Arg(8)->Arg(32);
BENCHMARK_CAPTURE(saturated, frames_in_one_step, Fidelity::frames)->Arg(2)->Arg(8)->Arg(32);

/// An hour without a frame.
void idle(benchmark::State& state) {
    Bus bus{bitrate};
    bus.set_fidelity(Fidelity::bits);
    std::vector<std::unique_ptr<Controller>> nodes;
    for (int i = 0; i < 8; ++i) nodes.push_back(std::make_unique<Controller>(bus));
    for (auto _ : state) bus.advance(bus.now() + 1h);
}
BENCHMARK(idle);

}  // namespace
}  // namespace canorb::can::sim

BENCHMARK_MAIN();
