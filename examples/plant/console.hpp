#pragma once

#include <canorb/orb.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "commands.hpp"
#include "common/program.hpp"
#include "line_reader.hpp"
#include "panel.hpp"
#include "screen.hpp"

namespace plant {

/// A node's face to people: its panel, its log and the ORB's events, on the whole terminal where
/// there is one, else as lines on standard output; and their commands, from the keys, else from
/// standard input.
class Console {
  public:
    /// What it shows, and what it gives commands to, which may throw what is wrong with one.
    struct Node {
        std::function<Panel()> panel;
        std::function<void(const Command&)> carry_out;
    };

    /// `orb` must outlive this object.
    Console(canorb::Orb& orb, std::string name, const std::string& bus);
    ~Console();
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;

    void log(std::string_view text);

    /// Serves the node until a signal, "quit" or the key q.
    void run(Node node);

  private:
    void step(const Node& node);
    void carry_out(const Node& node, std::string_view line);
    void print_panel(const Panel& panel);

    canorb::Orb& orb_;
    std::string name_;
    canorb::TimePoint start_;
    std::unique_ptr<Screen> screen_;  ///< null: lines
    LineReader input_;
    Panel printed_;
    canorb::TimePoint next_print_;
};

/// Runs a node program: `work` gets its ORB, with the number and the bus of the options.
int run_node(std::string_view program, const common::NodeOptions& options, std::string_view role,
             const std::function<void(canorb::Orb&, Console&)>& work);

/// Standard input and standard output are a terminal, and it is ours.
bool has_terminal();

}  // namespace plant
