// One node on a bus, for tests that need it to be a process of its own.
//
//     socketcan_node BUS NODE serve [GROUP]
//         Object 1, a member of the group: operation 7 takes nothing and returns nothing,
//         operation 8 returns its parameters. Prints "ready", then "called" for each call.
//         SIGTERM ends it.
//     socketcan_node BUS NODE call TARGET OPERATION [PARAMETERS]
//         Calls a corbaloc: reference. Parameters and the printed result are octets in hex.

#include <signal.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "canorb/orb.hpp"
#include "tests/support/octets.hpp"

namespace {

constexpr canorb::InterfaceInfo bell_interface{"IDL:Test/Bell:1.0"};

class Bell final : public canorb::Servant {
  public:
    const canorb::InterfaceInfo& _interface_info() const override { return bell_interface; }
    void _dispatch(canorb::ServerCall& call) override {
        if (call.operation() == 7) {
            if (!call.read()) return;
            call.reply();
        } else if (call.operation() == 8) {
            const std::vector<std::uint8_t> parameters{call.remaining_parameters().begin(),
                                                       call.remaining_parameters().end()};
            call.reply(canorb::RawOctets{parameters});
        } else {
            return;
        }
        std::cout << "called" << std::endl;
    }
};

canorb::Orb* running = nullptr;

void serve(canorb::Orb& orb, std::uint8_t group) {
    Bell bell;
    const canorb::ObjectRef self = orb.root_poa().activate_object_with_id(1, bell);
    if (group != 0) orb.object_join(self, canorb::GroupId{group});
    running = &orb;
    ::signal(SIGTERM, [](int) { running->shutdown(); });
    std::cout << "ready" << std::endl;
    orb.run();
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> arguments{argv + 1, argv + argc};
    try {
        if (arguments.size() < 3) throw std::invalid_argument("see the source for its arguments");
        const auto bus = canorb::open_bus(arguments[0]);
        canorb::OrbOptions options;
        options.node = canorb::parse_node_id(arguments[1]);
        options.default_timeout = std::chrono::seconds{10};
        options.inter_frame_timeout = options.default_timeout;  // however loaded the machine is
        canorb::Orb orb{*bus, options};
        if (arguments[2] == "serve") {
            serve(orb,
                  static_cast<std::uint8_t>(arguments.size() > 3 ? std::stoi(arguments[3]) : 0));
        } else {
            const auto operation = static_cast<canorb::OperationId>(std::stoi(arguments.at(4)));
            const auto parameters =
                canorb::test::octets(arguments.size() > 5 ? arguments[5] : std::string{});
            const canorb::ObjectRef target = orb.string_to_object(arguments.at(3));
            std::cout << canorb::test::hex(target.invoke(operation, parameters)) << std::endl;
        }
        return 0;
    } catch (const std::exception& exception) {
        std::cerr << exception.what() << std::endl;
        return 1;
    }
}
