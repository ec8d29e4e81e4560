#pragma once

#include "orb/base/time.hpp"
#include "orb/can/link/descriptor.hpp"

namespace canorb::runtime {

/// The descriptor by which somebody else's event loop learns that an ORB has something to do:
/// readable when the controller is, when raise() was called, or when a time has come.
class Watch {
  public:
    /// Throws NO_RESOURCES when the process has no descriptors left.
    explicit Watch(int controller);

    int fd() const { return epoll_.get(); }
    void raise() const { signal_.raise(); }
    /// Forgets what was raised; readable again at that time of CLOCK_MONOTONIC, or never by time.
    void rearm(TimePoint due) const;

  private:
    can::Descriptor epoll_;
    can::Signal signal_;
    can::Timer timer_;
};

}  // namespace canorb::runtime
