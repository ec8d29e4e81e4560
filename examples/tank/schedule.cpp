#include "schedule.hpp"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace tank {

namespace {

constexpr std::int64_t nanoseconds_in_second = 1'000'000'000;
constexpr std::int64_t most_seconds = 1'000'000;
constexpr std::size_t most_decimals = 9;

template <typename Number>
std::optional<Number> whole_number(std::string_view text) {
    Number number{};
    const char* const end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, number);
    if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
    return number;
}

[[noreturn]] void refuse(std::string_view text, std::string_view reason) {
    throw std::invalid_argument(fmt::format("'{}': {}", text, reason));
}

// Calls take(item, time, value) for each "TIME:VALUE".
template <typename Take>
void for_each_item(std::string_view text, Take take) {
    while (true) {
        const std::size_t comma = text.find(',');
        const std::string_view item = text.substr(0, comma);
        const std::size_t colon = item.find(':');
        if (colon == std::string_view::npos) refuse(item, "not TIME:VALUE, as in 20.5:h");
        canorb::Duration time;
        try {
            time = parse_seconds(item.substr(0, colon));
        } catch (const std::invalid_argument& error) {
            refuse(item, fmt::format("in its time, {}", error.what()));
        }
        take(item, time, item.substr(colon + 1));
        if (comma == std::string_view::npos) return;
        text.remove_prefix(comma + 1);
    }
}

}  // namespace

canorb::Duration parse_seconds(std::string_view text) {
    const std::size_t point = text.find('.');
    const std::string_view whole = text.substr(0, point);
    std::string decimals;
    if (point != std::string_view::npos) {
        decimals = text.substr(point + 1);
        if (decimals.empty() || decimals.size() > most_decimals)
            refuse(text, "a number of seconds has one to nine digits after its point");
    }
    decimals.append(most_decimals - decimals.size(), '0');
    // Unsigned: no sign is a digit.
    const auto seconds = whole_number<std::uint64_t>(whole);
    const auto fraction = whole_number<std::uint64_t>(decimals);
    if (!seconds || !fraction) refuse(text, "not a number of seconds, as 20 or 20.5");
    if (*seconds >= static_cast<std::uint64_t>(most_seconds))
        refuse(text, fmt::format("more than {} seconds", most_seconds));
    return canorb::Duration{static_cast<std::int64_t>(*seconds) * nanoseconds_in_second +
                            static_cast<std::int64_t>(*fraction)};
}

std::vector<ScheduledOrder> parse_orders(std::string_view text) {
    std::vector<ScheduledOrder> orders;
    for_each_item(text, [&](std::string_view item, canorb::Duration time, std::string_view value) {
        if (value.size() != 1) refuse(item, "an order is one character");
        orders.push_back({time, value[0]});
    });
    return orders;
}

std::vector<ScheduledTemperature> parse_temperatures(std::string_view text) {
    std::vector<ScheduledTemperature> temperatures;
    for_each_item(text, [&](std::string_view item, canorb::Duration time, std::string_view value) {
        const auto celsius = whole_number<int>(value);
        if (!celsius) refuse(item, "the temperature is not a whole number");
        if (*celsius < -highest_temperature || *celsius > highest_temperature ||
            *celsius % temperature_step != 0) {
            refuse(item, fmt::format("the temperature is not -{0} to {0} in steps of {1}",
                                     highest_temperature, temperature_step));
        }
        temperatures.push_back({time, *celsius});
    });
    return temperatures;
}

}  // namespace tank
