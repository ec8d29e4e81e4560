#include "tools/patient_output.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <utility>

#include "orb/base/counted.hpp"
#include "orb/can/link/link.hpp"

namespace canorb::tools {
namespace {

constexpr std::size_t most_waiting = 64 * 1024;

/// O_NONBLOCK is of what is open, which other processes share: a pipe or terminal is opened anew.
/// A file would begin at its beginning then, and never blocks for long.
int reopened(int descriptor) {
    struct stat status{};
    if (::fstat(descriptor, &status) != 0) return -1;
    if (!S_ISFIFO(status.st_mode) && !S_ISCHR(status.st_mode)) return -1;
    const std::string path = "/proc/self/fd/" + std::to_string(descriptor);
    return ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
}

}  // namespace

PatientOutput::PatientOutput(int descriptor, std::string name)
    : descriptor_(descriptor), own_descriptor_(reopened(descriptor)), name_(std::move(name)) {}

PatientOutput::~PatientOutput() {
    if (own_descriptor_ >= 0) ::close(own_descriptor_);
}

void PatientOutput::write(std::string_view text) {
    flush();
    if (waiting_.size() + text.size() > most_waiting) {
        ++left_out_;
        return;
    }
    if (left_out_ > 0) {
        waiting_ += name_ + ": the reader was too slow: " + counted(left_out_, "text") +
                    (left_out_ == 1 ? " was" : " were") + " left out here\n";
        left_out_ = 0;
    }
    waiting_ += text;
    flush();
}

void PatientOutput::flush() {
    while (write_some(0)) continue;
}

void PatientOutput::finish(Duration patience) {
    const TimePoint end = can::monotonic_now() + patience;
    while (true) {
        const Duration left = end - can::monotonic_now();
        const auto left_ms = std::chrono::duration_cast<std::chrono::milliseconds>(left).count();
        if (left_ms < 0 || !write_some(static_cast<int>(left_ms))) return;
    }
}

/// False when nothing is left, or no room.
bool PatientOutput::write_some(int timeout_ms) {
    if (waiting_.empty()) return false;
    const int descriptor = own_descriptor_ >= 0 ? own_descriptor_ : descriptor_;
    pollfd writable{descriptor, POLLOUT, 0};
    const int ready = ::poll(&writable, 1, timeout_ms);
    if (ready < 0 && errno == EINTR) return timeout_ms > 0;
    if (ready <= 0) return false;
    // A pipe that is writable takes so much without blocking.
    const auto written =
        ::write(descriptor, waiting_.data(), std::min<std::size_t>(waiting_.size(), PIPE_BUF));
    if (written > 0) {
        waiting_.erase(0, static_cast<std::size_t>(written));
        return true;
    }
    if (written < 0 && (errno == EAGAIN || errno == EINTR)) return false;
    waiting_.clear();  // nobody reads any more, or the disk is full
    return false;
}

}  // namespace canorb::tools
