#include "idlc/parse/data_parser.hpp"

#include <utility>

namespace canorb::idlc::parse {

DataParser::Head DataParser::head() {
    Head head{current().comment, {}};
    add_annotations(head);
    return head;
}

void DataParser::add_annotations(Head& head) {
    while (is("@") && !(is_word(next(), "annotation") && is_name(peek(2)))) {
        for (ast::Annotation& one : annotations()) head.annotations.push_back(std::move(one));
        const std::vector<std::string>& behind = current().comment;
        head.comment.insert(head.comment.end(), behind.begin(), behind.end());
    }
}

ast::Declaration DataParser::declaration(const Head& head, ast::Identifier name) {
    return {std::move(name), head.comment, head.annotations, ast::Module{}};
}

/// Goes behind the declaration that began at `begin`: behind the next ; outside of braces opened
/// since, or to a } that was not.
void DataParser::skip_from(std::size_t begin) {
    int open = 0;
    for (std::size_t i = begin; i < at_; ++i) {
        if (is(tokens_[i], "{")) ++open;
        if (is(tokens_[i], "}") && open > 0) --open;
    }
    while (!at_end()) {
        if (is("}") && open == 0) {
            if (at_ == begin) advance();
            return;
        }
        if (is("{")) ++open;
        const bool closed = is("}") && --open == 0;
        const bool last = is(";") && open == 0;
        advance();
        // Other languages end a definition with its brace.
        if (last || (closed && current().first_on_line && !is(";"))) return;
    }
}

void DataParser::skip_block() {
    const Token& begin = current();
    int open = 0;
    do {
        if (at_end()) fail_unclosed(begin);
        if (is("{")) ++open;
        if (is("}")) --open;
        advance();
    } while (open > 0);
}

void DataParser::fail_unclosed(const Token& open) {
    error("expected '}' before " + (at_end() ? "the end of the file" : quote(current().text)));
    diagnostics_.note(open.where, "to close this '{'");
    goes_on_here_ = true;
    throw GiveUp{};
}

namespace {

/// How many white spaces the token's line begins with.
std::size_t indentation(const Token& token) {
    const char* const text = token.text.data() - token.where.offset;
    std::size_t begin = token.where.offset;
    while (begin > 0 && text[begin - 1] != '\n') --begin;
    std::size_t end = begin;
    while (end < token.where.offset && (text[end] == ' ' || text[end] == '\t')) ++end;
    return end - begin;
}

}  // namespace

bool DataParser::outdented(const Token& open) const {
    return current().first_on_line && indentation(current()) <= indentation(open);
}

bool DataParser::data(Declarations& into, Head& head) {
    if (begins_constructed()) {
        constructed(into, head, Place::alone);
    } else if (is("const")) {
        constant(into, head);
    } else if (is("typedef")) {
        alias(into, head);
    } else if (is("exception")) {
        exception(into, head);
    } else if (is("native")) {
        native(into, head);
    } else if (is("@")) {
        annotation_type(into, head);
    } else {
        return false;
    }
    return true;
}

bool DataParser::begins_constructed() const {
    return is("struct") || is("union") || is("enum") || begins_bitmask();
}

bool DataParser::begins_bitmask() const {
    return is_word("bitmask") && is_name(next()) && is(peek(2), "{");
}

void DataParser::constructed(Declarations& into, const Head& head, Place place) {
    const Level level{*this};
    if (take("struct")) return structure(into, head, place);
    if (take("union")) return union_type(into, head, place);
    if (take("enum")) return enumeration(into, head);
    bitmask(into, head);
}

ast::Type DataParser::type_or_declaration(Declarations& declared) {
    if (!begins_constructed()) return type();
    constructed(declared, {}, Place::in_front);
    ast::Type type;
    type.kind = ast::TypeKind::name;
    type.where = declared.back().name.where;
    type.name.parts.push_back(declared.back().name);
    return type;
}

void DataParser::constant(Declarations& into, const Head& head) {
    advance();
    ast::Constant constant;
    constant.type = constant_type();
    ast::Declaration declared = declaration(head, identifier("the constant's name"));
    if (is("[")) fail("a constant is no array");
    expect("=", "the constant's name");
    constant.value = expression();
    declared.body = std::move(constant);
    into.push_back(std::move(declared));
}

void DataParser::alias(Declarations& into, Head& head) {
    advance();
    add_annotations(head);
    Declarations list;
    ast::Alias alias;
    alias.type = type_or_declaration(list);
    if (!list.empty()) list.back().comment = head.comment;
    do {
        ast::Declaration declared = declaration(head, identifier("the new type's name"));
        alias.dimensions = dimensions();
        declared.body = alias;
        list.push_back(std::move(declared));
    } while (take(","));
    for (ast::Declaration& one : list) into.push_back(std::move(one));
}

void DataParser::native(Declarations& into, const Head& head) {
    advance();
    ast::Declaration declared = declaration(head, identifier("the native type's name"));
    declared.body = ast::Native{};
    into.push_back(std::move(declared));
}

void DataParser::enumeration(Declarations& into, const Head& head) {
    if (is_word("class") && is_name(next())) {
        error("an enum of IDL is no class: leave 'class' out");
        advance();
    }
    ast::Declaration declared = declaration(head, identifier("the enum's name"));
    declared.body = ast::Enum{enumerators("an enumerator", "@value(n)")};
    into.push_back(std::move(declared));
}

void DataParser::bitmask(Declarations& into, const Head& head) {
    advance();
    ast::Declaration declared = declaration(head, identifier("the bitmask's name"));
    declared.body = ast::Bitmask{enumerators("a flag", "@position(n)")};
    into.push_back(std::move(declared));
}

std::vector<ast::Enumerator> DataParser::enumerators(const std::string& one,
                                                     std::string_view annotation) {
    std::vector<ast::Enumerator> list;
    const Token& open = current();
    expect("{", "the name");
    do {
        if (is("}") && !list.empty()) {
            diagnostics_.error(tokens_[at_ - 1].where, "no ',' stands behind the last one");
            break;
        }
        Head head = this->head();
        list.push_back({identifier("the name of " + one), std::move(head.comment),
                        std::move(head.annotations)});
        if (is("=")) {
            error("the value of " + one + " is written " + std::string{annotation} +
                  " before its name");
            advance();
            expression();
        }
    } while (take(","));
    if (!is("}") && outdented(open)) fail_unclosed(open);
    if (!take("}")) fail_expected("',' or '}' after " + one);
    return list;
}

/// C writes `struct S x` where IDL writes `S x`.
void DataParser::reject_reference(Place place, std::string_view kind, const ast::Identifier& name) {
    if (place == Place::alone || (!is_name(current()) && !is("*") && !is("&"))) return;
    diagnostics_.error(name.where, "write " + quote(name.text) + " without '" + std::string{kind} +
                                       "': only its declaration has it");
    throw GiveUp{};
}

void DataParser::structure(Declarations& into, const Head& head, Place place) {
    ast::Declaration declared = declaration(head, identifier("the struct's name"));
    if (place == Place::alone && is(";")) {
        declared.body = ast::ForwardStruct{};
    } else {
        reject_reference(place, "struct", declared.name);
        ast::Struct structure;
        if (take(":")) {
            structure.base = scoped_name("the name of the base struct");
            if (is(",")) fail("a struct has one base at most");
        }
        structure.members = members(structure.base ? "the base struct" : "the struct's name");
        declared.body = std::move(structure);
    }
    into.push_back(std::move(declared));
}

void DataParser::exception(Declarations& into, const Head& head) {
    advance();
    ast::Declaration declared = declaration(head, identifier("the exception's name"));
    if (is(":")) fail("exceptions do not inherit");
    declared.body = ast::Exception{members("the exception's name")};
    into.push_back(std::move(declared));
}

std::vector<ast::Member> DataParser::members(std::string_view behind) {
    std::vector<ast::Member> list;
    const Token& open = current();
    expect("{", behind);
    while (!take("}")) {
        if (at_end() || (begins_no_member() && outdented(open))) fail_unclosed(open);
        if (diagnostics_.full()) throw GiveUp{};
        attempt([&] { member(list); });
    }
    return list;
}

bool DataParser::begins_no_member() const {
    return begins_declaration() && !begins_constructed() && !is("void");
}

void DataParser::member(std::vector<ast::Member>& into) {
    Head head = this->head();
    if (is(";")) fail("there is no member here: leave this ';' out");
    if (begins_no_member()) fail(quote(current().text) + " cannot stand among members");
    ast::Member first;
    first.type = type_or_declaration(first.declared);
    std::vector<ast::Declaration> declared = std::move(first.declared);
    do {
        ast::Member member;
        member.declared = std::exchange(declared, {});
        member.type = first.type;
        Head own = head;
        add_annotations(own);
        member.name = identifier("the member's name");
        member.dimensions = dimensions();
        member.comment = std::move(own.comment);
        member.annotations = std::move(own.annotations);
        if (is("(")) fail("an operation cannot stand among members, only in an interface");
        if (is("=")) {
            error("members have no default values: write @default(value) before the member");
            advance();
            expression();
        }
        into.push_back(std::move(member));
    } while (take(","));
    expect_semicolon("the member");
}

void DataParser::union_type(Declarations& into, const Head& head, Place place) {
    ast::Declaration declared = declaration(head, identifier("the union's name"));
    if (place == Place::alone && is(";")) {
        declared.body = ast::ForwardUnion{};
        into.push_back(std::move(declared));
        return;
    }
    reject_reference(place, "union", declared.name);
    if (is("{")) fail("a union says first what selects its member: 'switch (long)'");
    ast::Union body;
    expect("switch", "the union's name");
    expect("(", "'switch'");
    discriminator(body);
    expect(")", "the discriminator's type");
    const Token& open = current();
    expect("{", "the discriminator's type");
    if (is("}")) error("a union has at least one case");
    while (!take("}")) {
        if (at_end() || (begins_declaration() && outdented(open))) fail_unclosed(open);
        if (diagnostics_.full()) throw GiveUp{};
        attempt([&] { union_case(body.cases); });
    }
    declared.body = std::move(body);
    into.push_back(std::move(declared));
}

void DataParser::discriminator(ast::Union& into) {
    into.discriminator_annotations = annotations();
    into.discriminator = type_or_declaration(into.declared);
}

void DataParser::union_case(std::vector<ast::UnionCase>& into) {
    Head head = this->head();
    ast::UnionCase one;
    while (is("case") || is("default")) {
        ast::UnionLabel label;
        label.where = current().where;
        if (take("case")) {
            label.value = expression();
            if (is(",")) fail("each label of a case is written for itself: 'case 1: case 2:'");
            expect(":", "the label's value");
        } else {
            advance();
            expect(":", "'default'");
        }
        one.labels.push_back(std::move(label));
        const std::vector<std::string>& behind = current().comment;
        head.comment.insert(head.comment.end(), behind.begin(), behind.end());
    }
    if (one.labels.empty()) fail_expected("'case' or 'default'");
    add_annotations(head);
    if (is("}") || is(";")) fail("a case has one member");
    one.member.comment = std::move(head.comment);
    one.member.annotations = std::move(head.annotations);
    one.member.type = type_or_declaration(one.member.declared);
    one.member.name = identifier("the member's name");
    one.member.dimensions = dimensions();
    if (is(",")) fail("a case has one member");
    into.push_back(std::move(one));
    expect_semicolon("the member");
}

void DataParser::annotation_type(Declarations& into, const Head& head) {
    advance();
    advance();
    ast::Declaration declared = declaration(head, identifier("the annotation's name"));
    ast::AnnotationType body;
    const Token& open = current();
    expect("{", "the annotation's name");
    while (!take("}")) {
        if (at_end()) fail_unclosed(open);
        if (diagnostics_.full()) throw GiveUp{};
        attempt([&] { annotation_member(body); });
    }
    declared.body = std::move(body);
    into.push_back(std::move(declared));
}

void DataParser::annotation_member(ast::AnnotationType& into) {
    Head head = this->head();
    if (is("const") || is("typedef") || is("enum") || begins_bitmask()) {
        data(into.declared, head);
        return expect_semicolon("the declaration");
    }
    ast::Member member;
    member.type = constant_type();
    member.name = identifier("the member's name");
    if (take("default")) member.default_value = expression();
    member.comment = std::move(head.comment);
    member.annotations = std::move(head.annotations);
    into.members.push_back(std::move(member));
    expect_semicolon("the member");
}

}  // namespace canorb::idlc::parse
