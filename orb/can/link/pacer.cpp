#include "orb/can/link/pacer.hpp"

#include <algorithm>
#include <variant>

#include "orb/can/link/link.hpp"

namespace canorb::can {
namespace {

constexpr int vain_wakes_allowed = 64;
constexpr Duration least_sleep = std::chrono::microseconds{100};

/// In the time that a machine needs for it, with a hundred nodes and bit by bit, nobody waits in
/// vain.
constexpr Duration step = std::chrono::microseconds{200};
/// A machine that had no processor for the bus may well have caught up by then.
constexpr Duration longest_lag = std::chrono::seconds{1};

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

bool PacedClock::advance(sim::Bus& bus, TimePoint to, TimePoint deadline) const {
    const TimePoint aim = to - slipped_;
    while (bus.now() < aim) {
        bus.advance(std::min(aim, std::max(bus.now() + step, bus.next_event())));
        if (bus.now() < aim && monotonic_now() >= deadline) return false;
    }
    return true;
}

bool PacedClock::slip(const sim::Bus& bus, TimePoint now) {
    const Duration lag = now - machine_time(bus.now());
    if (lag <= longest_lag) return false;
    slipped_ += lag;
    return true;
}

ControllerEvent PacedClock::machine_time(ControllerEvent event) const {
    std::visit([this](auto& form) { form.time += slipped_; }, event);
    return event;
}

}  // namespace canorb::can
