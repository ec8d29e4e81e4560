#include "idlc/parse/type_parser.hpp"

#include <string>
#include <utility>

namespace canorb::idlc::parse {

using ast::TypeKind;

namespace {

/// A type of another language, and what IDL has for it.
struct ForeignType {
    std::string_view word;
    std::string_view instead;
    TypeKind kind;
};

constexpr ForeignType foreign_types[] = {
    {"int", "'long' or 'int32'", TypeKind::int32},
    {"integer", "'long' or 'int32'", TypeKind::int32},
    {"uint", "'unsigned long' or 'uint32'", TypeKind::uint32},
    {"size_t", "'unsigned long' or 'uint32'", TypeKind::uint32},
    {"bool", "'boolean'", TypeKind::boolean},
    {"byte", "'octet' or 'uint8'", TypeKind::octet},
    {"int8_t", "'int8'", TypeKind::int8},
    {"uint8_t", "'octet' or 'uint8'", TypeKind::octet},
    {"int16_t", "'short' or 'int16'", TypeKind::int16},
    {"uint16_t", "'unsigned short' or 'uint16'", TypeKind::uint16},
    {"int32_t", "'long' or 'int32'", TypeKind::int32},
    {"uint32_t", "'unsigned long' or 'uint32'", TypeKind::uint32},
    {"int64_t", "'long long' or 'int64'", TypeKind::int64},
    {"uint64_t", "'unsigned long long' or 'uint64'", TypeKind::uint64},
    {"float32", "'float'", TypeKind::float32},
    {"float64", "'double'", TypeKind::float64},
    {"wchar_t", "'wchar'", TypeKind::wide_character},
};

}  // namespace

ast::Type TypeParser::type() {
    const Level level{*this};
    ast::Type type;
    type.where = current().where;
    if (is_name(current()) || is("::")) {
        named_type(type);
    } else if (take("sequence")) {
        sequence(type);
    } else if (take("string")) {
        type.kind = TypeKind::string;
        optional_bound(type);
    } else if (take("wstring")) {
        type.kind = TypeKind::wide_string;
        optional_bound(type);
    } else if (take("fixed")) {
        fixed(type);
    } else {
        type.kind = basic_type();
    }
    reject_pointer_signs();
    if (is("[")) fail("the size of an array stands behind its name");
    return type;
}

ast::Type TypeParser::constant_type() {
    if (!is("fixed") || is(next(), "<")) {
        ast::Type type = this->type();
        if (type.kind == TypeKind::fixed) {
            diagnostics_.error(type.where,
                               "a constant has its digits from its value: write 'fixed' only");
        }
        return type;
    }
    ast::Type type;
    type.kind = TypeKind::fixed;
    type.where = current().where;
    advance();
    return type;
}

ast::Type TypeParser::operation_type(std::string_view of) {
    if (is("void")) {
        fail(std::string{of} + " cannot be void: only an operation returns it");
    }
    ast::Type type = this->type();
    // IDL 4 allows a map without a name here, CORBA none of its own types.
    if (type.kind == TypeKind::sequence || type.kind == TypeKind::fixed) {
        diagnostics_.error(type.where, "the type of " + std::string{of} +
                                           " needs a name: declare it by 'typedef' before");
    }
    return type;
}

void TypeParser::expect_open_angle(std::string_view behind) {
    expect("<", behind);
    ++open_angles_;
}

void TypeParser::close_angle() {
    expect_closing_angle();
    --open_angles_;
}

void TypeParser::optional_bound(ast::Type& type) {
    if (!is("<")) return;
    expect_open_angle("");
    type.bound = template_argument();
    close_angle();
}

void TypeParser::sequence(ast::Type& type) {
    type.kind = TypeKind::sequence;
    expect_open_angle("'sequence'");
    type.elements.push_back(element_type());
    if (take(",")) type.bound = template_argument();
    close_angle();
}

void TypeParser::map(ast::Type& type) {
    type.kind = TypeKind::map;
    advance();
    expect_open_angle("'map'");
    type.elements.push_back(element_type());
    expect(",", "the type of the map's keys");
    type.elements.push_back(element_type());
    if (take(",")) type.bound = template_argument();
    close_angle();
}

void TypeParser::fixed(ast::Type& type) {
    type.kind = TypeKind::fixed;
    expect_open_angle("'fixed'");
    type.bound = template_argument();
    expect(",", "the number of digits");
    type.scale = template_argument();
    close_angle();
}

ast::Type TypeParser::element_type() {
    if (is("@")) {
        diagnostics_.warning(current().where, "annotations of elements are ignored");
        annotations();
    }
    return type();
}

void TypeParser::named_type(ast::Type& type) {
    if (is_word("map") && is(next(), "<")) return map(type);
    if (foreign_type(type)) return;
    check_used_name();
    type.kind = TypeKind::name;
    type.name = scoped_name("the name of a type");
    if (is("<")) {
        fail(quote(to_string(type.name)) + " takes no arguments: a list is 'sequence<...>'");
    }
}

TypeKind TypeParser::basic_type() {
    constexpr std::pair<std::string_view, TypeKind> one_word[] = {
        {"boolean", TypeKind::boolean}, {"char", TypeKind::character},
        {"octet", TypeKind::octet},     {"wchar", TypeKind::wide_character},
        {"float", TypeKind::float32},   {"double", TypeKind::float64},
        {"Object", TypeKind::object},   {"any", TypeKind::any},
    };
    for (const auto& [word, kind] : one_word) {
        if (take(word)) return kind;
    }
    if (take("short")) {
        skip_surplus_int();
        return TypeKind::int16;
    }
    if (take("long")) return long_type();
    if (take("unsigned")) return unsigned_type();
    if (is("struct") || is("union") || is("enum")) {
        fail("declare the " + std::string{current().text} +
             " before, and write its name alone here");
    }
    if (is("valuetype") || is("ValueBase")) fail_unsupported(quote(current().text));
    if (is("void")) fail("only an operation's result can be void");
    fail_expected("a type");
}

TypeKind TypeParser::long_type() {
    if (take("double")) return TypeKind::float128;
    const TypeKind kind = take("long") ? TypeKind::int64 : TypeKind::int32;
    if (is("long")) fail("no type is longer than 'long long'");
    if (is("unsigned")) fail("write 'unsigned' before 'long'");
    skip_surplus_int();
    return kind;
}

TypeKind TypeParser::unsigned_type() {
    if (take("short")) {
        skip_surplus_int();
        return TypeKind::uint16;
    }
    if (is("long") && is(next(), "double")) fail("'long double' has a sign always");
    if (take("long")) {
        return long_type() == TypeKind::int64 ? TypeKind::uint64 : TypeKind::uint32;
    }
    if (is("char")) {
        error("IDL has no 'unsigned char': write 'octet' or 'uint8'");
        advance();
        return TypeKind::octet;
    }
    if (is_word("int")) {
        error("IDL has no 'int': write 'unsigned long' or 'uint32'");
        advance();
        return TypeKind::uint32;
    }
    fail_expected("'short' or 'long' after 'unsigned'");
}

/// The `int` of C's `long int x`.
void TypeParser::skip_surplus_int() {
    if (!is_word("int") || !is_name(next())) return;
    error("IDL has no 'int': leave it out here");
    advance();
}

/// Reports a type of another language and takes it for what IDL has instead. Any of its words may
/// be a name that was declared.
bool TypeParser::foreign_type(ast::Type& type) {
    if (current().escaped || declared_.contains(current().text)) return false;
    if (is_word("std") && is(next(), "::")) {
        error("IDL has no 'std::': leave it out");
        advance();
        advance();
        type = this->type();
        return true;
    }
    if (is(next(), "::")) return false;
    if (is_word("signed") && is_any_word(next())) {
        error("IDL has no 'signed': leave it out, and write 'int8' for a 'signed char'");
        advance();
        type = this->type();
        return true;
    }
    for (const ForeignType& foreign : foreign_types) {
        if (!is_word(foreign.word)) continue;
        error("IDL has no " + quote(foreign.word) + ": write " + std::string{foreign.instead});
        advance();
        type.kind = foreign.kind;
        return true;
    }
    return false;
}

void TypeParser::reject_pointer_signs() {
    if (!is("*") && !is("&")) return;
    error("IDL has no pointers and no references: leave the " + quote(current().text) + " out");
    while (is("*") || is("&")) advance();
}

std::vector<ast::Expression> TypeParser::dimensions() {
    std::vector<ast::Expression> sizes;
    while (take("[")) {
        const Level level{*this};
        if (is("]")) fail("an array has a size: write a number here, or 'sequence<...>' instead");
        sizes.push_back(expression());
        expect("]", "the array's size");
        if (sizes.size() > deepest) fail("nested too deeply");
    }
    return sizes;
}

}  // namespace canorb::idlc::parse
