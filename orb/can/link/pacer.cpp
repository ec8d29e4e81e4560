#include "orb/can/link/pacer.hpp"

#include <algorithm>

namespace canorb::can {
namespace {

constexpr Duration shortest_patience = std::chrono::microseconds{1};
constexpr Duration longest_patience = std::chrono::microseconds{100};

}  // namespace

TimePoint Pacer::wake_at(const sim::Bus& bus) {
    const sim::BusStatistics done = bus.statistics();
    const std::uint64_t progress = done.frames + done.error_frames;
    if (progress != progress_) {
        patience_ = Duration::zero();
    } else if (bus.now() >= wake_at_) {
        patience_ = std::clamp(2 * patience_, shortest_patience, longest_patience);
    }
    progress_ = progress;
    wake_at_ = bus.next_event();
    if (wake_at_ != never) wake_at_ = std::max(wake_at_, bus.now() + patience_);
    return wake_at_;
}

}  // namespace canorb::can
