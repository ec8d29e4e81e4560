#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace canorb::test {

/// A program that the test started. Whatever it still does when this object goes is ended.
class Child {
  public:
    enum class Input { nothing, pipe, terminal };

    /// What it says on standard output and standard error comes here. With a terminal, that is
    /// where all of it goes.
    explicit Child(std::vector<std::string> arguments, Input input = Input::nothing) {
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        if (input == Input::terminal) {
            winsize size{.ws_row = 30, .ws_col = 100, .ws_xpixel = 0, .ws_ypixel = 0};
            pid_ = ::forkpty(&output_, nullptr, nullptr, &size);
            if (pid_ < 0) throw std::runtime_error("no pseudo-terminal");
            if (pid_ == 0) {
                ::setenv("TERM", "xterm", 1);
                run(argv);
            }
            input_ = ::dup(output_);
            return;
        }
        int in[2] = {-1, -1};
        int out[2] = {-1, -1};
        if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0)
            throw std::runtime_error("no pipe");
        pid_ = ::fork();
        if (pid_ == 0) {
            ::dup2(in[0], STDIN_FILENO);
            ::dup2(out[1], STDOUT_FILENO);
            ::dup2(out[1], STDERR_FILENO);
            run(argv);
        }
        ::close(in[0]);
        ::close(out[1]);
        input_ = in[1];
        output_ = out[0];
        if (input == Input::nothing) end_input();
    }

    ~Child() {
        if (pid_ > 0) {
            ::kill(pid_, SIGKILL);
            ::waitpid(pid_, nullptr, 0);
        }
        end_input();
        ::close(output_);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    void send_signal(int signal) const { ::kill(pid_, signal); }
    void type(std::string_view text) const {
        if (::write(input_, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
            throw std::runtime_error("it takes no input");
    }
    void end_input() {
        if (input_ >= 0) ::close(input_);
        input_ = -1;
    }

    /// Reads until the output has this text after what was found before. False when it ends or
    /// takes unreasonably long first.
    bool says(std::string_view wanted) {
        const auto deadline = Clock::now() + patience;
        while (true) {
            const std::size_t found = text_.find(wanted, found_);
            if (found != std::string::npos) {
                found_ = found + wanted.size();
                return true;
            }
            if (!read_more(deadline)) return false;
        }
    }

    /// Reads to the end; the exit code, or minus the signal that ended it.
    int wait() {
        const auto deadline = Clock::now() + patience;
        while (read_more(deadline)) {
        }
        if (Clock::now() >= deadline) ::kill(pid_, SIGKILL);
        int status = 0;
        ::waitpid(pid_, &status, 0);
        pid_ = 0;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

    /// All that it said so far.
    const std::string& text() const { return text_; }

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::seconds patience{30};

    [[noreturn]] static void run(const std::vector<char*>& argv) {
        ::execv(argv[0], argv.data());
        ::_exit(127);
    }

    bool read_more(Clock::time_point deadline) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left.count() <= 0) return false;
        pollfd waiting{.fd = output_, .events = POLLIN, .revents = 0};
        if (::poll(&waiting, 1, static_cast<int>(left.count())) != 1) return false;
        char buffer[4096];
        const ssize_t count = ::read(output_, buffer, sizeof buffer);
        if (count <= 0) return false;
        text_.append(buffer, static_cast<std::size_t>(count));
        return true;
    }

    pid_t pid_ = 0;
    int input_ = -1;
    int output_ = -1;
    std::string text_;
    std::size_t found_ = 0;
};

}  // namespace canorb::test
