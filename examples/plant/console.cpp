#include "console.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace plant {

namespace {

constexpr std::chrono::milliseconds step_length{50};
constexpr std::chrono::milliseconds between_prints{250};

}  // namespace

bool has_terminal() {
    return ::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0 &&
           ::tcgetpgrp(STDIN_FILENO) == ::getpgrp();
}

Console::Console(canorb::Orb& orb, std::string name, const std::string& bus)
    : orb_(orb),
      name_(std::move(name)),
      start_(orb.now()),
      screen_(has_terminal() ? Screen::open("canorb: a node of the plant on " + bus, {name_})
                             : nullptr),
      input_(STDIN_FILENO),
      next_print_(start_) {
    orb_.on_event([this](const canorb::Event& event) { log(event.text); });
    log(fmt::format("node {} on {}", orb.node()->value(), bus));
}

Console::~Console() {
    orb_.on_event({});
}

void Console::log(std::string_view text) {
    const std::string line =
        output_line(std::chrono::duration<double>(orb_.now() - start_).count(), name_, text);
    if (screen_) {
        screen_->tell(line);
    } else {
        fmt::print("{}\n", line);
        std::fflush(stdout);
    }
}

void Console::run(Node node) {
    orb_.every(step_length, [this, node = std::move(node)] { step(node); });
    common::keep_on_bus(orb_);
    const common::StopSignals stop_signals{&orb_};
    orb_.run();
}

void Console::step(const Node& node) {
    if (!screen_) {
        input_.read([&](std::string_view line) { carry_out(node, line); });
        print_panel(node.panel());
        return;
    }
    while (const auto typed = screen_->next_command()) carry_out(node, typed->command);
    if (screen_->quit()) orb_.shutdown();
    screen_->show(0, node.panel());
    screen_->draw();
}

void Console::carry_out(const Node& node, std::string_view line) {
    try {
        const Command command = parse_command(line);
        if (std::holds_alternative<Quit>(command)) {
            orb_.shutdown();
        } else {
            node.carry_out(command);
        }
    } catch (const std::exception& error) {
        log(error.what());
    }
}

void Console::print_panel(const Panel& panel) {
    if (panel == printed_ || orb_.now() < next_print_) return;
    printed_ = panel;
    next_print_ = orb_.now() + between_prints;
    log(to_text(panel));
}

int run_node(std::string_view program, const common::NodeOptions& options, std::string_view role,
             const std::function<void(canorb::Orb&, Console&)>& work) {
    return common::run_program(program, [&] {
        const auto bus = canorb::open_bus(options.bus);
        const std::string name =
            role == "controller" ? std::string{role} : fmt::format("{}-{}", role, options.node);
        canorb::Orb orb{*bus, {.node = options.node, .name = name, .log = [](std::string_view) {}}};
        Console console{orb, name, options.bus};
        work(orb, console);
    });
}

}  // namespace plant
