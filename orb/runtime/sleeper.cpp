#include "orb/runtime/sleeper.hpp"

#include <linux/futex.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>

namespace canorb::runtime {
namespace {

/// What ppoll() and futex() want; null: for ever.
class Timeout {
  public:
    explicit Timeout(Duration longest) : forever_(longest == Duration::max()) {
        const auto nanoseconds = std::max<std::int64_t>(longest.count(), 0);
        time_.tv_sec = static_cast<time_t>(nanoseconds / 1'000'000'000);
        time_.tv_nsec = static_cast<long>(nanoseconds % 1'000'000'000);
    }
    const timespec* get() const { return forever_ ? nullptr : &time_; }

  private:
    timespec time_{};
    bool forever_;
};

// A std::atomic waits without a time limit only.
void futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value,
           const timespec* timeout) {
    static_assert(sizeof word == sizeof value);
    ::syscall(SYS_futex, &word, operation, value, timeout, nullptr, 0);
}

}  // namespace

void Sleeper::wake() noexcept {
    switch (state_.exchange(woken)) {
        case asleep:
            futex(state_, FUTEX_WAKE_PRIVATE, 1, nullptr);
            break;
        case asleep_on_descriptors:
            signal_.raise();
            break;
        default:
            break;
    }
}

bool Sleeper::fall_asleep(State how) {
    std::uint32_t expected = awake;
    if (state_.compare_exchange_strong(expected, how)) return true;
    state_ = awake;
    return false;
}

void Sleeper::sleep(Duration longest) {
    if (!fall_asleep(asleep)) return;
    futex(state_, FUTEX_WAIT_PRIVATE, asleep, Timeout{longest}.get());
    state_ = awake;
}

bool Sleeper::sleep_for(int fd, Duration longest) {
    std::array<pollfd, 2> sources{{{signal_.fd(), POLLIN, 0}, {fd, POLLIN, 0}}};
    if (!fall_asleep(asleep_on_descriptors)) return false;
    ::ppoll(sources.data(), sources.size(), Timeout{longest}.get(), nullptr);
    const bool was_woken = state_.exchange(awake) == woken;
    // It may be raised only after this, and makes the next sleep a short one.
    if (was_woken || sources[0].revents != 0) signal_.clear();
    return sources[1].revents != 0;
}

}  // namespace canorb::runtime
