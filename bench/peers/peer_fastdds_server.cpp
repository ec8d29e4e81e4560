// The smallest server of a call without parameters with Fast DDS, whose size and memory count: a
// subscriber that answers each sample with another.
//
//     peer_fastdds_server TRANSPORT RELIABILITY DOMAIN NAME

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "ending_signals.hpp"
#include "fastdds_answerer.hpp"

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: peer_fastdds_server TRANSPORT RELIABILITY DOMAIN NAME\n");
        return 2;
    }
    peers::block_ending_signals();
    try {
        const auto domain = static_cast<std::uint32_t>(std::strtoul(argv[3], nullptr, 10));
        peers::answer_until_signal({argv[1], argv[2], domain, argv[4]},
                                   {{"ping", peers::nothing(), peers::nothing()}});
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "peer_fastdds_server: %s\n", error.what());
        return 1;
    }
}
