#include "live_tank.hpp"

#include <algorithm>

#include "common/program.hpp"
#include "groups.hpp"
#include "schedule.hpp"

namespace tank {

LiveTank::LiveTank(canorb::Bus& bus)
    : orb_a_(bus, {.node = default_node_a,
                   .name = "tank-a",
                   .log = [this](std::string_view text) { say("A", text); }}),
      orb_b_(bus, {.node = default_node_b,
                   .name = "tank-b",
                   .log = [this](std::string_view text) { say("B", text); }}),
      a_(orb_a_, line_, outputs_of_a()),
      b_(orb_b_, outputs_of_b()) {
    orb_a_.every(Plant::step_length, [this] { a_.set_temperature(temperature_c_); });
    orb_b_.every(Plant::step_length,
                 [this, start = orb_b_.now()] { b_.pass_time(steps_.take(orb_b_.now() - start)); });
    common::keep_on_bus(orb_a_);
    common::keep_on_bus(orb_b_);
    thread_b_ = std::thread{[this] { run(orb_b_); }};
    thread_a_ = std::thread{[this] { run(orb_a_); }};
}

LiveTank::~LiveTank() {
    orb_a_.shutdown();
    orb_b_.shutdown();
    thread_a_.join();
    thread_b_.join();
}

void LiveTank::turn(int steps) {
    temperature_c_ = std::clamp(temperature_c_ + steps * temperature_step, -highest_temperature,
                                highest_temperature);
}

LiveTank::View LiveTank::view() {
    const std::lock_guard lock{mutex_};
    if (failure_) std::rethrow_exception(failure_);
    return {controller_, plant_, temperature_c_};
}

std::optional<LiveTank::Line> LiveTank::next_line() {
    const std::lock_guard lock{mutex_};
    if (lines_.empty()) return std::nullopt;
    Line line = std::move(lines_.front());
    lines_.pop_front();
    return line;
}

void LiveTank::run(canorb::Orb& orb) {
    try {
        orb.run();
    } catch (...) {
        const std::lock_guard lock{mutex_};
        failure_ = std::current_exception();
    }
}

void LiveTank::say(std::string_view source, std::string_view text) {
    constexpr std::size_t most_lines = 100;
    const std::lock_guard lock{mutex_};
    if (lines_.size() == most_lines) lines_.pop_front();
    lines_.push_back({std::string{source}, std::string{text}});
}

NodeA::Outputs LiveTank::outputs_of_a() {
    return {.display =
                [this](const ControllerStatus& status) {
                    const std::lock_guard lock{mutex_};
                    controller_ = status;
                },
            .log = [this](std::string_view text) { say("A", text); }};
}

NodeB::Outputs LiveTank::outputs_of_b() {
    return {.display =
                [this](const PlantStatus& status) {
                    const std::lock_guard lock{mutex_};
                    plant_ = status;
                },
            .log = [this](std::string_view text) { say("B", text); }};
}

}  // namespace tank
