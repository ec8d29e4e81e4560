#include "idlc/parse/type_parser.hpp"

#include <charconv>
#include <utility>

namespace canorb::idlc::parse {

using ast::Operator;
using ast::TypeKind;

namespace {

// Of the binary operators: * / and %.
constexpr int tightest = 5;

}  // namespace

ast::Type TypeParser::type() {
    const Level level{*this};
    ast::Type type;
    type.where = current().where;
    if (current().kind == TokenKind::identifier || is("::")) {
        type.kind = TypeKind::name;
        type.name = scoped_name("the name of a type");
    } else if (take("sequence")) {
        sequence(type);
    } else if (take("string")) {
        type.kind = TypeKind::string;
        if (take("<")) {
            type.bound = bound();
            expect_closing_angle();
        }
    } else {
        type.kind = basic_type();
    }
    return type;
}

void TypeParser::sequence(ast::Type& type) {
    type.kind = TypeKind::sequence;
    expect("<", "'sequence'");
    type.elements.push_back(this->type());
    if (take(",")) type.bound = bound();
    expect_closing_angle();
}

ast::Expression TypeParser::bound() {
    const bool outer = std::exchange(in_template_, true);
    ast::Expression value = expression();
    in_template_ = outer;
    return value;
}

TypeKind TypeParser::basic_type() {
    constexpr std::pair<std::string_view, TypeKind> one_word[] = {
        {"boolean", TypeKind::boolean}, {"char", TypeKind::character}, {"octet", TypeKind::octet},
        {"int8", TypeKind::int8},       {"uint8", TypeKind::uint8},    {"int16", TypeKind::int16},
        {"uint16", TypeKind::uint16},   {"int32", TypeKind::int32},    {"uint32", TypeKind::uint32},
        {"int64", TypeKind::int64},     {"uint64", TypeKind::uint64},  {"float", TypeKind::float32},
        {"double", TypeKind::float64},  {"Object", TypeKind::object},  {"short", TypeKind::int16},
    };
    for (const auto& [word, kind] : one_word) {
        if (take(word)) return kind;
    }
    if (is("long") && next().text == "double") fail_unsupported("'long double'");
    if (take("long")) return take("long") ? TypeKind::int64 : TypeKind::int32;
    if (take("unsigned")) {
        if (take("short")) return TypeKind::uint16;
        if (take("long")) return take("long") ? TypeKind::uint64 : TypeKind::uint32;
        fail_expected("'short' or 'long' after 'unsigned'");
    }
    reject_unsupported();
    if (is("void")) fail("only an operation's result can be void");
    fail_expected("a type");
}

std::optional<TypeParser::Binary> TypeParser::binary_operator() const {
    constexpr Binary operators[] = {
        {"|", Operator::bit_or, 0},        {"^", Operator::bit_xor, 1},
        {"&", Operator::bit_and, 2},       {"<<", Operator::shift_left, 3},
        {">>", Operator::shift_right, 3},  {"+", Operator::add, 4},
        {"-", Operator::subtract, 4},      {"*", Operator::multiply, tightest},
        {"/", Operator::divide, tightest}, {"%", Operator::modulo, tightest},
    };
    for (const Binary& candidate : operators) {
        if (candidate.op == Operator::shift_right && in_template_) continue;
        if (is(candidate.symbol)) return candidate;
    }
    return std::nullopt;
}

ast::Expression TypeParser::expression(int precedence) {
    const Level level{*this};
    ast::Expression left = unary();
    // A chain grows the tree to the left: its length counts as depth for who walks the tree.
    int chain = 0;
    while (const std::optional<Binary> binary = binary_operator()) {
        if (binary->precedence < precedence) break;
        if (++chain > 4 * deepest) fail("too long an expression");
        ast::Expression whole;
        whole.op = binary->op;
        whole.where = current().where;
        advance();
        whole.operands.push_back(std::move(left));
        whole.operands.push_back(expression(binary->precedence + 1));
        left = std::move(whole);
    }
    return left;
}

ast::Expression TypeParser::unary() {
    const Level level{*this};
    ast::Expression result;
    result.where = current().where;
    if (is("+") || is("-") || is("~")) {
        result.op = is("+") ? Operator::plus : is("-") ? Operator::negate : Operator::complement;
        advance();
        result.operands.push_back(unary());
    } else if (take("(")) {
        const bool outer = std::exchange(in_template_, false);
        result = expression();
        in_template_ = outer;
        expect(")", "the expression");
    } else if (current().kind == TokenKind::identifier || is("::")) {
        result.op = Operator::name;
        result.name = scoped_name("the name of a constant");
    } else {
        result.literal = literal();
    }
    return result;
}

ast::Literal TypeParser::literal() {
    const Token& token = current();
    ast::Literal value;
    switch (token.kind) {
        case TokenKind::integer:
            value = integer(token);
            break;
        case TokenKind::floating:
            value = floating(token);
            break;
        case TokenKind::character:
            value = token.value.empty() ? '?' : token.value.front();
            break;
        case TokenKind::string:
            return string_literal();
        default:
            if (!is("TRUE") && !is("FALSE")) fail_expected("a constant value");
            value = is("TRUE");
    }
    advance();
    return value;
}

std::uint64_t TypeParser::integer(const Token& token) {
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

long double TypeParser::floating(const Token& token) {
    long double value = 0;
    const char* end = token.text.data() + token.text.size();
    const auto [rest, error] = std::from_chars(token.text.data(), end, value);
    if (error != std::errc{}) {
        diagnostics_.error(token.where, "this number is out of the range of long double");
    }
    return value;
}

ast::Literal TypeParser::string_literal() {
    ast::StringLiteral literal;
    while (current().kind == TokenKind::string) {
        literal.value += current().value;
        advance();
    }
    return literal;
}

void TypeParser::reject_unsupported() {
    for (const std::string_view feature :
         {"union", "any", "fixed", "wchar", "wstring", "valuetype", "native", "bitmask", "bitset",
          "map", "abstract", "local", "custom", "typeid", "typeprefix", "ValueBase", "context",
          "factory"}) {
        if (is(feature)) fail_unsupported(quote(feature));
    }
}

std::vector<ast::Expression> TypeParser::dimensions() {
    std::vector<ast::Expression> sizes;
    while (take("[")) {
        const Level level{*this};
        sizes.push_back(expression());
        expect("]", "the array's size");
        if (sizes.size() > deepest) fail("nested too deeply");
    }
    return sizes;
}

}  // namespace canorb::idlc::parse
