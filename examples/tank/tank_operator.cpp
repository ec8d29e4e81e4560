// The operator station: any terminal program does it as well.

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <string>
#include <system_error>

#include "common/program.hpp"
#include "keyboard.hpp"
#include "schedule.hpp"
#include "serial_terminal.hpp"

namespace {

using Clock = std::chrono::steady_clock;

// Reads what is there; empty at the end of the input.
std::string read_some(int file_descriptor) {
    std::array<char, 1024> buffer;
    const ssize_t count = ::read(file_descriptor, buffer.data(), buffer.size());
    return {buffer.data(), count > 0 ? static_cast<std::size_t>(count) : 0};
}

// False when nobody takes it any more.
bool print(std::string_view text) {
    while (!text.empty()) {
        const ssize_t count = ::write(STDOUT_FILENO, text.data(), text.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        text.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
}

// Keys to the line, the line's text to standard output, until the line is closed (which is an
// error), nobody reads the output, `end`, or a signal.
void serve(int line, const std::string& path, Clock::time_point end) {
    bool keys = ::isatty(STDIN_FILENO) == 0 || tank::has_keyboard();
    while (!common::StopSignals::requested() && Clock::now() < end) {
        std::array<pollfd, 2> waiting{
            pollfd{.fd = line, .events = POLLIN, .revents = 0},
            pollfd{.fd = keys ? STDIN_FILENO : -1, .events = POLLIN, .revents = 0}};
        constexpr int until_next_look_ms = 100;
        if (::poll(waiting.data(), waiting.size(), until_next_look_ms) <= 0) continue;
        if (waiting[0].revents != 0) {
            const std::string text = read_some(line);
            if (text.empty()) throw std::runtime_error(path + ": node A has closed the line");
            if (!print(text)) return;
        }
        if (waiting[1].revents != 0) {
            const std::string orders = read_some(STDIN_FILENO);
            keys = !orders.empty();
            // What does not fit into the line's buffer is lost, as on any serial line.
            if (keys && ::write(line, orders.data(), orders.size()) < 0 && errno != EAGAIN)
                throw std::system_error(errno, std::generic_category(), path);
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "The tank's operator station: shows the status and sends keys as orders, until Ctrl-C.\n"
        "Orders: a b c d set the level to 50, 75, 100, 125 cm; h j k l make slots of 5, 10, 50, "
        "100 "
        "ms.\nReads orders from a pipe as well.",
        "tank_operator"};
    common::set_up(app);
    std::string path;
    app.add_option("--serial", path, "The serial line, as node A prints it")->required();
    canorb::Duration seconds{};
    const CLI::Option* const limited = common::add_parsed_option(
        app, "--seconds", seconds, tank::parse_seconds, "Stop after so long");
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;

    return common::run_program("tank_operator", [&] {
        const tank::FileDescriptor line{
            ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
        if (line.number() < 0)
            throw std::system_error(errno, std::generic_category(), "--serial " + path);
        if (::isatty(line.number()) == 0)
            throw std::runtime_error("--serial " + path + ": not a serial line");
        tank::set_raw_115200_8n1(line.number());
        // A reader that goes away must not leave the keyboard in this program's mode.
        ::signal(SIGPIPE, SIG_IGN);
        const common::StopSignals stop_signals;
        const tank::KeyboardMode keyboard;
        serve(line.number(), path,
              limited->count() > 0 ? Clock::now() + seconds : Clock::time_point::max());
    });
}
