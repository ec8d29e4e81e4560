#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "idlc/source.hpp"

/// What the parser read, as written: names not resolved, constants not computed.
namespace canorb::idlc::ast {

struct Identifier {
    std::string text;
    Location where;
};

struct ScopedName {
    bool global = false;  ///< begins with ::
    std::vector<Identifier> parts;

    Location where() const { return parts.empty() ? Location{} : parts.front().where; }
};

/// "A::B", "::A".
std::string to_string(const ScopedName& name);

struct StringLiteral {
    std::string value;
};

using Literal = std::variant<std::uint64_t, double, char, StringLiteral, bool>;

enum class Operator : std::uint8_t {
    literal,
    name,
    plus,  // one operand up to here
    negate,
    complement,
    bit_or,  // two operands from here on
    bit_xor,
    bit_and,
    shift_left,
    shift_right,
    add,
    subtract,
    multiply,
    divide,
    modulo,
};

struct Expression {
    Operator op = Operator::literal;
    Location where;
    Literal literal;
    ScopedName name;
    std::vector<Expression> operands;
};

enum class TypeKind : std::uint8_t {
    boolean,
    character,
    octet,
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64,
    object,
    string,
    sequence,
    name,
};

struct Type {
    TypeKind kind = TypeKind::int32;
    Location where;
    ScopedName name;                  ///< of a TypeKind::name
    std::vector<Type> element;        ///< of a sequence: one
    std::optional<Expression> bound;  ///< of a string or sequence
};

struct Declaration;

struct Module {
    std::vector<Declaration> declarations;
};

struct Constant {
    Type type;
    Expression value;
};

struct Enumerator {
    Identifier name;
    std::vector<std::string> comment;
};

struct Enum {
    std::vector<Enumerator> enumerators;
};

struct Member {
    Type type;
    Identifier name;
    std::vector<Expression> dimensions;  ///< of an array
    std::vector<std::string> comment;
};

struct Struct {
    std::vector<Member> members;
};

struct Exception {
    std::vector<Member> members;
};

struct Alias {
    Type type;
    std::vector<Expression> dimensions;
};

struct ForwardInterface {};

struct Interface {
    std::vector<ScopedName> bases;
    std::vector<Declaration> body;
};

struct Attribute {
    bool readonly = false;
    Type type;
    std::vector<ScopedName> get_raises;
    std::vector<ScopedName> set_raises;
};

enum class Direction : std::uint8_t { in, out, inout };

struct Parameter {
    Direction direction = Direction::in;
    Type type;
    Identifier name;
};

struct Operation {
    bool oneway = false;
    std::optional<Type> result;  ///< nothing: void
    std::vector<Parameter> parameters;
    std::vector<ScopedName> raises;
};

struct Annotation {
    Identifier name;
    std::vector<Expression> arguments;
};

/// One name: a typedef of two names is two declarations.
struct Declaration {
    Identifier name;
    std::vector<std::string> comment;
    std::vector<Annotation> annotations;
    std::variant<Module, Constant, Enum, Struct, Exception, Alias, ForwardInterface, Interface,
                 Attribute, Operation>
        body;
};

struct File {
    std::vector<Declaration> declarations;
};

/// The tree as text, one declaration a line, indented; for tests and people.
std::string dump(const File& file);

}  // namespace canorb::idlc::ast
