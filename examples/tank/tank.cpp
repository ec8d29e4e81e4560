// The whole tank in one program: live on a screen, as status lines, or on a virtual clock.

#include <fmt/format.h>
#include <unistd.h>
#include <canorb/orb.hpp>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "common/program.hpp"
#include "live_tank.hpp"
#include "record.hpp"
#include "schedule.hpp"
#include "screen.hpp"
#include "virtual_tank.hpp"

namespace {

struct Options {
    bool on_virtual_clock = false;
    std::string bus = "local:tank";
    std::optional<canorb::Duration> limit;
    tank::VirtualTank::Options virtual_tank;
    std::string csv;
    std::string log;
    std::string plot;
};

/// A file that an option names; without a name nothing is written.
class OutputFile {
  public:
    OutputFile(std::string option, const std::string& path) : name_(option + " " + path) {
        if (path.empty()) return;
        file_.open(path, std::ios::binary | std::ios::trunc);
        check();
    }

    void write(std::string_view text) {
        if (file_.is_open()) file_ << text;
    }
    void write_line(std::string_view text) {
        if (file_.is_open()) file_ << text << '\n';
    }
    /// Throws when the file could not be written whole.
    void finish() {
        if (!file_.is_open()) return;
        file_.close();
        check();
    }

  private:
    void check() const {
        if (!file_) throw std::system_error(errno, std::generic_category(), name_);
    }

    std::string name_;
    std::ofstream file_;
};

std::string in_seconds(canorb::Duration time) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
    return fmt::format("{:>4}.{:03}", ms / 1000, ms % 1000);
}

void run_virtually(const Options& options) {
    OutputFile csv{"--csv", options.csv};
    OutputFile log{"--log", options.log};
    OutputFile plot{"--plot", options.plot};
    std::vector<tank::PlotSample> samples;
    csv.write_line(tank::csv_header);

    tank::VirtualTank tank{
        options.virtual_tank,
        {.round = [&](const tank::RoundRecord& record) { csv.write_line(tank::csv_line(record)); },
         .frame =
             [&](canorb::Duration end, const canorb::can::Frame& frame) {
                 log.write_line(tank::candump_line(end, frame));
             },
         .sample = [&](const tank::PlotSample& sample) { samples.push_back(sample); },
         .log =
             [](canorb::Duration time, std::string_view node, std::string_view text) {
                 fmt::print("{} {}: {}\n", in_seconds(time), node, text);
             }}};
    tank.run_until(options.limit.value());

    std::vector<tank::PlotMark> marks;
    for (const tank::ScheduledOrder& order : options.virtual_tank.orders)
        marks.push_back({order.time, tank::printable(order.order)});
    plot.write(tank::svg_plot(samples, marks));
    csv.finish();
    log.finish();
    plot.finish();
    fmt::print("{} end: {}\n", in_seconds(tank.now()), tank::status_text(tank.controller()));
}

// Once a second what the operator sees, and what the nodes say when they say it.
void run_in_lines(tank::LiveTank& tank, canorb::Duration limit) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    auto next_status = start;
    while (!common::StopSignals::requested()) {
        const canorb::Duration time = Clock::now() - start;
        while (const auto line = tank.next_line())
            fmt::print("{} {}: {}\n", in_seconds(time), line->source, line->text);
        if (Clock::now() >= next_status) {
            next_status += std::chrono::seconds{1};
            fmt::print("{} {}\n", in_seconds(time), tank::status_text(tank.view().controller));
        }
        std::fflush(stdout);
        if (time >= limit) return;
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
}

void run_live(const Options& options) {
    const auto bus = canorb::open_bus(options.bus);
    const common::StopSignals stop_signals;
    tank::LiveTank tank{*bus};
    const bool terminal = ::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0;
    if (terminal && tank::run_screen(tank, options.limit)) return;
    run_in_lines(tank, options.limit.value_or(std::chrono::seconds{20}));
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "A tank, its controller and its operator on one CAN bus: live on this terminal, or as "
        "status\n"
        "lines for 20 s where there is none. With --virtual on a virtual clock, at full speed, "
        "the\n"
        "same every time.",
        "tank"};
    common::set_up(app);
    Options options;
    canorb::Duration seconds{};
    auto* const bus = app.add_option("--bus", options.bus,
                                     "The bus to run on, live: sim:PATH, socketcan:IFNAME, ...")
                          ->capture_default_str();
    auto* const limited = common::add_parsed_option(app, "--seconds", seconds, tank::parse_seconds,
                                                    "Stop after so long");
    auto* const on_virtual_clock =
        app.add_flag("--virtual", options.on_virtual_clock, "Run on a virtual clock")
            ->needs(limited)
            ->excludes(bus);
    tank::VirtualTank::Options& world = options.virtual_tank;
    for (CLI::Option* option :
         {common::add_parsed_option(app, "--orders", world.orders, tank::parse_orders,
                                    "What the operator types, as TIME:ORDER,...: 10:c,20.5:h"),
          common::add_parsed_option(
              app, "--temperature", world.temperatures, tank::parse_temperatures,
              "How the temperature is turned, as TIME:CELSIUS,...: 30:300,40:20"),
          app.add_option("--bitrate", world.bitrate, "Of the bus, in bit/s")
              ->capture_default_str()
              ->check(CLI::Range(25'000, 1'000'000)),
          app.add_option("--csv", options.csv, "Write a line for every round to this file"),
          app.add_option("--log", options.log,
                         "Write every frame to this file, as candump -l does"),
          app.add_option("--plot", options.plot, "Write a picture to this file, SVG")}) {
        option->needs(on_virtual_clock)->group("With --virtual");
    }
    if (const auto code = common::parse_command_line(app, argc, argv)) return *code;
    if (limited->count() > 0) options.limit = seconds;

    return common::run_program("tank", [&] {
        if (options.on_virtual_clock) {
            run_virtually(options);
        } else {
            run_live(options);
        }
    });
}
