// One process, two nodes: a pump and its user, on a bus inside the process.
#include <canorb/node.hpp>
#include <canorb/orb.hpp>

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <thread>

#include "pump.hpp"

namespace {

class PumpImpl final : public Plant::PumpServant {
  public:
    Plant::Origin made_by() override { return {"Acme", canorb::Node::ControllerState::STOPPED}; }
    float start(std::uint16_t speed) override {
        if (speed > 3000) throw Plant::Dry{"inlet"};
        return static_cast<float>(speed) / 2;
    }
    std::string label() override { return label_; }
    void label(const std::string& value) override { label_ = value; }

  private:
    std::string label_ = "unnamed";
};

bool holds(bool condition, const char* what) {
    std::printf("%s: %s\n", what, condition ? "yes" : "NO");
    return condition;
}

int index_of(const canorb::Node::ActiveObjects& objects, std::string_view type_id) {
    for (const auto& object : objects) {
        if (object.type_id == type_id) return object.index;
    }
    return -1;
}

std::string where_dry(const Plant::Pump& pump) {
    try {
        pump.start(3001);
    } catch (const Plant::Dry& dry) {
        return dry.where;
    }
    return "nowhere";
}

}  // namespace

int main() {
    const auto bus = canorb::open_bus("local:plant");

    canorb::Orb server{*bus, {.node = 3, .name = "pump-3"}};
    PumpImpl servant;
    server.root_poa().activate_object_with_id(1, servant);
    std::thread serving([&server] { server.run(); });

    canorb::Orb client{*bus, {.node = 1}};
    const auto pump = client.string_to_object("corbaloc:caniop:3/1").narrow<Plant::Pump>();
    bool good = holds(!pump.is_nil(), "the reference is one to a pump");
    good &= holds(pump.start(1500) == 750.0F, "the call returned the servant's result");
    good &= holds(where_dry(pump) == "inlet", "the exception arrived with its member");
    pump.label("north");
    good &= holds(pump.label() == "north", "the attribute kept its value");

    good &= holds(pump.made_by().maker == "Acme", "its own type has one of the node's in it");
    const auto node = client.string_to_object("corbaloc:caniop:3/0").narrow<canorb::Node>();
    good &= holds(node.identity().name == "pump-3", "the node told its name");
    const auto objects = node.active_objects(1, canorb::Node::OBJECTS_PER_PAGE);
    good &= holds(index_of(objects, "IDL:Plant/Pump:1.0") == 1, "the node listed its pump");

    server.shutdown();
    serving.join();
    return good ? 0 : 1;
}
