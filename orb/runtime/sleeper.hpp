#pragma once

#include <atomic>
#include <cstdint>

#include "orb/base/time.hpp"
#include "orb/can/controller.hpp"
#include "orb/can/link/descriptor.hpp"

namespace canorb::runtime {

/// One thread sleeps, any thread wakes it. A wake() while nobody sleeps makes the next sleep end at
/// once. It costs a system call only where somebody does.
class Sleeper final : public can::Waker {
  public:
    /// From a signal handler, too.
    void wake() noexcept override;

    /// Until woken, or that long.
    void sleep(Duration longest);
    /// The same, and until `fd` is readable, which is returned.
    bool sleep_for(int fd, Duration longest);

  private:
    enum State : std::uint32_t { awake, woken, asleep, asleep_on_descriptors };

    /// False: it is woken already.
    bool fall_asleep(State how);

    std::atomic<std::uint32_t> state_ = awake;
    const can::Signal signal_;
};

}  // namespace canorb::runtime
