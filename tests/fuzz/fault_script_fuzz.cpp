// Any text as a fault script: what is wrong is said with a place in the text; what is right
// disturbs a bus of three nodes without breaking the injector's promises.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "orb/can/frame_bits.hpp"
#include "orb/can/sim/fault_injector.hpp"

namespace {

using namespace canorb;
using namespace canorb::can;
using namespace std::chrono_literals;

void require(bool holds) {
    if (!holds) std::abort();
}

void require_in(std::string_view text, const sim::FaultScriptError& error) {
    require(!error.message.empty());
    std::size_t line = 1;
    while (line < error.line) {
        const std::size_t end = text.find('\n');
        require(end != std::string_view::npos);
        text.remove_prefix(end + 1);
        ++line;
    }
    require(error.line > 0);
    require(error.column > 0);
    require(error.column <= text.substr(0, text.find('\n')).size() + 1);
}

void bit(sim::FaultInjector& injector, const sim::BitMoment& moment) {
    std::vector<std::uint8_t> driven{1, 0, 1};
    std::vector<std::uint8_t> seen{0, 0, 0};
    injector.disturb_driven(moment, driven);
    injector.disturb_seen(moment, driven, seen);
    for (const std::uint8_t level : driven) require(level <= 1);
    for (const std::uint8_t level : seen) require(level <= 1);
    require(injector.next(moment.end) >= moment.end);
}

void disturb(sim::FaultScript script) {
    sim::FaultInjector injector{std::move(script), 500'000};
    injector.node_attached(sim::NodeIndex{0}, "a");
    injector.node_attached(sim::NodeIndex{1}, "b");
    injector.node_attached(sim::NodeIndex{2}, "c");
    Frame frame;
    frame.id = 0x123;
    frame.length = 1;
    const FrameBits bits = frame_bits(frame);
    TimePoint now{};
    for (int attempt = 0; attempt < 3; ++attempt) {
        const TimePoint end = now + 2us * bits.size_with_intermission();
        injector.begin_frame({frame, sim::NodeIndex{0}, now, end});
        for (const FrameBit& each : bits) {
            bit(injector, {now, now + 2us, each.position});
            now += 2us;
        }
        const TimePoint next = injector.next(now);
        if (next < TimePoint{1'000'000s}) now = next;
        bit(injector, {now, now + 2us, {}});
        now += 2us;
        if (attempt == 1) injector.node_detached(sim::NodeIndex{0});
        if (attempt == 1) injector.node_attached(sim::NodeIndex{0}, "b");
    }
    require(injector.unused().size() <= injector.script().faults.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text{data, data + size};
    auto script = sim::parse_fault_script(text);
    if (script) {
        disturb(std::move(*script));
        return 0;
    }
    require(!script.error().empty());
    require(script.error().size() <= sim::max_fault_script_errors + 1);
    for (const sim::FaultScriptError& error : script.error()) require_in(text, error);
    return 0;
}
