// Any octets from a serial line. There is one way to write each frame: a line that is understood as
// a frame is that, apart from the case of its digits and a time stamp.

#include <cctype>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <variant>

#include "orb/can/link/slcan_protocol.hpp"

using namespace canorb::can;

namespace {

/// All but the first letter, whose case is what it means.
std::string in_upper_case(std::string line) {
    for (std::size_t i = 1; i < line.size(); ++i) {
        line[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(line[i])));
    }
    return line;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    slcan::Receiver receiver;
    std::string line;
    for (std::size_t i = 0; i < size; ++i) {
        const char octet = static_cast<char>(data[i]);
        const auto message = receiver.add(octet);
        if (message.has_value() != (octet == '\r' || octet == '\a')) std::abort();
        if (!message) {
            line += octet;
            continue;
        }
        if (const auto* frame = std::get_if<Frame>(&*message)) {
            std::string written{slcan::transmit_command(*frame).text()};
            written.pop_back();  // the CR
            const std::string read = in_upper_case(line);
            const bool has_time = read.size() == written.size() + 4;
            if (!read.starts_with(written) || (!has_time && read != written)) std::abort();
        }
        line.clear();
    }
    return 0;
}
