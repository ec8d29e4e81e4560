#include "idlc/parse/parser.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "idlc/parse/type_parser.hpp"

namespace canorb::idlc::parse {

namespace {

class Parser : public TypeParser {
  public:
    using TypeParser::TypeParser;

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
        annotation.name.parts.push_back({std::string{current().text}, current().where});
        advance();
        if (!take("(")) return annotation;
        if (take(")")) return annotation;
        do {
            if (current().kind == TokenKind::identifier && next().text == "=") {
                fail("named arguments of annotations are not supported yet");
            }
            annotation.arguments.push_back({std::nullopt, expression()});
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

    void enumeration(Declarations& into, const Head& head) {
        advance();
        ast::Declaration declared = declaration(head, identifier("the enum's name"));
        ast::Enum enumeration;
        expect("{", "the enum's name");
        do {
            if (is("@")) fail("annotations of enumerators are not supported yet");
            std::vector<std::string> comment = current().comment;
            enumeration.enumerators.push_back(
                {identifier("the name of an enumerator"), std::move(comment), {}});
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
        ast::Struct structure{};
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
                ast::Member member;
                member.type = type;
                member.name = identifier("the member's name");
                member.comment = comment;
                member.dimensions = dimensions();
                members.push_back(std::move(member));
            } while (take(","));
            expect(";", "the member");
        }
        return members;
    }
};

}  // namespace

ast::File parse_file(const std::vector<Token>& tokens, Diagnostics& diagnostics) {
    return Parser{tokens, diagnostics}.run();
}

}  // namespace canorb::idlc::parse
