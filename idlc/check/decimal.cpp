#include "idlc/check/decimal.hpp"

#include <algorithm>

namespace canorb::idlc::check {

using ast::Operator;

namespace {

/// As few digits behind the point as the value needs.
Decimal normalized(Decimal value) {
    while (value.scale > 0 && value.units % 10 == 0) {
        value.units /= 10;
        --value.scale;
    }
    return value;
}

bool has_too_many_digits(const Decimal& value) {
    const Wide limit = power_of_ten(most_digits);
    return value.units <= -limit || value.units >= limit || value.scale > most_digits;
}

/// Both with the larger scale; false where one has too many digits for it.
bool align(Decimal& left, Decimal& right) {
    const auto widen = [](Decimal& value, int scale) {
        const bool lost =
            __builtin_mul_overflow(value.units, power_of_ten(scale - value.scale), &value.units);
        value.scale = scale;
        return !lost;
    };
    const int scale = std::max(left.scale, right.scale);
    return widen(left, scale) && widen(right, scale);
}

/// The quotient, with as many digits as a fixed has; what is behind them is cut. Nothing where the
/// digits before the point are too many.
std::optional<Decimal> quotient(const Decimal& left, const Decimal& right) {
    Decimal result{left.units / right.units, left.scale - right.scale};
    Wide rest = left.units % right.units;
    const Wide limit = power_of_ten(most_digits - 1);
    const auto has_room = [&] { return result.units < limit && result.units > -limit; };
    while (result.scale < 0 || (rest != 0 && result.scale < most_digits && has_room())) {
        if (!has_room()) return std::nullopt;
        rest *= 10;
        result.units = result.units * 10 + rest / right.units;
        rest %= right.units;
        ++result.scale;
    }
    return result;
}

}  // namespace

std::string to_string(Wide value) {
    if (value < 0) return '-' + to_string(-value);
    std::string digits;
    do {
        digits.insert(digits.begin(), static_cast<char>('0' + static_cast<int>(value % 10)));
        value /= 10;
    } while (value != 0);
    return digits;
}

std::string to_string(const Decimal& value) {
    std::string digits = to_string(value.units < 0 ? -value.units : value.units);
    const auto scale = static_cast<std::size_t>(value.scale);
    if (digits.size() <= scale) digits.insert(0, scale + 1 - digits.size(), '0');
    if (scale != 0) digits.insert(digits.size() - scale, 1, '.');
    return (value.units < 0 ? "-" : "") + digits;
}

std::optional<Decimal> decimal(std::string_view digits) {
    Decimal value;
    bool behind_point = false;
    for (const char c : digits) {
        if (c == '.') {
            behind_point = true;
            continue;
        }
        value.units = value.units * 10 + (c - '0');
        if (behind_point) ++value.scale;
        // Zeros at the end may be as many as people like.
        if (behind_point && value.scale > most_digits) value = normalized(value);
        if (has_too_many_digits(value)) return std::nullopt;
    }
    return normalized(value);
}

std::optional<Decimal> calculate(Operator op, Decimal left, Decimal right) {
    Decimal result;
    bool lost = false;
    switch (op) {
        case Operator::add:
        case Operator::subtract:
            lost = !align(left, right);
            result = {op == Operator::add ? left.units + right.units : left.units - right.units,
                      left.scale};
            break;
        case Operator::multiply:
            lost = __builtin_mul_overflow(left.units, right.units, &result.units);
            result.scale = left.scale + right.scale;
            break;
        default: {
            const std::optional<Decimal> divided = quotient(left, right);
            if (!divided) return std::nullopt;
            result = *divided;
        }
    }
    result = normalized(result);
    if (lost || has_too_many_digits(result)) return std::nullopt;
    return result;
}

}  // namespace canorb::idlc::check
