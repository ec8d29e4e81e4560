// The smallest server of Bench::Device with omniORB, whose size and memory count:
//
//     peer_omniorb_server ENDPOINT

#include <cstdio>

#include "ending_signals.hpp"
#include "omniorb_device.hpp"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: peer_omniorb_server ENDPOINT\n");
        return 2;
    }
    peers::block_ending_signals();
    try {
        peers::serve_until_signal({{"endPoint", argv[1]}});
        return 0;
    } catch (const CORBA::Exception& error) {
        std::fprintf(stderr, "peer_omniorb_server: %s\n", error._name());
        return 1;
    }
}
