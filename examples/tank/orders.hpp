#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <variant>

namespace tank {

/// a, b, c, d: keep the level there.
struct SetpointOrder {
    int cm;
    friend bool operator==(const SetpointOrder&, const SetpointOrder&) = default;
};

/// h, j, k, l: slots of this length from the next round on.
struct SlotOrder {
    std::chrono::milliseconds length;
    friend bool operator==(const SlotOrder&, const SlotOrder&) = default;
};

using Order = std::variant<SetpointOrder, SlotOrder>;

inline constexpr int default_setpoint_cm = 50;

/// What the operator's character orders; nothing for a character that is no order.
std::optional<Order> parse_order(char character);

/// Ends of line come with terminals, and are neither orders nor mistakes.
constexpr bool is_line_end(char character) {
    return character == '\r' || character == '\n';
}

/// The character for people: 'x', or 0x1B where it cannot be shown.
std::string printable(char character);

}  // namespace tank
