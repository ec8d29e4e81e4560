// The panels of all nodes that run_plant started, on one terminal.

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "common/program.hpp"
#include "console.hpp"
#include "line_reader.hpp"
#include "panel.hpp"
#include "screen.hpp"

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds step_length{50};

// A process: what it writes is appended to NAME.out, what it reads comes through the FIFO NAME.in.
class Node {
  public:
    Node(const std::string& folder, std::string name)
        : name_(std::move(name)),
          output_(open(folder + "/" + name_ + ".out", O_RDONLY)),
          // Never waits, and the process need not be there.
          input_(open(folder + "/" + name_ + ".in", O_RDWR | O_NONBLOCK)),
          lines_(output_, plant::LineReader::End::may_grow) {}
    ~Node() {
        ::close(output_);
        ::close(input_);
    }
    Node(const Node&) = delete;
    Node& operator=(const Node&) = delete;

    const std::string& name() const { return name_; }
    plant::LineReader& lines() { return lines_; }
    // False: it does not read.
    bool send(const std::string& command) const {
        const std::string line = command + "\n";
        return ::write(input_, line.data(), line.size()) == static_cast<ssize_t>(line.size());
    }

  private:
    static int open(const std::string& path, int flags) {
        const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
        if (descriptor < 0) throw std::system_error(errno, std::generic_category(), path);
        return descriptor;
    }

    std::string name_;
    int output_;
    int input_;
    plant::LineReader lines_;
};

using Nodes = std::vector<std::unique_ptr<Node>>;

void run_on_screen(Nodes& nodes, plant::Screen& screen, Clock::time_point end) {
    while (!common::StopSignals::requested() && !screen.quit() && Clock::now() < end) {
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            nodes[i]->lines().read([&](std::string_view line) {
                if (auto panel = plant::parse_panel(plant::text_of_output_line(line))) {
                    screen.show(i, std::move(*panel));
                } else {
                    screen.tell(line);
                }
            });
        }
        screen.draw();
        pollfd keys{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        ::poll(&keys, 1, static_cast<int>(step_length.count()));
        while (const auto typed = screen.next_command()) {
            const Node& node = *nodes[typed->panel];
            if (!node.send(typed->command)) screen.tell(node.name() + " does not read commands");
        }
    }
}

// "sensor-11 value temperature 80"; false: "quit".
bool carry_out(const Nodes& nodes, std::string_view line) {
    if (line == "quit") return false;
    const std::size_t blank = std::min(line.find(' '), line.size());
    const auto node = std::ranges::find_if(
        nodes, [&](const auto& known) { return known->name() == line.substr(0, blank); });
    if (node == nodes.end() || blank == line.size()) {
        std::string names;
        for (const auto& known : nodes) names += " " + known->name();
        fmt::print("'{}': write quit, or a node and its command. There are{}\n", line, names);
    } else if (!(*node)->send(std::string{line.substr(blank + 1)})) {
        fmt::print("{} does not read commands\n", (*node)->name());
    }
    return true;
}

void run_in_lines(Nodes& nodes, Clock::time_point end) {
    plant::LineReader commands{STDIN_FILENO};
    bool go_on = true;
    while (go_on && !common::StopSignals::requested() && Clock::now() < end) {
        for (const auto& node : nodes)
            node->lines().read([](std::string_view line) { fmt::print("{}\n", line); });
        std::fflush(stdout);
        pollfd input{.fd = commands.at_end() ? -1 : STDIN_FILENO, .events = POLLIN, .revents = 0};
        ::poll(&input, 1, static_cast<int>(step_length.count()));
        commands.read([&](std::string_view line) { go_on = go_on && carry_out(nodes, line); });
    }
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "Shows the panels of the plant's processes, and gives them the commands that are typed.\n"
        "run_plant starts it. Without a terminal it takes lines such as\n"
        "    sensor-11 value temperature 80\n"
        "and stops by itself.",
        "plant_panels"};
    common::set_up(app);
    std::string folder;
    std::vector<std::string> names;
    std::string title = "canorb: the plant";
    int seconds = 0;
    app.add_option("--folder", folder, "Where the processes' NAME.in and NAME.out are")->required();
    app.add_option("--title", title, "The first line")->capture_default_str();
    auto* const limited =
        app.add_option("--seconds", seconds, "Stop after so long")->check(CLI::Range(1, 1'000'000));
    app.add_option("NAME", names, "The processes, in the order of their panels")->required();
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;

    return common::run_program("plant_panels", [&] {
        Nodes nodes;
        for (const std::string& name : names) nodes.push_back(std::make_unique<Node>(folder, name));
        const common::StopSignals stop_signals;
        const auto screen = plant::has_terminal() ? plant::Screen::open(title, names) : nullptr;
        if (!screen && limited->count() == 0) seconds = 20;
        const auto end =
            seconds > 0 ? Clock::now() + std::chrono::seconds{seconds} : Clock::time_point::max();
        if (screen) {
            run_on_screen(nodes, *screen, end);
        } else {
            run_in_lines(nodes, end);
        }
    });
}
