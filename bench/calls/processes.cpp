#include "processes.hpp"

#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <thread>
#include <vector>

#include "orb/can/link/bus_server.hpp"
#include "orb/can/link/sim_link.hpp"

namespace canorb::bench {
namespace {

using namespace std::chrono_literals;

constexpr auto longest_start = 10s;

void serve(const std::string& path, std::uint32_t bitrate, bool paced, int cpu) {
    pin_to(cpu);
    can::BusServerOptions options;
    options.path = path;
    options.bitrate = bitrate;
    options.paced = paced;
    const auto server = can::BusServer::open(std::move(options));
    if (!server) throw std::runtime_error{server.error()};
    (*server)->run();
}

std::string new_path() {
    static int number = 0;
    return "/tmp/canorb-bench-" + std::to_string(::getpid()) + "-" + std::to_string(++number);
}

const std::vector<std::size_t>& usable() {
    static const std::vector<std::size_t> all = [] {
        cpu_set_t set;
        CPU_ZERO(&set);
        std::vector<std::size_t> found;
        if (::sched_getaffinity(0, sizeof(set), &set) != 0) return found;
        for (std::size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
            if (CPU_ISSET(cpu, &set)) found.push_back(cpu);
        }
        return found;
    }();
    return all;
}

}  // namespace

Child::Child(const std::function<void()>& body) : pid_(::fork()) {
    if (pid_ < 0) throw std::runtime_error{"no more processes"};
    if (pid_ > 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
        body();
        std::_Exit(0);
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "%s\n", exception.what());
    }
    std::_Exit(1);
}

Child::~Child() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
}

bool Child::is_running() const {
    siginfo_t ended{};
    const auto options = WEXITED | WNOHANG | WNOWAIT;  // for the destructor to wait for
    return ::waitid(P_PID, static_cast<id_t>(pid_), &ended, options) == 0 && ended.si_pid == 0;
}

Daemon::Daemon(std::uint32_t bitrate, bool paced, int cpu)
    : path_(new_path()), child_([&] { serve(path_, bitrate, paced, cpu); }) {
    const auto latest = std::chrono::steady_clock::now() + longest_start;
    while (!can::open_sim_link({path_})) {
        if (std::chrono::steady_clock::now() > latest) {
            throw std::runtime_error{"the daemon of the simulated bus does not come up"};
        }
        std::this_thread::sleep_for(1ms);
    }
}

Daemon::~Daemon() {
    ::unlink(path_.c_str());
}

int cpus() {
    return static_cast<int>(usable().size());
}

void pin_to(int cpu) {
    if (usable().empty()) return;
    cpu_set_t set;
    CPU_ZERO(&set);
    if (cpu < 0) {
        for (const std::size_t each : usable()) CPU_SET(each, &set);
    } else {
        CPU_SET(usable()[static_cast<std::size_t>(cpu) % usable().size()], &set);
    }
    ::sched_setaffinity(0, sizeof(set), &set);
}

}  // namespace canorb::bench
