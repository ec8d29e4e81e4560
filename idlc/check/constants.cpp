#include "idlc/check/constants.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "idlc/check/decimal.hpp"

namespace canorb::idlc::check {

namespace {

using ast::Operator;
using model::TypeKind;

using Operand = std::variant<Wide, long double, Decimal, char, char16_t, bool, std::string,
                             std::u16string, model::EnumeratorValue>;

struct Range {
    Wide lowest;
    Wide highest;
};

template <typename T>
constexpr Range range_of() {
    return {std::numeric_limits<T>::min(), std::numeric_limits<T>::max()};
}

std::optional<Range> integer_range(TypeKind kind) {
    switch (kind) {
        case TypeKind::octet:
        case TypeKind::uint8:
            return range_of<std::uint8_t>();
        case TypeKind::int8:
            return range_of<std::int8_t>();
        case TypeKind::int16:
            return range_of<std::int16_t>();
        case TypeKind::uint16:
            return range_of<std::uint16_t>();
        case TypeKind::int32:
            return range_of<std::int32_t>();
        case TypeKind::uint32:
            return range_of<std::uint32_t>();
        case TypeKind::int64:
            return range_of<std::int64_t>();
        case TypeKind::uint64:
            return range_of<std::uint64_t>();
        default:
            return std::nullopt;
    }
}

/// The range of an integer type or a bitmask.
std::optional<Range> integer_range(const model::Type& type) {
    if (type.kind != TypeKind::named) return integer_range(type.kind);
    const auto* mask = std::get_if<model::Bitmask>(&type.definition->body);
    if (mask == nullptr) return std::nullopt;
    return Range{0, (Wide{1} << mask->bit_bound) - 1};
}

std::string_view name(const Operand& operand) {
    constexpr std::string_view names[] = {
        "an integer",  "a floating-point number", "a fixed-point number",
        "a character", "a wide character",        "a boolean",
        "a string",    "a wide string",           "an enumerator"};
    return names[operand.index()];
}

class Evaluator {
  public:
    Evaluator(const model::Type& type, const FindConstant& find, Diagnostics& diagnostics)
        : type_(type), find_(find), diagnostics_(diagnostics) {}

    std::optional<Operand> value(const ast::Expression& expression) {
        if (expression.op == Operator::literal) return literal(expression);
        if (expression.op == Operator::name) return named(expression.name);
        const std::optional<Operand> left = value(expression.operands.front());
        if (!left) return std::nullopt;
        if (expression.operands.size() == 1) return unary(expression, *left);
        const std::optional<Operand> right = value(expression.operands.back());
        if (!right) return std::nullopt;
        return binary(expression, *left, *right);
    }

  private:
    std::optional<Operand> literal(const ast::Expression& expression) {
        if (const auto* fixed = std::get_if<ast::FixedLiteral>(&expression.literal)) {
            const std::optional<Decimal> value = decimal(fixed->digits);
            if (!value) too_many_digits(expression);
            return value;
        }
        return std::visit(
            [](const auto& written) -> Operand {
                using T = std::decay_t<decltype(written)>;
                if constexpr (std::is_same_v<T, std::uint64_t>) {
                    return Wide{written};
                } else if constexpr (std::is_same_v<T, ast::FixedLiteral>) {
                    return Decimal{};
                } else if constexpr (std::is_same_v<T, ast::StringLiteral> ||
                                     std::is_same_v<T, ast::WideStringLiteral> ||
                                     std::is_same_v<T, ast::WideCharacterLiteral>) {
                    return written.value;
                } else {
                    return written;
                }
            },
            expression.literal);
    }

    void too_many_digits(const ast::Expression& expression) {
        diagnostics_.error(expression.where, "a fixed has at most 31 digits");
    }

    std::optional<Operand> named(const ast::ScopedName& name) {
        const std::optional<model::Value> value = find_(name);
        if (!value) return std::nullopt;
        return std::visit(
            [](const auto& known) -> Operand {
                using T = std::decay_t<decltype(known)>;
                if constexpr (std::is_same_v<T, std::int64_t> || std::is_same_v<T, std::uint64_t>) {
                    return Wide{known};
                } else if constexpr (std::is_same_v<T, model::FixedValue>) {
                    const bool negative = known.text.starts_with('-');
                    Decimal fixed = decimal(std::string_view{known.text}.substr(negative ? 1 : 0))
                                        .value_or(Decimal{});
                    if (negative) fixed.units = -fixed.units;
                    return fixed;
                } else {
                    return known;
                }
            },
            *value);
    }

    std::optional<Operand> unary(const ast::Expression& expression, const Operand& operand) {
        if (const auto* integer = std::get_if<Wide>(&operand)) {
            if (expression.op == Operator::plus) return *integer;
            if (expression.op == Operator::negate) return -*integer;
            // All bits inverted, in the type of the constant.
            const std::optional<Range> range = integer_range(type_);
            if (range && range->lowest == 0) return range->highest - *integer;
            return -*integer - 1;
        }
        const bool negate = expression.op == Operator::negate;
        if (expression.op != Operator::complement) {
            if (const auto* real = std::get_if<long double>(&operand)) {
                return negate ? -*real : *real;
            }
            if (const auto* fixed = std::get_if<Decimal>(&operand)) {
                return Decimal{negate ? -fixed->units : fixed->units, fixed->scale};
            }
        }
        diagnostics_.error(expression.where,
                           "this operator does not work on " + std::string{name(operand)});
        return std::nullopt;
    }

    std::optional<Operand> binary(const ast::Expression& expression, const Operand& left,
                                  const Operand& right) {
        if (std::holds_alternative<Wide>(left) && std::holds_alternative<Wide>(right)) {
            return integers(expression, std::get<Wide>(left), std::get<Wide>(right));
        }
        const bool arithmetic =
            expression.op == Operator::add || expression.op == Operator::subtract ||
            expression.op == Operator::multiply || expression.op == Operator::divide;
        const auto* left_real = std::get_if<long double>(&left);
        const auto* right_real = std::get_if<long double>(&right);
        if (arithmetic && left_real != nullptr && right_real != nullptr) {
            return reals(expression, *left_real, *right_real);
        }
        const auto* left_fixed = std::get_if<Decimal>(&left);
        const auto* right_fixed = std::get_if<Decimal>(&right);
        if (arithmetic && left_fixed != nullptr && right_fixed != nullptr) {
            return decimals(expression, *left_fixed, *right_fixed);
        }
        diagnostics_.error(expression.where, "this operator does not work on " +
                                                 std::string{name(left)} + " and " +
                                                 std::string{name(right)});
        return std::nullopt;
    }

    std::optional<Operand> reals(const ast::Expression& expression, long double left,
                                 long double right) {
        switch (expression.op) {
            case Operator::add:
                return left + right;
            case Operator::subtract:
                return left - right;
            case Operator::multiply:
                return left * right;
            default:
                break;
        }
        if (right == 0) return by_zero(expression);
        return left / right;
    }

    std::optional<Operand> decimals(const ast::Expression& expression, const Decimal& left,
                                    const Decimal& right) {
        if (expression.op == Operator::divide && right.units == 0) return by_zero(expression);
        const std::optional<Decimal> result = calculate(expression.op, left, right);
        if (!result) too_many_digits(expression);
        return result;
    }

    std::nullopt_t by_zero(const ast::Expression& expression) {
        diagnostics_.error(expression.where, "division by zero");
        return std::nullopt;
    }

    std::optional<Operand> integers(const ast::Expression& expression, Wide left, Wide right) {
        const Operator op = expression.op;
        if ((op == Operator::divide || op == Operator::modulo) && right == 0) {
            return by_zero(expression);
        }
        if ((op == Operator::shift_left || op == Operator::shift_right) &&
            (right < 0 || right > 63)) {
            diagnostics_.error(expression.where, "a shift is by 0 to 63 bits");
            return std::nullopt;
        }
        Wide result = 0;
        bool overflow = false;
        switch (op) {
            case Operator::bit_or:
                result = left | right;
                break;
            case Operator::bit_xor:
                result = left ^ right;
                break;
            case Operator::bit_and:
                result = left & right;
                break;
            case Operator::shift_left:
                overflow = __builtin_mul_overflow(left, Wide{1} << right, &result);
                break;
            case Operator::shift_right:
                result = left >> right;
                break;
            case Operator::add:
                overflow = __builtin_add_overflow(left, right, &result);
                break;
            case Operator::subtract:
                overflow = __builtin_sub_overflow(left, right, &result);
                break;
            case Operator::multiply:
                overflow = __builtin_mul_overflow(left, right, &result);
                break;
            case Operator::divide:
                result = left / right;
                break;
            case Operator::modulo:
                result = left % right;
                break;
            default:
                break;
        }
        // Between the extremes of the 64-bit types: nothing beyond can become a value again by
        // steps that people would understand.
        overflow = overflow || result < range_of<std::int64_t>().lowest ||
                   result > range_of<std::uint64_t>().highest;
        if (overflow) {
            diagnostics_.error(expression.where, "the value is larger than any type of IDL holds");
            return std::nullopt;
        }
        return result;
    }

    const model::Type& type_;
    const FindConstant& find_;
    Diagnostics& diagnostics_;
};

/// The operand as a value of a fixed type, which is without digits where the value decides.
std::optional<model::Value> fixed(const Operand& operand, const model::Type& type,
                                  std::string& problem) {
    const auto* value = std::get_if<Decimal>(&operand);
    if (value == nullptr) {
        problem = "expected a fixed-point number like 1.5d, not " + std::string{name(operand)};
        return std::nullopt;
    }
    if (type.digits == 0) return model::FixedValue{to_string(*value)};
    const bool too_fine = value->scale > type.scale;
    const Wide limit = too_fine ? 0 : power_of_ten(type.digits - type.scale + value->scale);
    if (too_fine || value->units >= limit || value->units <= -limit) {
        problem = to_string(*value) + " does not fit into fixed<" + std::to_string(type.digits) +
                  ", " + std::to_string(type.scale) + '>';
        return std::nullopt;
    }
    return model::FixedValue{
        to_string(Decimal{value->units * power_of_ten(type.scale - value->scale), type.scale})};
}

/// The operand as a value of the type; nothing, with the reason in `problem`, when it is none.
std::optional<model::Value> convert(const Operand& operand, const model::Type& type,
                                    std::string& problem) {
    if (const std::optional<Range> range = integer_range(type)) {
        const auto* integer = std::get_if<Wide>(&operand);
        if (integer == nullptr) {
            problem = "expected an integer, not " + std::string{name(operand)};
            return std::nullopt;
        }
        if (*integer < range->lowest || *integer > range->highest) {
            problem = to_string(*integer) + " is outside of " + to_string(range->lowest) + " to " +
                      to_string(range->highest);
            return std::nullopt;
        }
        if (range->lowest == 0) return static_cast<std::uint64_t>(*integer);
        return static_cast<std::int64_t>(*integer);
    }

    const auto expect = [&]<typename T>(std::in_place_type_t<T>,
                                        std::string_view expected) -> std::optional<model::Value> {
        if (const auto* value = std::get_if<T>(&operand)) return *value;
        problem = "expected " + std::string{expected} + ", not " + std::string{name(operand)};
        return std::nullopt;
    };
    switch (type.kind) {
        case TypeKind::boolean:
            return expect(std::in_place_type<bool>, "TRUE or FALSE");
        case TypeKind::character:
            return expect(std::in_place_type<char>, "a character");
        case TypeKind::string: {
            const auto value = expect(std::in_place_type<std::string>, "a string");
            if (value && type.bound != 0 && std::get<std::string>(*value).size() > type.bound) {
                problem = "the string is longer than its bound of " + std::to_string(type.bound);
                return std::nullopt;
            }
            return value;
        }
        case TypeKind::wide_character:
            return expect(std::in_place_type<char16_t>, "a wide character");
        case TypeKind::wide_string: {
            const auto value = expect(std::in_place_type<std::u16string>, "a wide string");
            if (value && type.bound != 0 && std::get<std::u16string>(*value).size() > type.bound) {
                problem = "the string is longer than its bound of " + std::to_string(type.bound);
                return std::nullopt;
            }
            return value;
        }
        case TypeKind::float32:
        case TypeKind::float64:
        case TypeKind::float128: {
            const auto value = expect(std::in_place_type<long double>, "a floating-point number");
            if (!value) return std::nullopt;
            const long double highest =
                type.kind == TypeKind::float32   ? std::numeric_limits<float>::max()
                : type.kind == TypeKind::float64 ? std::numeric_limits<double>::max()
                                                 : std::numeric_limits<long double>::max();
            const long double real = std::get<long double>(*value);
            if (!std::isfinite(real) || std::abs(real) > highest) {
                problem = "the value is outside of the range of its type";
                return std::nullopt;
            }
            return value;
        }
        case TypeKind::fixed:
            return fixed(operand, type, problem);
        default:
            break;
    }
    const auto value = expect(std::in_place_type<model::EnumeratorValue>, "an enumerator");
    if (value && std::get<model::EnumeratorValue>(*value).enumeration != type.definition) {
        problem = "this is no enumerator of '" + type.definition->name + '\'';
        return std::nullopt;
    }
    return value;
}

}  // namespace

std::optional<model::Value> evaluate(const ast::Expression& expression, const model::Type& type,
                                     const FindConstant& find, Diagnostics& diagnostics) {
    const std::optional<Operand> operand = Evaluator{type, find, diagnostics}.value(expression);
    if (!operand) return std::nullopt;
    std::string problem;
    auto value = convert(*operand, type, problem);
    if (!value) diagnostics.error(expression.where, problem);
    return value;
}

}  // namespace canorb::idlc::check
