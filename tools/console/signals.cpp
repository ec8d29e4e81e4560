#include "tools/console/signals.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace canorb::console {
namespace {

sigset_t stop_signals() {
    sigset_t set;
    ::sigemptyset(&set);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&set, signal);
    return set;
}

}  // namespace

StopSignals::StopSignals() {
    const sigset_t set = stop_signals();
    ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
    arrived_ = can::Descriptor{::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK)};
}

StopSignals::~StopSignals() {
    const sigset_t set = stop_signals();
    ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

StopSignals::Woken StopSignals::wait(int descriptor, int timeout_ms) const {
    std::array<pollfd, 2> waiting{pollfd{arrived_.get(), POLLIN, 0}, pollfd{descriptor, POLLIN, 0}};
    while (::poll(waiting.data(), waiting.size(), timeout_ms) < 0 && errno == EINTR) continue;
    if (waiting[0].revents == 0) {
        return waiting[1].revents == 0 ? Woken::by_time : Woken::by_descriptor;
    }
    // Taken, so that it does not end the program later; another one does, at once.
    signalfd_siginfo ignored;
    static_cast<void>(!::read(arrived_.get(), &ignored, sizeof ignored));
    const sigset_t set = stop_signals();
    ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
    return Woken::by_signal;
}

}  // namespace canorb::console
