// The signals that ask a process to end, for servers that do so in an orderly way.
#pragma once

#include <pthread.h>
#include <signal.h>
#include <time.h>

namespace peers {

inline sigset_t ending_signals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGHUP);
    return signals;
}

/// For this thread and those that it will start: from now on they are to be waited for.
inline void block_ending_signals() {
    const sigset_t signals = ending_signals();
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

inline void wait_for_ending_signal() {
    const sigset_t signals = ending_signals();
    int signal = 0;
    sigwait(&signals, &signal);
}

/// Whether one came within these milliseconds.
inline bool ending_signal_within(long milliseconds) {
    const sigset_t signals = ending_signals();
    const timespec timeout{milliseconds / 1000, milliseconds % 1000 * 1'000'000};
    return sigtimedwait(&signals, nullptr, &timeout) > 0;
}

}  // namespace peers
