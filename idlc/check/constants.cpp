#include "idlc/check/constants.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

namespace canorb::idlc::check {

namespace {

using ast::Operator;
using model::TypeKind;

/// Wide enough that the operands of every operation are exact.
__extension__ using Wide = __int128;

using Operand = std::variant<Wide, double, char, bool, std::string, model::EnumeratorValue>;

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

std::string_view name(const Operand& operand) {
    constexpr std::string_view names[] = {"an integer",  "a floating-point number",
                                          "a character", "a boolean",
                                          "a string",    "an enumerator"};
    return names[operand.index()];
}

class Evaluator {
  public:
    Evaluator(const model::Type& type, const FindConstant& find, Diagnostics& diagnostics)
        : type_(type), find_(find), diagnostics_(diagnostics) {}

    std::optional<Operand> value(const ast::Expression& expression) {
        if (expression.op == Operator::literal) return literal(expression.literal);
        if (expression.op == Operator::name) return named(expression.name);
        const std::optional<Operand> left = value(expression.operands.front());
        if (!left) return std::nullopt;
        if (expression.operands.size() == 1) return unary(expression, *left);
        const std::optional<Operand> right = value(expression.operands.back());
        if (!right) return std::nullopt;
        return binary(expression, *left, *right);
    }

  private:
    static Operand literal(const ast::Literal& literal) {
        return std::visit(
            [](const auto& value) -> Operand {
                using T = std::decay_t<decltype(value)>;
                if constexpr (std::is_same_v<T, std::uint64_t>) {
                    return Wide{value};
                } else if constexpr (std::is_same_v<T, ast::StringLiteral>) {
                    return value.value;
                } else {
                    return value;
                }
            },
            literal);
    }

    std::optional<Operand> named(const ast::ScopedName& name) {
        const std::optional<model::Value> value = find_(name);
        if (!value) return std::nullopt;
        return std::visit(
            [](const auto& known) -> Operand {
                using T = std::decay_t<decltype(known)>;
                if constexpr (std::is_same_v<T, std::int64_t> || std::is_same_v<T, std::uint64_t>) {
                    return Wide{known};
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
            const std::optional<Range> range = integer_range(type_.kind);
            if (range && range->lowest == 0) return range->highest - *integer;
            return -*integer - 1;
        }
        const auto* real = std::get_if<double>(&operand);
        if (real != nullptr && expression.op != Operator::complement) {
            return expression.op == Operator::negate ? -*real : *real;
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
        if (std::holds_alternative<double>(left) && std::holds_alternative<double>(right)) {
            const auto result =
                reals(expression.op, std::get<double>(left), std::get<double>(right));
            if (result) return *result;
        }
        diagnostics_.error(expression.where, "this operator does not work on " +
                                                 std::string{name(left)} + " and " +
                                                 std::string{name(right)});
        return std::nullopt;
    }

    static std::optional<double> reals(Operator op, double left, double right) {
        switch (op) {
            case Operator::add:
                return left + right;
            case Operator::subtract:
                return left - right;
            case Operator::multiply:
                return left * right;
            case Operator::divide:
                return left / right;
            default:
                return std::nullopt;
        }
    }

    std::optional<Operand> integers(const ast::Expression& expression, Wide left, Wide right) {
        const Operator op = expression.op;
        if ((op == Operator::divide || op == Operator::modulo) && right == 0) {
            diagnostics_.error(expression.where, "division by zero");
            return std::nullopt;
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

std::string to_string(Wide value) {
    if (value < 0) return '-' + to_string(-value);
    std::string digits;
    do {
        digits.insert(digits.begin(), static_cast<char>('0' + static_cast<int>(value % 10)));
        value /= 10;
    } while (value != 0);
    return digits;
}

/// The operand as a value of the type; nothing, with the reason in `problem`, when it is none.
std::optional<model::Value> convert(const Operand& operand, const model::Type& type,
                                    std::string& problem) {
    if (const std::optional<Range> range = integer_range(type.kind)) {
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
        case TypeKind::float32:
        case TypeKind::float64: {
            const auto value = expect(std::in_place_type<double>, "a floating-point number");
            if (!value) return std::nullopt;
            const double highest = type.kind == TypeKind::float32
                                       ? double{std::numeric_limits<float>::max()}
                                       : std::numeric_limits<double>::max();
            const double real = std::get<double>(*value);
            if (!std::isfinite(real) || std::abs(real) > highest) {
                problem = "the value is outside of the range of its type";
                return std::nullopt;
            }
            return value;
        }
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
