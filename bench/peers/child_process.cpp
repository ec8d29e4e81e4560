#include "child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <system_error>
#include <thread>

#include "ending_signals.hpp"

namespace peers {

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// What is left to do where the process ends without its destructors.
struct Leftovers {
    std::mutex mutex;
    std::vector<pid_t> children;
    std::vector<std::filesystem::path> directories;
};

Leftovers& leftovers() {
    static Leftovers all;
    return all;
}

std::atomic<bool> interrupted{false};

[[noreturn]] void throw_errno(const std::string& what) {
    throw std::system_error(errno, std::generic_category(), what);
}

void watch_signals() {
    const sigset_t signals = ending_signals();
    int signal = 0;
    if (sigwait(&signals, &signal) != 0) return;
    interrupted = true;
    std::this_thread::sleep_for(2s);
    {
        auto& left = leftovers();
        const std::lock_guard lock{left.mutex};
        for (const pid_t child : left.children) ::kill(child, SIGKILL);
        std::error_code ignored;
        for (const auto& path : left.directories) std::filesystem::remove_all(path, ignored);
    }
    ::_exit(128 + signal);
}

/// In the child, between fork and exec: only what is safe there.
[[noreturn]] void become(char* const* arguments, int output, pid_t parent, std::optional<int> cpu) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(126);  // it ended before that
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    if (cpu) {
        cpu_set_t set;
        CPU_ZERO(&set);
        CPU_SET(static_cast<std::size_t>(*cpu), &set);
        if (::sched_setaffinity(0, sizeof(set), &set) != 0) ::_exit(126);
    }
    ::dup2(output, STDOUT_FILENO);
    ::execv(arguments[0], arguments);
    ::_exit(127);
}

}  // namespace

void handle_signals() {
    block_ending_signals();
    std::thread{watch_signals}.detach();
}

void throw_if_interrupted() {
    if (interrupted.load(std::memory_order_relaxed)) throw Interrupted{};
}

Child::Child(const std::vector<std::string>& command, std::optional<int> cpu)
    : name_(std::filesystem::path{command.at(0)}.filename().string()) {
    std::vector<std::string> copy = command;
    std::vector<char*> arguments;
    for (auto& argument : copy) arguments.push_back(argument.data());
    arguments.push_back(nullptr);

    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw_errno("pipe");
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ == 0) become(arguments.data(), ends[1], parent, cpu);
    ::close(ends[1]);
    output_ = ends[0];
    if (pid_ < 0) {
        ::close(output_);
        throw_errno("fork");
    }
    auto& left = leftovers();
    const std::lock_guard lock{left.mutex};
    left.children.push_back(pid_);
}

bool Child::read_some(Clock::time_point deadline) {
    while (true) {
        throw_if_interrupted();
        if (Clock::now() >= deadline)
            throw std::runtime_error(name_ + " says nothing for too long");
        pollfd descriptor{output_, POLLIN, 0};
        if (::poll(&descriptor, 1, 50) <= 0) continue;
        std::array<char, 4096> buffer{};
        const ssize_t count = ::read(output_, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        text_.append(buffer.data(), static_cast<std::size_t>(count));
        return true;
    }
}

std::string Child::read_line(std::chrono::milliseconds timeout) {
    const auto deadline = Clock::now() + timeout;
    std::size_t end = 0;
    while ((end = text_.find('\n')) == std::string::npos) {
        if (!read_some(deadline)) throw std::runtime_error(name_ + " ended before it was ready");
    }
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
}

std::string Child::finish(std::chrono::milliseconds timeout) {
    const auto deadline = Clock::now() + timeout;
    while (read_some(deadline)) continue;
    siginfo_t end{};
    while (::waitid(P_PID, static_cast<id_t>(pid_), &end, WEXITED | WNOWAIT) != 0) {
        if (errno != EINTR) throw_errno("waitid");
    }
    if (end.si_code != CLD_EXITED || end.si_status != 0) {
        throw std::runtime_error(name_ + " failed with " + std::to_string(end.si_status));
    }
    return std::move(text_);
}

void Child::stop() {
    ::kill(pid_, SIGTERM);
    const auto deadline = Clock::now() + 3s;
    while (::waitpid(pid_, nullptr, WNOHANG) == 0) {
        if (Clock::now() >= deadline) ::kill(pid_, SIGKILL);
        std::this_thread::sleep_for(1ms);
    }
    ::close(output_);
    auto& left = leftovers();
    const std::lock_guard lock{left.mutex};
    std::erase(left.children, pid_);
}

TemporaryDirectory::TemporaryDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "peers-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw_errno("mkdtemp");
    path_ = pattern;
    auto& left = leftovers();
    const std::lock_guard lock{left.mutex};
    left.directories.push_back(path_);
}

TemporaryDirectory::~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
    auto& left = leftovers();
    const std::lock_guard lock{left.mutex};
    std::erase(left.directories, path_);
}

std::string own_program() {
    return std::filesystem::read_symlink("/proc/self/exe").string();
}

std::string program_beside(const std::string& name) {
    const auto path = std::filesystem::path{own_program()}.parent_path() / name;
    if (!std::filesystem::exists(path)) throw std::runtime_error("not built: " + path.string());
    return path.string();
}

}  // namespace peers
