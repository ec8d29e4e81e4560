// A server of one object and nothing else, whose size and memory calls.cpp measures.
//
//     minimal_server BUS NODE

#include <canorb/orb.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "bench/device.hpp"

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: minimal_server BUS NODE\n");
        return 2;
    }
    try {
        const auto bus = canorb::open_bus(argv[1]);
        canorb::Orb orb{*bus, {.node = std::atoi(argv[2])}};
        canorb::bench::DeviceImpl servant;
        orb.root_poa().activate_object_with_id(1, servant);
        orb.run();
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "minimal_server: %s\n", exception.what());
        return 1;
    }
}
