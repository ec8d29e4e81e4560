#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"

namespace canorb {

/// What all Fixed have in common, whatever their digits: so there is one of each in a program.
namespace fixed_digits {

/// Puts decimal digits, each given with the power of ten that it counts, into the digits of a
/// Fixed, and rounds those that are too low, half away from zero.
class Placer {
  public:
    /// `digits`, the highest first and all 0, of which `scale` stand behind the point.
    constexpr Placer(std::span<std::uint8_t> digits, std::size_t scale)
        : digits_(digits), units_(static_cast<int>(digits.size()) - static_cast<int>(scale) - 1) {}

    constexpr void place(std::uint8_t digit, int power) {
        const int index = units_ - power;
        const int size = static_cast<int>(digits_.size());
        if (index < 0) {
            fits_ = fits_ && digit == 0;
        } else if (index < size) {
            digits_[static_cast<std::size_t>(index)] = digit;
        } else if (index == size) {
            round_up_ = digit >= 5;
        }
    }

    /// False: the number has more digits in front of the point than there are.
    constexpr bool finish() {
        std::size_t i = digits_.size();
        while (round_up_ && i-- > 0) {
            round_up_ = digits_[i] == 9;
            digits_[i] = round_up_ ? std::uint8_t{0} : static_cast<std::uint8_t>(digits_[i] + 1);
        }
        return fits_ && !round_up_;
    }

  private:
    std::span<std::uint8_t> digits_;
    int units_;  ///< index of the digit in front of the point
    bool fits_ = true;
    bool round_up_ = false;
};

/// Digits with at most one point; no sign, no blanks, no exponent.
constexpr bool from_text(std::string_view text, std::span<std::uint8_t> digits, std::size_t scale) {
    const std::size_t point = std::min(text.find('.'), text.size());
    if (text.empty() || text == ".") return false;
    Placer placer{digits, scale};
    int power = static_cast<int>(point) - 1;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (i == point) continue;
        if (text[i] < '0' || text[i] > '9') return false;
        placer.place(static_cast<std::uint8_t>(text[i] - '0'), power--);
    }
    return placer.finish();
}

constexpr bool from_integer(std::uint64_t value, std::span<std::uint8_t> digits,
                            std::size_t scale) {
    Placer placer{digits, scale};
    for (int power = 0; value != 0; ++power, value /= 10) {
        placer.place(static_cast<std::uint8_t>(value % 10), power);
    }
    return placer.finish();
}

/// The digits of `value`, exactly, and then rounded. False also for infinity and NaN.
constexpr bool from_double(double value, std::span<std::uint8_t> digits, std::size_t scale) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const int stored = static_cast<int>(bits >> 52) & 0x7FF;
    std::uint64_t significand = bits & ((std::uint64_t{1} << 52) - 1);
    if (stored != 0) significand |= std::uint64_t{1} << 52;
    // The value is significand * 2^exponent, below 2^(53 + exponent).
    const int exponent = std::max(stored, 1) - 1075;
    constexpr int whole_bits = 128;  // 31 digits are below 2^103
    if (exponent + 53 > whole_bits) return false;

    // A binary number of 128 bits in front of the point and 1088 behind it, lowest word first.
    constexpr std::size_t fraction_words = 34;
    std::array<std::uint32_t, fraction_words + whole_bits / 32> words{};
    for (int i = 0; i < 53; ++i) {
        const auto at = static_cast<std::size_t>(i + exponent) + fraction_words * 32;
        words[at / 32] |= static_cast<std::uint32_t>(significand >> i & 1) << (at % 32);
    }

    Placer placer{digits, scale};
    for (int power = 0; power <= 38; ++power) {
        std::uint64_t rest = 0;
        for (std::size_t i = words.size(); i-- > fraction_words;) {
            rest = rest << 32 | words[i];
            words[i] = static_cast<std::uint32_t>(rest / 10);
            rest %= 10;
        }
        placer.place(static_cast<std::uint8_t>(rest), power);
    }
    for (int power = -1; power >= -32; --power) {
        std::uint64_t carry = 0;
        for (std::size_t i = 0; i < fraction_words; ++i) {
            carry += std::uint64_t{words[i]} * 10;
            words[i] = static_cast<std::uint32_t>(carry);
            carry >>= 32;
        }
        placer.place(static_cast<std::uint8_t>(carry), power);
    }
    return placer.finish();
}

/// Rounded to nearest, ties to even. Without the sign.
constexpr double to_double(std::span<const std::uint8_t> digits, std::size_t scale) {
    // In front of the point: the whole number in 32-bit words. Behind it: digits to be doubled.
    std::array<std::uint32_t, 4> whole{};
    std::array<std::uint8_t, 31> fraction{};
    const std::size_t point = digits.size() - scale;
    for (const std::uint8_t digit : digits.first(point)) {
        std::uint64_t carry = digit;
        for (std::uint32_t& word : whole) {
            carry += std::uint64_t{word} * 10;
            word = static_cast<std::uint32_t>(carry);
            carry >>= 32;
        }
    }
    std::copy(digits.begin() + static_cast<std::ptrdiff_t>(point), digits.end(), fraction.begin());

    // The first 64 bits that count; of those behind, whether any is 1 is all that rounding needs.
    std::uint64_t bits = 0;
    double unit = 1;  // what the lowest of the bits counts
    bool lost = false;
    for (int i = 127; i >= 0; --i) {
        const bool bit = (whole[static_cast<std::size_t>(i / 32)] >> (i % 32) & 1) != 0;
        if (bits >> 63 == 0) {
            bits = bits << 1 | (bit ? 1U : 0U);
        } else {
            lost = lost || bit;
            unit *= 2;
        }
    }
    // 31 decimal places begin with at most 103 zero bits.
    for (int i = 0; i < 103 + 64 && bits >> 63 == 0; ++i) {
        std::uint8_t carry = 0;
        for (std::size_t at = fraction.size(); at-- > 0;) {
            const int doubled = 2 * fraction[at] + carry;
            fraction[at] = static_cast<std::uint8_t>(doubled % 10);
            carry = static_cast<std::uint8_t>(doubled / 10);
        }
        bits = bits << 1 | carry;
        unit /= 2;
    }
    for (const std::uint8_t digit : fraction) lost = lost || digit != 0;
    if (lost) bits |= 1;
    return static_cast<double>(bits) * unit;
}

std::string to_string(std::span<const std::uint8_t> digits, std::size_t scale, bool is_negative);
void encode(ccdr::Encoder& out, std::span<const std::uint8_t> digits, bool is_negative);
/// Says whether the number is negative.
bool decode(ccdr::Decoder& in, std::span<std::uint8_t> digits);

}  // namespace fixed_digits

/// IDL's `fixed<D,S>`: a decimal number of D digits, S of them behind the point, exact and without
/// a heap.
///
///     canorb::Fixed<5, 2> price{"123.45"};
///     price = 7;
///     price = 0.125;                                   // 0.13: rounded half away from zero
///     std::cout << price << ' ' << double(price);
///
/// A number that does not fit, and a text that is no number, leave a Fixed that is out of range
/// until it gets a new value. To send such a one is BAD_PARAM.
template <std::size_t D, std::size_t S>
class Fixed {
    static_assert(D >= 1 && D <= 31, "1 to 31 digits");
    static_assert(S <= D, "no more digits behind the point than there are");

  public:
    /// 0.
    constexpr Fixed() = default;

    /// "-12.5": a sign or none, digits, and at most one point. What is behind the last digit that
    /// there is room for is rounded.
    template <typename Text>
        requires std::convertible_to<const Text&, std::string_view>
    constexpr explicit Fixed(const Text& from) {
        std::string_view text = from;
        const bool is_negative = text.starts_with('-');
        if (is_negative || text.starts_with('+')) text.remove_prefix(1);
        finish(fixed_digits::from_text(text, digits_, S), is_negative);
    }

    template <std::integral Integer>
        requires(!std::same_as<Integer, bool>)
    constexpr Fixed(Integer value) {  // NOLINT: implicit, as between numbers
        const bool is_negative = value < 0;
        const auto bits = static_cast<std::uint64_t>(value);
        finish(fixed_digits::from_integer(is_negative ? 0 - bits : bits, digits_, S), is_negative);
    }

    /// Infinity and NaN are out of range.
    constexpr Fixed(double value) {  // NOLINT: implicit, as between numbers
        finish(fixed_digits::from_double(value, digits_, S), value < 0);
    }

    /// Whether the number it was given did not fit.
    constexpr bool is_out_of_range() const { return out_of_range_; }
    constexpr bool is_negative() const { return negative_; }

    /// "-12.50": as many digits behind the point as its scale.
    std::string to_string() const { return fixed_digits::to_string(digits_, S, negative_); }
    constexpr explicit operator double() const {
        const double magnitude = fixed_digits::to_double(digits_, S);
        return negative_ ? -magnitude : magnitude;
    }

    friend constexpr bool operator==(const Fixed&, const Fixed&) = default;
    /// By value; what is out of range is above all that is not.
    friend constexpr std::strong_ordering operator<=>(const Fixed& a, const Fixed& b) {
        if (a.out_of_range_ != b.out_of_range_) return a.out_of_range_ <=> b.out_of_range_;
        if (a.negative_ != b.negative_) return b.negative_ <=> a.negative_;
        return a.negative_ ? b.digits_ <=> a.digits_ : a.digits_ <=> b.digits_;
    }

    template <typename Stream>
    friend Stream& operator<<(Stream& out, const Fixed& value)
        requires requires { out << std::string_view{}; }
    {
        out << (value.out_of_range_ ? std::string{"out of range"} : value.to_string());
        return out;
    }

    friend void encode(ccdr::Encoder& out, const Fixed& value) {
        if (value.out_of_range_) return out.fail();
        fixed_digits::encode(out, value.digits_, value.negative_);
    }
    friend void decode(ccdr::Decoder& in, Fixed& value) {
        value = Fixed{};
        value.finish(true, fixed_digits::decode(in, value.digits_));
    }

  private:
    constexpr void finish(bool fits, bool is_negative) {
        if (!fits) digits_ = {};
        out_of_range_ = !fits;
        negative_ = is_negative && digits_ != std::array<std::uint8_t, D>{};
    }

    std::array<std::uint8_t, D> digits_{};  ///< the highest first
    bool negative_ = false;                 ///< never of 0
    bool out_of_range_ = false;
};

}  // namespace canorb

namespace canorb::ccdr {

template <std::size_t D, std::size_t S>
inline constexpr std::size_t fewest_octets<Fixed<D, S>> = D / 2 + 1;

}  // namespace canorb::ccdr
