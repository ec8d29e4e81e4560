#include "orders.hpp"

#include <fmt/format.h>

namespace tank {

std::optional<Order> parse_order(char character) {
    using std::chrono::milliseconds;
    switch (character) {
        case 'a':
            return SetpointOrder{50};
        case 'b':
            return SetpointOrder{75};
        case 'c':
            return SetpointOrder{100};
        case 'd':
            return SetpointOrder{125};
        case 'h':
            return SlotOrder{milliseconds{5}};
        case 'j':
            return SlotOrder{milliseconds{10}};
        case 'k':
            return SlotOrder{milliseconds{50}};
        case 'l':
            return SlotOrder{milliseconds{100}};
        default:
            return std::nullopt;
    }
}

std::string printable(char character) {
    if (character >= ' ' && character <= '~') return fmt::format("'{}'", character);
    return fmt::format("0x{:02X}", static_cast<unsigned char>(character));
}

}  // namespace tank
