#include "idlc/parse/parser.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "idlc/parse/data_parser.hpp"

namespace canorb::idlc::parse {

namespace {

using ast::IdDirective;
using ast::InterfaceKind;

ast::Declaration at(Location where, IdDirective directive) {
    return {{"", where}, {}, {}, std::move(directive)};
}

/// Reads one #pragma that names repository ids.
class DirectiveParser : public TokenReader {
  public:
    using TokenReader::TokenReader;

    /// What follows the word pragma; throws GiveUp.
    IdDirective run() {
        IdDirective directive;
        const std::string_view word = current().text;
        advance();
        if (word == "prefix") {
            directive.text = text("#pragma prefix \"example.com\"");
        } else if (word == "ID") {
            constexpr std::string_view form = "#pragma ID Name \"IDL:Name:1.0\"";
            directive.kind = IdDirective::Kind::id;
            directive.name = name(form);
            directive.text = text(form);
        } else {
            constexpr std::string_view form = "#pragma version Name 1.0";
            directive.kind = IdDirective::Kind::version;
            directive.name = name(form);
            if (current().kind != TokenKind::floating || !is_version(current().text)) wrong(form);
            directive.text = current().text;
            advance();
        }
        if (!at_end()) fail("expected the end of the #pragma, not " + quote(current().text));
        return directive;
    }

  private:
    [[noreturn]] void wrong(std::string_view form) {
        fail("this #pragma is written " + std::string{form});
    }
    static bool is_version(std::string_view text) {
        return text.front() != '.' && text.back() != '.' &&
               text.find_first_not_of("0123456789.") == std::string_view::npos;
    }
    ast::ScopedName name(std::string_view form) {
        if (!is_name(current()) && !is("::")) wrong(form);
        return scoped_name("a name");
    }
    std::string text(std::string_view form) {
        if (current().kind != TokenKind::string) wrong(form);
        std::string value = current().value;
        advance();
        return value;
    }
};

class Parser : public DataParser {
  public:
    using DataParser::DataParser;

    ast::File run() {
        ast::File file;
        while (!diagnostics_.full()) {
            directives(file.declarations);
            if (at_end()) break;
            if (is("}")) {
                error("this '}' closes nothing");
                advance();
                if (is(";")) advance();
                continue;
            }
            attempt([&] { definition(file.declarations); });
        }
        return file;
    }

  private:
    /// Those before the current token that are not declarations yet.
    void directives(Declarations& into) {
        for (; directives_read_ <= at_; ++directives_read_) {
            for (const Directive& directive : tokens_[directives_read_].directives) {
                try {
                    DirectiveParser parser{directive.tokens, diagnostics_};
                    into.push_back(at(directive.where, parser.run()));
                } catch (const GiveUp&) {
                    continue;
                }
            }
        }
    }

    void definition(Declarations& into) {
        const Level level{*this};
        Head head = this->head();
        if (is_word("namespace") && is_name(next())) {
            error("IDL has no 'namespace': write 'module'");
            return module(into, head);
        }
        if (is("module")) return module(into, head);
        if (is("interface") || is("local") || is("abstract")) return interface(into, head);
        if (common_definition(into, head)) return;
        if (is(";")) {
            error("there is no declaration here: leave this ';' out");
            return advance();
        }
        if (is("valuetype") || is("custom")) return value_type(into, head);
        reject_unsupported();
        if (is_word("class")) fail("IDL has no 'class': write 'interface'");
        if (is("attribute") || is("readonly") || is("oneway") || is("void")) {
            fail(quote(current().text) + " belongs inside an interface");
        }
        if (is_name(current())) {
            const std::string_view keyword = collides_with_keyword(current().text);
            fail("expected a declaration, not " + quote(current().text) +
                 (keyword.empty() ? "" : ": the keyword is " + quote(keyword)));
        }
        fail_expected("a declaration");
    }

    /// What may stand in modules and in interfaces alike; false when nothing of it is here.
    bool common_definition(Declarations& into, Head& head) {
        if (const std::size_t end = end_of_name(1);
            is_id_word() && end != 0 && peek(end).kind == TokenKind::string) {
            id_declaration(into);
        } else if (!data(into, head)) {
            return false;
        }
        expect_semicolon("the declaration");
        return true;
    }

    bool is_id_word() const { return is_word("typeid") || is_word("typeprefix"); }

    /// How many tokens ahead a scoped name ends that begins `ahead`; 0 when there is none.
    std::size_t end_of_name(std::size_t ahead) const {
        if (is(peek(ahead), "::")) ++ahead;
        while (is_name(peek(ahead)) && is(peek(ahead + 1), "::")) ahead += 2;
        return is_name(peek(ahead)) ? ahead + 1 : 0;
    }

    void id_declaration(Declarations& into) {
        const Location where = current().where;
        IdDirective directive;
        directive.kind =
            is_word("typeid") ? IdDirective::Kind::type_id : IdDirective::Kind::type_prefix;
        advance();
        directive.name = scoped_name("a name");
        directive.text = current().value;
        advance();
        into.push_back(at(where, std::move(directive)));
    }

    /// Only its name: those that other files declare may be left alone.
    void value_type(Declarations& into, const Head& head) {
        if (!is("valuetype")) advance();
        if (!take("valuetype")) fail_expected("'valuetype' after " + quote(tokens_[at_ - 1].text));
        ast::Declaration value = declaration(head, identifier("the valuetype's name"));
        while (!is(";") && !is("{") && !is("}") && !at_end()) advance();
        if (is("{")) skip_block();
        value.body = ast::ValueType{};
        into.push_back(std::move(value));
        expect_semicolon("the valuetype");
    }

    void reject_unsupported() {
        if (is_word("import")) fail_unsupported("'import'");
        if (!is_name(next()) && !is(next(), "::")) {
            if (is_id_word()) fail_expected("a declaration");
            return;
        }
        if (is_id_word()) {
            fail(quote(current().text) + " is followed by a name and a string");
        }
        for (const std::string_view word :
             {"eventtype", "component", "home", "porttype", "connector", "bitset"}) {
            if (is_word(word)) fail_unsupported(quote(word));
        }
    }

    void module(Declarations& into, const Head& head) {
        advance();
        ast::Declaration module = declaration(head, identifier("the module's name"));
        if (is("<")) fail_unsupported("a template module");
        if (is("::")) fail("a module's name has one part: nest modules to name inner ones");
        expect("{", "the module's name");
        ast::Module body;
        if (!nested(body.declarations, &Parser::definition)) {
            diagnostics_.error(module.name.where, "a module has at least one declaration");
        }
        module.body = std::move(body);
        into.push_back(std::move(module));
        expect_semicolon("the module");
    }

    /// Declarations up to the closing brace; false when there are none.
    bool nested(Declarations& into, void (Parser::*one)(Declarations&)) {
        const Token& open = tokens_[at_ - 1];
        const std::size_t begin = at_;
        while (true) {
            directives(into);
            if (is("}")) break;
            if (at_end()) fail_unclosed(open);
            if (one == &Parser::interface_member && begins_no_interface_member() &&
                outdented(open)) {
                fail_unclosed(open);
            }
            if (diagnostics_.full()) throw GiveUp{};
            attempt([&] { (this->*one)(into); });
        }
        const bool any = at_ != begin;
        advance();
        return any;
    }

    void interface(Declarations& into, const Head& head) {
        InterfaceKind kind = InterfaceKind::plain;
        if (!is("interface")) {
            kind = is("local") ? InterfaceKind::local : InterfaceKind::abstract;
            if (is(next(), "valuetype")) return value_type(into, head);
            if (is_word(next(), "eventtype")) fail_unsupported(quote(next().text));
            advance();
        }
        if (!take("interface")) {
            fail_expected("'interface' after " + quote(tokens_[at_ - 1].text));
        }
        ast::Declaration interface = declaration(head, identifier("the interface's name"));
        if (take(";")) {
            interface.body = ast::ForwardInterface{kind};
            into.push_back(std::move(interface));
            return;
        }
        ast::Interface body;
        body.kind = kind;
        if (take(":")) {
            if (is("public") || is("private")) {
                error("an interface inherits without " + quote(current().text));
                advance();
            }
            body.bases = scoped_names("the name of a base interface");
        }
        expect("{", body.bases.empty() ? "the interface's name" : "the base interfaces");
        nested(body.body, &Parser::interface_member);
        interface.body = std::move(body);
        into.push_back(std::move(interface));
        expect_semicolon("the interface");
    }

    bool begins_no_interface_member() const {
        return is("module") || is("interface") || is("local") || is("abstract") ||
               is("valuetype") || is("custom");
    }

    void interface_member(Declarations& into) {
        const Level level{*this};
        Head head = this->head();
        if (common_definition(into, head)) return;
        if (is(";")) {
            error("there is no declaration here: leave this ';' out");
            return advance();
        }
        if ((is("public") || is("private") || is_word("protected")) && is(next(), ":")) {
            error("all of an interface is public: leave '" + std::string{current().text} +
                  ":' out");
            advance();
            return advance();
        }
        if (begins_no_interface_member()) {
            fail(quote(current().text) + " cannot be declared inside an interface");
        }
        if (is("attribute") || is("readonly")) {
            attribute(into, head);
        } else {
            operation(into, head);
        }
    }

    void attribute(Declarations& into, Head& head) {
        ast::Attribute attribute;
        attribute.readonly = take("readonly");
        if (!take("attribute")) fail_expected("'attribute' after 'readonly'");
        if (is("readonly")) {
            error("write 'readonly attribute'");
            advance();
            attribute.readonly = true;
        }
        add_annotations(head);
        attribute.type = operation_type("an attribute");
        std::vector<ast::Identifier> names;
        do {
            names.push_back(identifier("the attribute's name"));
            reject_array("an attribute");
        } while (take(","));
        attribute_exceptions(attribute, names.size() > 1);
        for (ast::Identifier& name : names) {
            ast::Declaration declared = declaration(head, std::move(name));
            declared.body = attribute;
            into.push_back(std::move(declared));
        }
        expect_semicolon("the attribute");
    }

    void attribute_exceptions(ast::Attribute& attribute, bool several) {
        const Token& word = current();
        if (is("raises")) {
            if (!attribute.readonly) {
                error("an attribute that can be set has 'getraises' and 'setraises'");
            }
            attribute.get_raises = raises();
        } else {
            if (is_word("getraises")) attribute.get_raises = raises();
            if (is_word("setraises")) {
                if (attribute.readonly) error("a readonly attribute is never set");
                attribute.set_raises = raises();
            }
        }
        if (several && &word != &current()) {
            diagnostics_.error(
                word.where, quote(word.text) + " belongs to one attribute: declare each by itself");
        }
    }

    std::vector<ast::ScopedName> raises() {
        const std::string word = quote(current().text);
        advance();
        expect("(", word);
        std::vector<ast::ScopedName> names = scoped_names("the name of an exception");
        expect(")", "the exceptions");
        return names;
    }

    void operation(Declarations& into, Head& head) {
        ast::Operation operation;
        operation.oneway = take("oneway");
        add_annotations(head);
        if (!take("void")) operation.result = operation_type("a result");
        ast::Declaration declared = declaration(head, identifier("the operation's name"));
        if (is(";") || is(",")) {
            fail(
                "expected '(' after the operation's name; an attribute is written "
                "'attribute' before its type");
        }
        expect("(", "the operation's name");
        parameters(operation);
        if (is("const")) {
            error("operations of IDL are never 'const'");
            advance();
        }
        if (is("raises")) operation.raises = raises();
        if (take("context")) operation.context = contexts();
        declared.body = std::move(operation);
        into.push_back(std::move(declared));
        if (is("{")) {
            error("IDL declares operations and has no code for them: write ';' here");
            skip_block();
            take(";");
            return;
        }
        expect_semicolon("the operation");
    }

    void parameters(ast::Operation& operation) {
        if (is("void") && is(next(), ")")) {
            error("an operation without parameters has nothing in its parentheses");
            advance();
        }
        if (take(")")) return;
        do {
            operation.parameters.push_back(parameter());
        } while (take(",") || take_wrong_comma());
        if (!take(")")) fail_expected("',' or ')' after the parameter");
    }

    /// A ; between parameters, which would end the operation.
    bool take_wrong_comma() {
        if (!is(";") || !(is(next(), "in") || is(next(), "out") || is(next(), "inout"))) {
            return false;
        }
        error("between parameters there is ',', not ';'");
        advance();
        return true;
    }

    ast::Parameter parameter() {
        ast::Parameter parameter;
        parameter.annotations = annotations();
        direction(parameter);
        for (ast::Annotation& one : annotations()) parameter.annotations.push_back(std::move(one));
        if (is("const")) {
            error("IDL has no 'const' parameters: 'in' says it");
            advance();
        }
        parameter.type = operation_type("a parameter");
        parameter.name = identifier("the parameter's name");
        reject_array("a parameter");
        if (is("=")) {
            error("parameters have no default values");
            advance();
            expression();
        }
        return parameter;
    }

    void direction(ast::Parameter& parameter) {
        if (take("in") || is("const")) return;
        if (take("out")) {
            parameter.direction = ast::Direction::out;
        } else if (take("inout")) {
            parameter.direction = ast::Direction::inout;
        } else {
            if (!is_any_word(current()) && !is("::")) {
                fail_expected("'in', 'out' or 'inout' before the parameter's type");
            }
            error("expected 'in', 'out' or 'inout' before the parameter's type, not " +
                  quote(current().text));
        }
    }

    void reject_array(std::string_view of) {
        if (!is("[")) return;
        error("the type of " + std::string{of} +
              " needs a name: declare the array by 'typedef' before");
        dimensions();
    }

    std::vector<std::string> contexts() {
        std::vector<std::string> names;
        expect("(", "'context'");
        do {
            if (current().kind != TokenKind::string) fail_expected("a context's name in quotes");
            if (!is_context(current().value)) {
                error(
                    "a context's name is letters, digits, '.' and '_' after a letter, and may "
                    "end in '*'");
            }
            names.push_back(current().value);
            advance();
        } while (take(","));
        expect(")", "the contexts");
        return names;
    }

    static bool is_context(std::string_view name) {
        if (name.ends_with('*')) name.remove_suffix(1);
        const auto is_letter = [](char c) {
            return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        };
        return !name.empty() && is_letter(name.front()) &&
               std::all_of(name.begin(), name.end(), [&](char c) {
                   return is_letter(c) || (c >= '0' && c <= '9') || c == '.' || c == '_';
               });
    }

    std::size_t directives_read_ = 0;  ///< of that many tokens
};

}  // namespace

ast::File parse_file(const std::vector<Token>& tokens, Diagnostics& diagnostics) {
    return Parser{tokens, diagnostics}.run();
}

}  // namespace canorb::idlc::parse
