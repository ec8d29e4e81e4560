#include "program.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace tank {

namespace {

void print_line(std::string_view text) {
    fmt::print("{}\n", text);
    std::fflush(stdout);
}

}  // namespace

NodePrinter::NodePrinter(canorb::Orb& orb, std::string_view node,
                         const common::NodeOptions& options)
    : orb_(orb), node_(node), start_(orb.now()) {
    const std::uint32_t bitrate = orb.link_capabilities().bitrate;
    log(fmt::format("node {} on {}{}", options.node, options.bus,
                    bitrate == 0 ? "" : fmt::format(", {} bit/s", bitrate)));
    orb.every(std::chrono::milliseconds{250}, [this] { print_panel(); });
}

void NodePrinter::log(std::string_view text) {
    const auto ms =
        std::chrono::duration_cast<std::chrono::milliseconds>(orb_.now() - start_).count();
    print_line(fmt::format("{}.{:03} {}: {}", ms / 1000, ms % 1000, node_, text));
}

void NodePrinter::print_panel() {
    if (panel_ == printed_) return;
    printed_ = panel_;
    log(fmt::format("|{}|{}|", panel_.lines[0], panel_.lines[1]));
}

}  // namespace tank
