// The bus daemon at 1 Mbit/s with one sender that saturates it: the bus load it keeps, and how long
// after the end of EOF the receiving client has read a frame. Daemon, sender and receiver are
// processes of their own.
//
//     daemon_pacing [SECONDS]
//
// It ignores options of Google Benchmark, which ./run bench gives to all benchmarks.

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "orb/can/frame_length.hpp"
#include "orb/can/link/bus_server.hpp"
#include "orb/can/link/link.hpp"
#include "orb/can/link/sim_link.hpp"

namespace {

using namespace canorb;
using namespace canorb::can;
using namespace std::chrono_literals;

constexpr std::uint32_t bitrate = 1'000'000;

/// A child process, killed at the end.
class Child {
  public:
    explicit Child(const std::function<void()>& body) : pid_(::fork()) {
        if (pid_ != 0) return;
        body();
        std::_Exit(0);
    }
    ~Child() {
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

  private:
    pid_t pid_;
};

/// Waits for the daemon, which may not listen yet.
std::unique_ptr<Controller> attach(const SimAddress& address, const char* name) {
    while (true) {
        if (auto link = open_sim_link(address)) {
            if (auto controller = (*link)->attach(name)) return std::move(*controller);
        }
        std::this_thread::sleep_for(1ms);
    }
}

void wait_for(const Controller& controller, int timeout_ms = -1) {
    pollfd descriptor{controller.event_fd(), POLLIN, 0};
    ::poll(&descriptor, 1, timeout_ms);
}

void serve(const SimAddress& address) {
    BusServerOptions options;
    options.path = address.path;
    options.bitrate = bitrate;
    const auto server = BusServer::open(std::move(options));
    if (server) (*server)->run();
}

void saturate(const SimAddress& address, const Frame& frame) {
    const auto controller = attach(address, "sender");
    while (true) {
        while (std::holds_alternative<TransmitHandle>(controller->send(frame))) continue;
        wait_for(*controller);
        while (controller->poll()) continue;
    }
}

double microseconds(Duration duration) {
    return static_cast<double>(duration.count()) / 1e3;
}

double percent(std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

/// Whether there was something to measure.
bool measure(std::uint8_t octets, Duration length) {
    Frame frame;
    frame.id = 0x123;
    frame.length = octets;
    for (std::uint8_t i = 0; i < octets; ++i) frame.data[i] = static_cast<std::uint8_t>(0x5A + i);

    const SimAddress address{"/tmp/canorb-bench-" + std::to_string(::getpid())};
    const Child daemon{[&] { serve(address); }};
    const auto receiver = attach(address, "receiver");
    const std::array<Filter, 1> all{Filter{}};
    if (!receiver->set_filters(all)) return false;
    const Child sender{[&] { saturate(address, frame); }};

    std::vector<Duration> delays;
    std::uint64_t lost = 0;
    const TimePoint begin = monotonic_now() + 200ms;  // the sender is at work by then
    const auto start = [&] { return request_bus_report(address); };
    auto first = start();
    bool measuring = false;
    while (monotonic_now() < begin + length) {
        wait_for(*receiver, 100);
        if (!measuring && monotonic_now() >= begin) {
            first = start();
            measuring = true;
        }
        while (const auto event = receiver->poll()) {
            const TimePoint now = monotonic_now();
            if (const auto* received = std::get_if<Received>(&*event)) {
                if (received->time >= begin) delays.push_back(now - received->time);
            } else if (const auto* gap = std::get_if<FramesLost>(&*event)) {
                lost += gap->count;
            }
        }
    }
    const auto last = start();
    ::unlink(address.path.c_str());
    if (!first || !last || delays.empty()) {
        const std::string reason = !first ? first.error().reason
                                   : last ? "none came"
                                          : last.error().reason;
        std::fprintf(stderr, "daemon_pacing: no frames: %s\n", reason.c_str());
        return false;
    }
    std::sort(delays.begin(), delays.end());
    const auto at = [&](double part) {
        return microseconds(
            delays[static_cast<std::size_t>(part * static_cast<double>(delays.size() - 1))]);
    };
    const BusReport& from = *first;
    const BusReport& to = *last;
    std::printf(
        "%u octets, %u us a frame: load %.2f %%; read after median %.1f us, 90 %% %.1f us, 99 %% "
        "%.1f us, longest %.1f us; %zu frames, %llu lost\n",
        octets, frame_length(frame),
        percent(to.bus.busy_bits - from.bus.busy_bits, to.bus.bits - from.bus.bits), at(0.5),
        at(0.9), at(0.99), at(1.0), delays.size(), static_cast<unsigned long long>(lost));
    return true;
}

/// Nothing where it is no whole number of seconds, from 1 to 3600.
std::optional<int> parse_seconds(std::string_view text) {
    int seconds = 0;
    const auto end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, seconds);
    if (parsed.ec != std::errc{} || parsed.ptr != end || seconds < 1 || seconds > 3600) {
        return std::nullopt;
    }
    return seconds;
}

}  // namespace

int main(int argc, char** argv) {
    int seconds = 5;
    for (int i = 1; i < argc; ++i) {
        const std::string_view argument{argv[i]};
        if (argument.starts_with("--benchmark_")) continue;
        const auto parsed = parse_seconds(argument);
        if (!parsed) {
            std::fprintf(stderr, "usage: daemon_pacing [SECONDS], not %s\n", argv[i]);
            return 2;
        }
        seconds = *parsed;
    }
    bool measured = true;
    for (const std::uint8_t octets : {std::uint8_t{8}, std::uint8_t{0}}) {
        measured = measure(octets, std::chrono::seconds{seconds}) && measured;
    }
    return measured ? 0 : 1;
}
