#pragma once

#include <atomic>
#include <canorb/orb.hpp>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "node_a.hpp"
#include "node_b.hpp"
#include "operator_line.hpp"

namespace tank {

/// Both nodes and the operator's line in this program, in real time: each node in a thread of its
/// own, they meet on the bus only. Its functions are for another thread.
class LiveTank {
  public:
    /// What there is to see at one moment.
    struct View {
        ControllerStatus controller;
        PlantStatus plant;
        int temperature_c;
    };

    /// A node's or the station's line.
    struct Line {
        std::string source;
        std::string text;
    };

    /// `bus` must outlive this object.
    explicit LiveTank(canorb::Bus& bus);
    ~LiveTank();
    LiveTank(const LiveTank&) = delete;
    LiveTank& operator=(const LiveTank&) = delete;

    /// The operator types.
    void type(char order) { line_.type(order); }
    /// Turns the temperature by so many steps of 10 degrees.
    void turn(int steps);

    /// Throws what a node's thread threw.
    View view();
    /// What the nodes said, oldest first, each line once.
    std::optional<Line> next_line();

  private:
    void run(canorb::Orb& orb);
    void say(std::string_view source, std::string_view text);
    NodeA::Outputs outputs_of_a();
    NodeB::Outputs outputs_of_b();

    std::mutex mutex_;
    ControllerStatus controller_;
    PlantStatus plant_;
    std::deque<Line> lines_;
    std::exception_ptr failure_;
    std::atomic<int> temperature_c_{20};

    LocalOperatorLine line_;
    canorb::Orb orb_a_;
    canorb::Orb orb_b_;
    NodeA a_;
    NodeB b_;
    StepsDue steps_;
    std::thread thread_a_;
    std::thread thread_b_;
};

}  // namespace tank
