#pragma once

/// What the tank's programs have in common.

#include <canorb/orb.hpp>
#include <string>
#include <string_view>

#include "common/program.hpp"
#include "display.hpp"

namespace tank {

/// Prints where a node is, its log, and its panel when it changed, four times a second at most.
class NodePrinter {
  public:
    NodePrinter(canorb::Orb& orb, std::string_view node, const common::NodeOptions& options);

    void log(std::string_view text);
    void show(const Panel& panel) { panel_ = panel; }

  private:
    void print_panel();

    canorb::Orb& orb_;
    std::string node_;
    canorb::TimePoint start_;
    Panel panel_;
    Panel printed_;
};

}  // namespace tank
