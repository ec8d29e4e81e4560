#include "orb/can/link/descriptor.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cstring>

namespace canorb::can {
namespace {

timespec to_timespec(Duration time) {
    timespec result{};
    result.tv_sec = static_cast<time_t>(time / std::chrono::seconds{1});
    result.tv_nsec = static_cast<long>((time % std::chrono::seconds{1}).count());
    return result;
}

void set_timer(int fd, int flags, Duration first, Duration interval) {
    const itimerspec setting{.it_interval = to_timespec(interval), .it_value = to_timespec(first)};
    ::timerfd_settime(fd, flags, &setting, nullptr);
}

void change_epoll(int epoll, int operation, int fd, std::uint32_t events) {
    epoll_event interest{};
    interest.events = events;
    interest.data.fd = fd;
    ::epoll_ctl(epoll, operation, fd, &interest);
}

}  // namespace

void Descriptor::reset() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
}

Signal::Signal() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

void Signal::raise() const {
    // It only fails when the counter is full, and then the descriptor is readable anyway.
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(fd_.get(), &one, sizeof one);
}

void Signal::clear() const {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(fd_.get(), &count, sizeof count);
}

Timer::Timer() : fd_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {}

void Timer::set_at(TimePoint due) const {
    set_timer(fd(), TFD_TIMER_ABSTIME, due.time_since_epoch(), Duration::zero());
}

void Timer::set_after(Duration delay) const {
    set_timer(fd(), 0, delay, Duration::zero());
}

void Timer::repeat(Duration interval) const {
    set_timer(fd(), 0, interval, interval);
}

void Timer::stop() const {
    set_timer(fd(), 0, Duration::zero(), Duration::zero());
}

bool Timer::take_expiry() const {
    std::uint64_t expirations = 0;
    return ::read(fd(), &expirations, sizeof expirations) > 0;
}

void watch(const Descriptor& epoll, int fd) {
    change_epoll(epoll.get(), EPOLL_CTL_ADD, fd, EPOLLIN);
}

void watch_writable(const Descriptor& epoll, int fd, bool on) {
    change_epoll(epoll.get(), EPOLL_CTL_MOD, fd, on ? EPOLLIN | EPOLLOUT : EPOLLIN);
}

std::string error_text(int error) {
    // Not std::generic_category(): to check a virtual call UndefinedBehaviorSanitizer opens a pipe,
    // and what is told here may be that there are no more descriptors.
    std::array<char, 128> buffer{};
    return ::strerror_r(error, buffer.data(), buffer.size());
}

}  // namespace canorb::can
