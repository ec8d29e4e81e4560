// Any text as a line of a candump log: what is read is written as a line that reads the same, and
// that is then written without a change.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "orb/can/candump.hpp"

namespace {

using namespace canorb;

void require(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text{data, data + size};
    const auto line = can::parse_candump(text);
    if (!line) {
        require(!can::name(line.error()).empty());
        return 0;
    }
    const std::string written = can::format_candump(line->time, line->interface, line->frame);
    const auto again = can::parse_candump(written);
    require(again.ok());
    require(again->time == line->time);
    require(again->interface == line->interface);
    require(again->frame == line->frame);
    require(can::format_candump(again->time, again->interface, again->frame) == written);
    return 0;
}
