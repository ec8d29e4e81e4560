#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "idlc/ast.hpp"

namespace canorb::idlc::check {

/// Wide enough that the operands of every operation are exact.
__extension__ using Wide = __int128;

/// An exact decimal number: units / 10^scale.
struct Decimal {
    Wide units = 0;
    int scale = 0;
};

/// Of a fixed.
inline constexpr int most_digits = 31;

constexpr Wide power_of_ten(int exponent) {
    Wide power = 1;
    for (int i = 0; i < exponent; ++i) power *= 10;
    return power;
}

std::string to_string(Wide value);
/// "-12.5"
std::string to_string(const Decimal& value);

/// The digits of a literal, "12.50"; nothing where they are too many.
std::optional<Decimal> decimal(std::string_view digits);

/// The sum, difference, product or quotient; nothing where it has too many digits before the
/// point. Of a quotient the digits that are too many behind the point are cut. `right` is not 0
/// in a division.
std::optional<Decimal> calculate(ast::Operator op, Decimal left, Decimal right);

}  // namespace canorb::idlc::check
