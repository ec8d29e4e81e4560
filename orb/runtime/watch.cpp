#include "orb/runtime/watch.hpp"

#include <sys/epoll.h>

#include <algorithm>

#include "canorb/exceptions.hpp"

namespace canorb::runtime {

Watch::Watch(int controller) : epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
    if (!epoll_.is_open() || !signal_.is_open() || !timer_.is_open()) {
        throw_system_exception(cause::no_file_descriptors, "event_fd()");
    }
    can::watch(epoll_, controller);
    can::watch(epoll_, signal_.fd());
    can::watch(epoll_, timer_.fd());
}

void Watch::rearm(TimePoint due) const {
    signal_.clear();
    static_cast<void>(timer_.take_expiry());
    if (due == never) {
        timer_.stop();
    } else {
        timer_.set_at(std::max(due, TimePoint{Duration{1}}));
    }
}

}  // namespace canorb::runtime
