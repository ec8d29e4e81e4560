#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <canorb/orb.hpp>
#include <canorb/simulation.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "actuator.hpp"
#include "commands.hpp"
#include "controller.hpp"
#include "sensor.hpp"

namespace plant::test {

using namespace std::chrono_literals;

inline constexpr canorb::GroupId actuators{1};
inline constexpr canorb::GroupId sensors{2};

/// Nodes of the plant on one bus and on virtual time. References go from node to node as the
/// strings that the nodes tell.
class PlantTest : public testing::Test {
  protected:
    /// A node: its ORB, what is on it, and what it told.
    template <typename Device>
    struct Node {
        std::string log;
        canorb::Orb orb;
        Device device;

        template <typename... Arguments>
        Node(canorb::Bus& bus, int number, const Arguments&... arguments)
            : orb(bus, {.node = number, .log = [this](std::string_view line) { told(line); }}),
              device(orb, arguments..., [this](std::string_view line) { told(line); }) {}

        void told(std::string_view line) { log.append(line).append("\n"); }
        void type(std::string_view command) { device.carry_out(parse_command(command)); }
        std::string panel() const { return to_text(device.panel()); }
    };
    using ControllerNode = Node<Controller>;
    using SensorNode = Node<Sensor>;
    using ActuatorNode = Node<Actuator>;

    PlantTest() : bus(simulation.add_bus()) {
        bus.on_frame([this](const canorb::can::Frame& frame, canorb::TimePoint) {
            frames.push_back(frame);
        });
    }

    std::unique_ptr<SensorNode> sensor(int number, canorb::GroupId group = sensors) {
        auto node = std::make_unique<SensorNode>(bus, number, group);
        sensor_group = reference_in(node->log);
        return node;
    }
    std::unique_ptr<ActuatorNode> actuator(int number, canorb::GroupId group = actuators) {
        auto node = std::make_unique<ActuatorNode>(bus, number, group);
        actuator_group = reference_in(node->log);
        return node;
    }
    /// Of the groups that were joined last.
    std::unique_ptr<ControllerNode> controller(int number = 1) {
        return std::make_unique<ControllerNode>(
            bus, number, Controller::Groups{.sensors = sensor_group, .actuators = actuator_group});
    }

    static std::string reference_in(const std::string& log) {
        const std::size_t begin = log.rfind("CAN_IOR:");
        return log.substr(begin, log.find('\n', begin) - begin);
    }
    void rounds(int count) { simulation.run_for(count * Controller::round_length); }

    canorb::Simulation simulation;
    canorb::SimulatedBus& bus;
    std::vector<canorb::can::Frame> frames;
    std::string sensor_group;
    std::string actuator_group;
};

/// The plant as run_plant starts it.
class WholePlant : public PlantTest {
  protected:
    WholePlant() {
        for (const int number : {11, 12}) s.push_back(sensor(number));
        for (const int number : {21, 22, 23}) a.push_back(actuator(number));
        c = controller();
        // In the first round the sensors hear of their controller and answer; its end comes with
        // the second; then a little more, so that everybody is where he is going.
        rounds(2);
        simulation.run_for(100ms);
    }

    /// Which actuators are on, in their order.
    std::vector<bool> on() const {
        std::vector<bool> states;
        for (const auto& node : a) states.push_back(node->device.is_on());
        return states;
    }

    const std::vector<bool> all_on{true, true, true};
    const std::vector<bool> all_off{false, false, false};
    std::vector<std::unique_ptr<SensorNode>> s;
    std::vector<std::unique_ptr<ActuatorNode>> a;
    std::unique_ptr<ControllerNode> c;
};

}  // namespace plant::test
