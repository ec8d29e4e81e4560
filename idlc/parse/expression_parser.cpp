#include "idlc/parse/expression_parser.hpp"

#include <charconv>
#include <utility>

namespace canorb::idlc::parse {

using ast::Operator;

namespace {

// Of the binary operators: * / and %.
constexpr int tightest = 5;

// The tree grows by each to the left: who walks it has a stack that ends.
constexpr int most_operators = 1000;

constexpr std::size_t most_fixed_digits = 31;

/// Of a fixed-point number, without the zeros in front and behind.
std::size_t significant_digits(std::string_view number) {
    const bool fraction = number.find('.') != std::string_view::npos;
    if (fraction) number = number.substr(0, number.find_last_not_of('0') + 1);
    std::size_t count = 0;
    for (const char c : number) {
        if (c != '.' && (c != '0' || count > 0)) ++count;
    }
    return count;
}

bool is_text(const Token& token) {
    return token.kind == TokenKind::string || token.kind == TokenKind::wide_string;
}

}  // namespace

ast::Expression ExpressionParser::template_argument() {
    const bool outer = std::exchange(in_template_, true);
    ast::Expression value = expression();
    in_template_ = outer;
    return value;
}

bool ExpressionParser::closes_two_angles() const {
    if (!in_template_ || open_angles_ < 2) return false;
    switch (next().kind) {
        case TokenKind::integer:
        case TokenKind::floating:
        case TokenKind::fixed:
            return false;
        default:
            return !is(next(), "(");
    }
}

std::optional<ExpressionParser::Binary> ExpressionParser::binary_operator() const {
    constexpr Binary operators[] = {
        {"|", Operator::bit_or, 0},        {"^", Operator::bit_xor, 1},
        {"&", Operator::bit_and, 2},       {"<<", Operator::shift_left, 3},
        {">>", Operator::shift_right, 3},  {"+", Operator::add, 4},
        {"-", Operator::subtract, 4},      {"*", Operator::multiply, tightest},
        {"/", Operator::divide, tightest}, {"%", Operator::modulo, tightest},
    };
    for (const Binary& candidate : operators) {
        if (!is(candidate.symbol)) continue;
        if (candidate.op == Operator::shift_right && closes_two_angles()) break;
        return candidate;
    }
    return std::nullopt;
}

ast::Expression ExpressionParser::expression() {
    operators_ = 0;
    return operation(0);
}

ast::Expression ExpressionParser::operation(int precedence) {
    ast::Expression left = unary();
    while (const std::optional<Binary> binary = binary_operator()) {
        if (binary->precedence < precedence) break;
        if (++operators_ > most_operators) fail("too long an expression");
        ast::Expression whole;
        whole.op = binary->op;
        whole.where = current().where;
        advance();
        whole.operands.push_back(std::move(left));
        whole.operands.push_back(operation(binary->precedence + 1));
        left = std::move(whole);
    }
    return left;
}

ast::Expression ExpressionParser::unary() {
    const Level level{*this};
    ast::Expression result;
    result.where = current().where;
    if (is("+") || is("-") || is("~")) {
        result.op = is("+") ? Operator::plus : is("-") ? Operator::negate : Operator::complement;
        advance();
        if (is("+") || is("-") || is("~")) {
            fail("a second operator before a value needs parentheses");
        }
        result.operands.push_back(unary());
    } else if (take("(")) {
        const bool outer = std::exchange(in_template_, false);
        result = operation(0);
        in_template_ = outer;
        expect(")", "the expression");
    } else if (current().kind == TokenKind::identifier || is("::")) {
        check_used_name();
        result.op = Operator::name;
        result.name = scoped_name("the name of a constant");
    } else {
        result.literal = literal();
    }
    return result;
}

ast::Literal ExpressionParser::literal() {
    const Token& token = current();
    if (is_text(token)) return text();
    ast::Literal value;
    switch (token.kind) {
        case TokenKind::integer:
            value = integer(token);
            break;
        case TokenKind::floating:
            value = floating(token);
            break;
        case TokenKind::fixed:
            value = fixed(token);
            break;
        case TokenKind::character:
            value = token.value.front();
            break;
        case TokenKind::wide_character:
            value = ast::WideCharacterLiteral{token.wide_value.front()};
            break;
        default:
            if (!is("TRUE") && !is("FALSE")) fail_expected("a constant value");
            value = is("TRUE");
    }
    advance();
    return value;
}

std::uint64_t ExpressionParser::integer(const Token& token) {
    std::string_view digits = token.text;
    int base = 10;
    if (digits.starts_with("0x") || digits.starts_with("0X")) {
        base = 16;
        digits.remove_prefix(2);
    } else if (digits.starts_with('0')) {
        base = 8;
    }
    std::uint64_t value = 0;
    const char* end = digits.data() + digits.size();
    const auto [rest, error] = std::from_chars(digits.data(), end, value, base);
    if (error == std::errc::result_out_of_range) {
        diagnostics_.error(token.where, "this number is larger than any type of IDL holds");
    } else if (error != std::errc{} || rest != end) {
        diagnostics_.error(token.where, base == 8 ? "a number that begins with 0 is octal, "
                                                    "and has digits 0 to 7 only"
                                                  : "this is no number");
    }
    return value;
}

long double ExpressionParser::floating(const Token& token) {
    long double value = 0;
    const char* end = token.text.data() + token.text.size();
    const auto [rest, error] = std::from_chars(token.text.data(), end, value);
    if (error != std::errc{}) {
        diagnostics_.error(token.where, "this number is out of the range of long double");
    }
    return value;
}

ast::FixedLiteral ExpressionParser::fixed(const Token& token) {
    const std::string_view digits = token.text.substr(0, token.text.size() - 1);
    if (significant_digits(digits) > most_fixed_digits) {
        diagnostics_.error(token.where, "a fixed-point number has at most 31 digits");
    }
    return {std::string{digits}};
}

ast::Literal ExpressionParser::text() {
    const TokenKind kind = current().kind;
    ast::StringLiteral narrow;
    ast::WideStringLiteral wide;
    for (; is_text(current()); advance()) {
        if (current().kind != kind) fail("a string and a wide string do not make one");
        narrow.value += current().value;
        wide.value += current().wide_value;
    }
    if (kind == TokenKind::string) return narrow;
    return wide;
}

std::vector<ast::Annotation> ExpressionParser::annotations() {
    std::vector<ast::Annotation> list;
    while (is("@")) list.push_back(annotation());
    return list;
}

ast::Annotation ExpressionParser::annotation() {
    advance();
    ast::Annotation annotation;
    annotation.name = annotation_name();
    if (!take("(") || take(")")) return annotation;
    const bool outer = std::exchange(in_template_, false);
    do {
        ast::AnnotationArgument argument;
        if (is_any_word(current()) && is(next(), "=")) {
            argument.name = take_identifier();
            advance();
        }
        argument.value = expression();
        annotation.arguments.push_back(std::move(argument));
    } while (take(","));
    in_template_ = outer;
    expect(")", "the annotation's arguments");
    return annotation;
}

ast::ScopedName ExpressionParser::annotation_name() {
    // Some are called as keywords are: @default, @oneway.
    ast::ScopedName name;
    name.global = take("::");
    do {
        if (!is_any_word(current())) fail_expected("the annotation's name");
        name.parts.push_back(take_identifier());
    } while (take("::"));
    return name;
}

}  // namespace canorb::idlc::parse
