#include "orb/ccdr/fixed.hpp"

namespace canorb::fixed_digits {
namespace {

constexpr std::uint8_t plus_nibble = 0xC;
constexpr std::uint8_t minus_nibble = 0xD;

}  // namespace

std::string to_string(std::span<const std::uint8_t> digits, std::size_t scale, bool is_negative) {
    std::string text = is_negative ? "-" : "";
    const std::size_t point = digits.size() - scale;
    std::size_t first = 0;
    while (first < point && digits[first] == 0) ++first;
    if (first == point) text += '0';
    for (std::size_t i = first; i < digits.size(); ++i) {
        if (i == point) text += '.';
        text += static_cast<char>('0' + digits[i]);
    }
    return text;
}

void encode(ccdr::Encoder& out, std::span<const std::uint8_t> digits, bool is_negative) {
    // An even number of digits, and the sign, leave one nibble: it comes first and is 0.
    std::uint8_t high = 0;
    bool have_high = digits.size() % 2 == 0;
    for (const std::uint8_t digit : digits) {
        if (have_high) out.octet(static_cast<std::uint8_t>(high << 4 | digit));
        high = digit;
        have_high = !have_high;
    }
    const std::uint8_t sign = is_negative ? minus_nibble : plus_nibble;
    out.octet(static_cast<std::uint8_t>(high << 4 | sign));
}

bool decode(ccdr::Decoder& in, std::span<std::uint8_t> digits) {
    const Bytes octets = in.octets(digits.size() / 2 + 1);
    if (octets.empty()) return false;
    const auto nibble = [octets](std::size_t i) {
        return static_cast<std::uint8_t>(i % 2 == 0 ? octets[i / 2] >> 4 : octets[i / 2] & 0xF);
    };
    const std::size_t spare = digits.size() % 2 == 0 ? 1 : 0;
    bool valid = spare == 0 || nibble(0) == 0;
    bool is_zero = true;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        digits[i] = nibble(spare + i);
        valid = valid && digits[i] <= 9;
        is_zero = is_zero && digits[i] == 0;
    }
    const std::uint8_t sign = nibble(spare + digits.size());
    valid = valid && (sign == plus_nibble || (sign == minus_nibble && !is_zero));
    if (!valid) {
        in.fail();
        std::fill(digits.begin(), digits.end(), std::uint8_t{0});
    }
    return valid && sign == minus_nibble;
}

}  // namespace canorb::fixed_digits
