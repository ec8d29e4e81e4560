#include "idlc/parser.hpp"

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace canorb::idlc {

namespace {

using ast::Operator;
using ast::TypeKind;

/// Thrown inside the parser only, once the error is reported: the declaration cannot be read on.
struct GiveUp {};

constexpr int deepest = 64;

std::string quote(std::string_view text) {
    return '\'' + std::string{text} + '\'';
}

class Parser {
  public:
    Parser(const std::vector<Token>& tokens, Diagnostics& diagnostics)
        : tokens_(tokens), diagnostics_(diagnostics) {}

    ast::File run() {
        ast::File file;
        while (current().kind != TokenKind::end && !diagnostics_.full()) {
            if (is("}")) {
                diagnostics_.error(current().where, "this '}' closes nothing");
                advance();
                if (is(";")) advance();
                continue;
            }
            declaration_or_skip(file.declarations, &Parser::definition);
        }
        return file;
    }

  private:
    using Declarations = std::vector<ast::Declaration>;

    /// What every declaration begins with.
    struct Head {
        std::vector<std::string> comment;
        std::vector<ast::Annotation> annotations;
    };

    /// Counts nesting, against input that would exhaust the stack.
    class Level {
      public:
        explicit Level(Parser& parser) : parser_(parser) {
            if (++parser_.depth_ > deepest) {
                --parser_.depth_;
                parser_.fail("nested too deeply");
            }
        }
        ~Level() { --parser_.depth_; }
        Level(const Level&) = delete;
        Level& operator=(const Level&) = delete;

      private:
        Parser& parser_;
    };

    // Tokens.

    const Token& current() const { return tokens_[at_]; }
    const Token& next() const { return tokens_[at_ + 1 < tokens_.size() ? at_ + 1 : at_]; }
    void advance() {
        if (at_ + 1 < tokens_.size()) ++at_;
        half_taken_ = false;
    }
    bool is(std::string_view text) const {
        const Token& token = current();
        return (token.kind == TokenKind::keyword || token.kind == TokenKind::punctuation) &&
               token.text == text;
    }
    bool take(std::string_view text) {
        if (!is(text)) return false;
        advance();
        return true;
    }
    [[noreturn]] void fail(std::string text) {
        diagnostics_.error(current().where, std::move(text));
        throw GiveUp{};
    }
    [[noreturn]] void fail_expected(const std::string& what) {
        const Token& token = current();
        fail("expected " + what + ", not " +
             (token.kind == TokenKind::end ? "the end of the file" : quote(token.text)));
    }
    [[noreturn]] void fail_unsupported(const std::string& what) {
        fail(what + " is not supported yet");
    }
    void expect(std::string_view text, std::string_view behind) {
        if (take(text)) return;
        if (text == ";" && at_ > 0) {
            // The place to mend is behind the token before.
            const Token& before = tokens_[at_ - 1];
            diagnostics_.error(
                {before.where.offset + static_cast<std::uint32_t>(before.text.size())},
                "expected ';' after " + std::string{behind});
            throw GiveUp{};
        }
        fail_expected(quote(text) + " after " + std::string{behind});
    }
    /// The > of a template, also when two of them were read as one >>.
    void expect_closing_angle() {
        if (is(">>")) {
            if (std::exchange(half_taken_, true)) advance();
            return;
        }
        expect(">", "the type's arguments");
    }

    ast::Identifier identifier(const std::string& what) {
        if (current().kind != TokenKind::identifier) {
            if (current().kind == TokenKind::keyword) {
                fail("expected " + what + ", but " + quote(current().text) +
                     " is a keyword (write '_" + std::string{current().text} +
                     "' to use it as a name)");
            }
            fail_expected(what);
        }
        ast::Identifier name{std::string{current().text}, current().where};
        advance();
        return name;
    }

    ast::ScopedName scoped_name(const std::string& what) {
        ast::ScopedName name;
        name.global = take("::");
        do {
            name.parts.push_back(identifier(what));
        } while (take("::"));
        return name;
    }

    std::vector<ast::ScopedName> scoped_names(const std::string& what) {
        std::vector<ast::ScopedName> names;
        do {
            names.push_back(scoped_name(what));
        } while (take(","));
        return names;
    }

    // Declarations.

    void declaration_or_skip(Declarations& into, void (Parser::*one)(Declarations&)) {
        const std::size_t begin = at_;
        const int depth = depth_;
        try {
            (this->*one)(into);
        } catch (const GiveUp&) {
            depth_ = depth;
            in_template_ = false;
            skip_declaration(begin);
        }
    }

    /// Goes behind the declaration that began at `begin`: behind the next ; outside of braces
    /// opened since, or to a } that was not.
    void skip_declaration(std::size_t begin) {
        int open = 0;
        for (std::size_t i = begin; i < at_; ++i) {
            if (tokens_[i].kind != TokenKind::punctuation) continue;
            if (tokens_[i].text == "{") ++open;
            if (tokens_[i].text == "}" && open > 0) --open;
        }
        half_taken_ = false;
        while (current().kind != TokenKind::end) {
            if (is("}") && open == 0) {
                if (at_ == begin) advance();
                return;
            }
            if (is("{")) ++open;
            if (is("}")) --open;
            const bool last = is(";") && open == 0;
            advance();
            if (last) return;
        }
    }

    Head head() {
        Head head{current().comment, {}};
        while (is("@")) head.annotations.push_back(annotation());
        return head;
    }

    ast::Annotation annotation() {
        advance();
        ast::Annotation annotation;
        if (current().kind != TokenKind::identifier && current().kind != TokenKind::keyword) {
            fail_expected("the annotation's name after '@'");
        }
        annotation.name = {std::string{current().text}, current().where};
        advance();
        if (!take("(")) return annotation;
        if (take(")")) return annotation;
        do {
            if (current().kind == TokenKind::identifier && next().text == "=") {
                fail("named arguments of annotations are not supported yet");
            }
            annotation.arguments.push_back(expression());
        } while (take(","));
        expect(")", "the annotation's arguments");
        return annotation;
    }

    static ast::Declaration declaration(const Head& head, ast::Identifier name) {
        return {std::move(name), head.comment, head.annotations, ast::Module{}};
    }

    void definition(Declarations& into) {
        const Level level{*this};
        Head head = this->head();
        if (is("module")) return module(into, head);
        if (is("interface")) return interface(into, head);
        if (common_definition(into, head)) return;
        if (is("abstract") || is("local")) fail_unsupported(quote(current().text) + " interface");
        if (current().kind == TokenKind::identifier) {
            fail("expected a declaration, not " + quote(current().text));
        }
        reject_unsupported();
        fail_expected("a declaration");
    }

    /// What may stand in modules and in interfaces alike; false when nothing of it is here.
    bool common_definition(Declarations& into, Head& head) {
        if (is("const")) {
            constant(into, head);
        } else if (is("typedef")) {
            alias(into, head);
        } else if (is("enum")) {
            enumeration(into, head);
        } else if (is("struct")) {
            structure(into, head);
        } else if (is("exception")) {
            exception(into, head);
        } else {
            return false;
        }
        expect(";", "the declaration");
        return true;
    }

    /// Names the feature where a keyword begins one that this compiler does not know.
    void reject_unsupported() {
        for (const std::string_view feature :
             {"union", "any", "fixed", "wchar", "wstring", "valuetype", "native", "bitmask",
              "bitset", "map", "abstract", "local", "custom", "typeid", "typeprefix", "ValueBase",
              "context", "factory"}) {
            if (is(feature)) fail_unsupported(quote(feature));
        }
    }

    void module(Declarations& into, const Head& head) {
        advance();
        ast::Declaration module = declaration(head, identifier("the module's name"));
        expect("{", "the module's name");
        ast::Module body;
        nested(body.declarations, &Parser::definition);
        module.body = std::move(body);
        into.push_back(std::move(module));
        expect(";", "the module");
    }

    /// Declarations up to the closing brace.
    void nested(Declarations& into, void (Parser::*one)(Declarations&)) {
        const Token& open = tokens_[at_ - 1];
        while (!is("}")) {
            if (current().kind == TokenKind::end) {
                diagnostics_.error(current().where, "expected '}' before the end of the file");
                diagnostics_.note(open.where, "to close this '{'");
                throw GiveUp{};
            }
            if (diagnostics_.full()) throw GiveUp{};
            declaration_or_skip(into, one);
        }
        advance();
    }

    void interface(Declarations& into, const Head& head) {
        advance();
        ast::Declaration interface = declaration(head, identifier("the interface's name"));
        if (take(";")) {
            interface.body = ast::ForwardInterface{};
            into.push_back(std::move(interface));
            return;
        }
        ast::Interface body;
        if (take(":")) body.bases = scoped_names("the name of a base interface");
        expect("{", body.bases.empty() ? "the interface's name" : "the base interfaces");
        nested(body.body, &Parser::interface_member);
        interface.body = std::move(body);
        into.push_back(std::move(interface));
        expect(";", "the interface");
    }

    void interface_member(Declarations& into) {
        const Level level{*this};
        Head head = this->head();
        if (common_definition(into, head)) return;
        if (is("module") || is("interface")) {
            fail(quote(current().text) + " cannot be declared inside an interface");
        }
        if (is("attribute") || is("readonly")) {
            attribute(into, head);
        } else {
            operation(into, head);
        }
        expect(";", "the declaration");
    }

    void attribute(Declarations& into, const Head& head) {
        ast::Attribute attribute;
        attribute.readonly = take("readonly");
        if (!take("attribute")) fail_expected("'attribute' after 'readonly'");
        attribute.type = type();
        std::vector<ast::Identifier> names;
        do {
            names.push_back(identifier("the attribute's name"));
        } while (take(","));
        if (attribute.readonly && is("raises")) {
            attribute.get_raises = raises("raises");
        } else {
            attribute.get_raises = raises("getraises");
            attribute.set_raises = raises("setraises");
        }
        for (ast::Identifier& name : names) {
            ast::Declaration declared = declaration(head, std::move(name));
            declared.body = attribute;
            into.push_back(std::move(declared));
        }
    }

    std::vector<ast::ScopedName> raises(std::string_view keyword) {
        if (!take(keyword)) return {};
        expect("(", quote(keyword));
        std::vector<ast::ScopedName> names = scoped_names("the name of an exception");
        expect(")", "the exceptions");
        return names;
    }

    void operation(Declarations& into, const Head& head) {
        ast::Operation operation;
        operation.oneway = take("oneway");
        if (!take("void")) operation.result = type();
        ast::Declaration declared = declaration(head, identifier("the operation's name"));
        expect("(", "the operation's name");
        if (!take(")")) {
            do {
                operation.parameters.push_back(parameter());
            } while (take(","));
            expect(")", "the parameters");
        }
        operation.raises = raises("raises");
        if (is("context")) fail_unsupported("'context'");
        declared.body = std::move(operation);
        into.push_back(std::move(declared));
    }

    ast::Parameter parameter() {
        ast::Parameter parameter;
        while (is("@")) {
            diagnostics_.warning(current().where, "annotations of parameters are ignored");
            annotation();
        }
        if (take("in")) {
            parameter.direction = ast::Direction::in;
        } else if (take("out")) {
            parameter.direction = ast::Direction::out;
        } else if (take("inout")) {
            parameter.direction = ast::Direction::inout;
        } else {
            fail_expected("'in', 'out' or 'inout' before the parameter's type");
        }
        parameter.type = type();
        parameter.name = identifier("the parameter's name");
        return parameter;
    }

    void constant(Declarations& into, const Head& head) {
        advance();
        ast::Constant constant;
        constant.type = type();
        ast::Declaration declared = declaration(head, identifier("the constant's name"));
        expect("=", "the constant's name");
        constant.value = expression();
        declared.body = std::move(constant);
        into.push_back(std::move(declared));
    }

    void alias(Declarations& into, const Head& head) {
        advance();
        if (is("struct") || is("enum")) {
            fail("declare the " + std::string{current().text} +
                 " by itself, and give the typedef its name");
        }
        ast::Alias alias;
        alias.type = type();
        do {
            ast::Declaration declared = declaration(head, identifier("the new type's name"));
            alias.dimensions = dimensions();
            declared.body = alias;
            into.push_back(std::move(declared));
        } while (take(","));
    }

    std::vector<ast::Expression> dimensions() {
        std::vector<ast::Expression> sizes;
        while (take("[")) {
            const Level level{*this};
            sizes.push_back(expression());
            expect("]", "the array's size");
            if (sizes.size() > deepest) fail("nested too deeply");
        }
        return sizes;
    }

    void enumeration(Declarations& into, const Head& head) {
        advance();
        ast::Declaration declared = declaration(head, identifier("the enum's name"));
        ast::Enum enumeration;
        expect("{", "the enum's name");
        do {
            if (is("@")) fail("annotations of enumerators are not supported yet");
            std::vector<std::string> comment = current().comment;
            enumeration.enumerators.push_back(
                {identifier("the name of an enumerator"), std::move(comment)});
        } while (take(","));
        expect("}", "the enumerators");
        declared.body = std::move(enumeration);
        into.push_back(std::move(declared));
    }

    void structure(Declarations& into, const Head& head) {
        advance();
        ast::Declaration declared = declaration(head, identifier("the struct's name"));
        if (is(";")) fail("forward declared structs are not supported yet");
        if (is(":")) fail("structs that inherit are not supported yet");
        ast::Struct structure;
        structure.members = members("the struct's name");
        if (structure.members.empty()) {
            diagnostics_.error(declared.name.where, "a struct has at least one member");
        }
        declared.body = std::move(structure);
        into.push_back(std::move(declared));
    }

    void exception(Declarations& into, const Head& head) {
        advance();
        ast::Declaration declared = declaration(head, identifier("the exception's name"));
        declared.body = ast::Exception{members("the exception's name")};
        into.push_back(std::move(declared));
    }

    std::vector<ast::Member> members(std::string_view behind) {
        std::vector<ast::Member> members;
        expect("{", behind);
        while (!take("}")) {
            std::vector<std::string> comment = current().comment;
            while (is("@")) {
                diagnostics_.warning(current().where, "annotations of members are ignored");
                annotation();
            }
            if (is("struct") || is("enum")) {
                fail("declare the " + std::string{current().text} +
                     " before, and give the member its name");
            }
            const ast::Type type = this->type();
            do {
                ast::Member member{type, identifier("the member's name"), {}, comment};
                member.dimensions = dimensions();
                members.push_back(std::move(member));
            } while (take(","));
            expect(";", "the member");
        }
        return members;
    }

    // Types.

    ast::Type type() {
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

    void sequence(ast::Type& type) {
        type.kind = TypeKind::sequence;
        expect("<", "'sequence'");
        type.element.push_back(this->type());
        if (take(",")) type.bound = bound();
        expect_closing_angle();
    }

    /// A >> in it closes two templates; a shift needs parentheses.
    ast::Expression bound() {
        const bool outer = std::exchange(in_template_, true);
        ast::Expression value = expression();
        in_template_ = outer;
        return value;
    }

    TypeKind basic_type() {
        constexpr std::pair<std::string_view, TypeKind> one_word[] = {
            {"boolean", TypeKind::boolean}, {"char", TypeKind::character},
            {"octet", TypeKind::octet},     {"int8", TypeKind::int8},
            {"uint8", TypeKind::uint8},     {"int16", TypeKind::int16},
            {"uint16", TypeKind::uint16},   {"int32", TypeKind::int32},
            {"uint32", TypeKind::uint32},   {"int64", TypeKind::int64},
            {"uint64", TypeKind::uint64},   {"float", TypeKind::float32},
            {"double", TypeKind::float64},  {"Object", TypeKind::object},
            {"short", TypeKind::int16},
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

    // Constant expressions, loosest first.

    struct Binary {
        std::string_view symbol;
        Operator op;
        int precedence;
    };

    static constexpr int tightest = 5;

    std::optional<Binary> binary_operator() const {
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

    ast::Expression expression(int precedence = 0) {
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

    ast::Expression unary() {
        const Level level{*this};
        ast::Expression result;
        result.where = current().where;
        if (is("+") || is("-") || is("~")) {
            result.op = is("+")   ? Operator::plus
                        : is("-") ? Operator::negate
                                  : Operator::complement;
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

    ast::Literal literal() {
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

    std::uint64_t integer(const Token& token) {
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

    double floating(const Token& token) {
        double value = 0;
        const char* end = token.text.data() + token.text.size();
        const auto [rest, error] = std::from_chars(token.text.data(), end, value);
        if (error != std::errc{}) {
            diagnostics_.error(token.where, "this number is out of the range of double");
        }
        return value;
    }

    ast::Literal string_literal() {
        ast::StringLiteral literal;
        while (current().kind == TokenKind::string) {
            literal.value += current().value;
            advance();
        }
        return literal;
    }

    const std::vector<Token>& tokens_;
    Diagnostics& diagnostics_;
    std::size_t at_ = 0;
    int depth_ = 0;
    bool half_taken_ = false;   ///< the first > of the current >> is used
    bool in_template_ = false;  ///< inside of < >, where >> is no shift
};

}  // namespace

ast::File parse(const std::vector<Token>& tokens, Diagnostics& diagnostics) {
    return Parser{tokens, diagnostics}.run();
}

}  // namespace canorb::idlc
