#include "orb/can/sim/fault_script_numbers.hpp"

#include "orb/can/sim/fault_script.hpp"

namespace canorb::can::sim {
namespace {

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

std::string_view take_digits(std::string_view& text) {
    std::size_t count = 0;
    while (count < text.size() && is_digit(text[count])) ++count;
    const std::string_view digits = text.substr(0, count);
    text.remove_prefix(count);
    return digits;
}

}  // namespace

std::optional<std::uint64_t> parse_number(std::string_view text, int base, std::uint64_t highest) {
    if (text.empty()) return std::nullopt;
    const auto factor = static_cast<std::uint64_t>(base);
    std::uint64_t value = 0;
    for (const char c : text) {
        std::uint64_t digit = factor;
        if (is_digit(c)) digit = static_cast<std::uint64_t>(c - '0');
        if (c >= 'a' && c <= 'f') digit = static_cast<std::uint64_t>(c - 'a' + 10);
        if (c >= 'A' && c <= 'F') digit = static_cast<std::uint64_t>(c - 'A' + 10);
        const bool fits = digit < factor && digit <= highest && value <= (highest - digit) / factor;
        if (!fits) return std::nullopt;
        value = value * factor + digit;
    }
    return value;
}

std::optional<std::uint64_t> parse_nanoseconds(std::string_view text, std::uint64_t unit) {
    const std::string_view whole = take_digits(text);
    const auto value = parse_number(whole, 10, FaultTime::highest_nanoseconds / unit);
    if (!value) return std::nullopt;
    std::uint64_t nanoseconds = *value * unit;
    if (text.empty()) return nanoseconds;
    if (text[0] != '.' || text.size() < 2) return std::nullopt;
    for (const char digit : text.substr(1)) {
        if (unit % 10 != 0 || !is_digit(digit)) return std::nullopt;
        unit /= 10;
        nanoseconds += unit * static_cast<std::uint64_t>(digit - '0');
    }
    if (nanoseconds > FaultTime::highest_nanoseconds) return std::nullopt;
    return nanoseconds;
}

std::optional<std::uint64_t> parse_probability(std::string_view text) {
    constexpr std::uint64_t most_digits = 18;  // a number of them is below 2 to the 60
    const std::string_view whole = take_digits(text);
    std::string_view fraction;
    if (!text.empty() && text[0] == '.') {
        text.remove_prefix(1);
        fraction = take_digits(text);
        if (fraction.empty()) return std::nullopt;
    }
    std::uint64_t exponent = 0;
    if (!text.empty() && (text[0] == 'e' || text[0] == 'E')) {
        if (text.size() < 2 || text[1] != '-') return std::nullopt;
        const auto number = parse_number(text.substr(2), 10, most_digits);
        if (!number) return std::nullopt;
        exponent = *number;
        text = {};
    }
    exponent += fraction.size();
    if (whole.empty() || !text.empty() || exponent > most_digits) return std::nullopt;
    std::uint64_t divisor = 1;
    for (std::uint64_t i = 0; i < exponent; ++i) divisor *= 10;
    std::uint64_t remainder = 0;
    for (const std::string_view digits : {whole, fraction}) {
        for (const char digit : digits) {
            remainder = remainder * 10 + static_cast<std::uint64_t>(digit - '0');
            if (remainder > divisor) return std::nullopt;
        }
    }
    if (remainder == divisor) return UINT64_MAX;
    std::uint64_t scaled = 0;
    for (int bit = 0; bit < 64; ++bit) {
        remainder *= 2;
        scaled *= 2;
        if (remainder >= divisor) {
            remainder -= divisor;
            ++scaled;
        }
    }
    if (scaled == 0) return std::nullopt;
    return scaled;
}

}  // namespace canorb::can::sim
