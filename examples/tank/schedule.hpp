#pragma once

/// Schedules as they stand on a command line: "TIME:VALUE,TIME:VALUE", times in seconds.

#include <canorb/types.hpp>
#include <string_view>
#include <vector>

namespace tank {

struct ScheduledOrder {
    canorb::Duration time;
    char order;
    friend bool operator==(const ScheduledOrder&, const ScheduledOrder&) = default;
};

struct ScheduledTemperature {
    canorb::Duration time;
    int celsius;
    friend bool operator==(const ScheduledTemperature&, const ScheduledTemperature&) = default;
};

/// The range of the temperature sensor, degrees Celsius, and its resolution.
inline constexpr int highest_temperature = 500;
inline constexpr int temperature_step = 10;

/// "20.5" as 20.5 s, exactly; at most nine decimals, at most 1'000'000 s. Throws
/// std::invalid_argument whose what() quotes the text; so do the others.
canorb::Duration parse_seconds(std::string_view text);

/// "10:c,20.5:h": any character may stand for an order, because an operator may type any.
std::vector<ScheduledOrder> parse_orders(std::string_view text);

/// "30:300,40:20": -500 to 500 in steps of 10.
std::vector<ScheduledTemperature> parse_temperatures(std::string_view text);

}  // namespace tank
