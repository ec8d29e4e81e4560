#include "orb/can/link/pacer.hpp"

#include <algorithm>

namespace canorb::can {
namespace {

constexpr int vain_wakes_allowed = 64;
constexpr Duration least_sleep = std::chrono::microseconds{100};

}  // namespace

TimePoint Pacer::wake_at(const sim::Bus& bus) {
    const sim::BusStatistics done = bus.statistics();
    const std::uint64_t progress = done.frames + done.error_frames;
    if (progress != progress_) {
        vain_wakes_ = 0;
    } else if (bus.now() >= wake_at_ && vain_wakes_ < vain_wakes_allowed) {
        ++vain_wakes_;
    }
    progress_ = progress;
    wake_at_ = bus.next_event();
    if (vain_wakes_ == vain_wakes_allowed) wake_at_ = std::max(wake_at_, bus.now() + least_sleep);
    return wake_at_;
}

}  // namespace canorb::can
