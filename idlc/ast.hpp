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

struct WideCharacterLiteral {
    char16_t value = 0;
};

struct WideStringLiteral {
    std::u16string value;
};

/// "12.50", of 12.50d: digits, with or without a point.
struct FixedLiteral {
    std::string digits;
};

using Literal = std::variant<std::uint64_t, long double, char, bool, StringLiteral,
                             WideCharacterLiteral, WideStringLiteral, FixedLiteral>;

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
    wide_character,
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
    float128,  ///< long double
    fixed,
    any,
    object,
    string,
    wide_string,
    sequence,
    map,
    name,  ///< a user's type, or int8 to uint64 where nobody declared something of that name
};

struct Type {
    TypeKind kind = TypeKind::int32;
    Location where;
    ScopedName name;                  ///< of a TypeKind::name
    std::vector<Type> elements;       ///< of a sequence: one; of a map: the key's and the value's
    std::optional<Expression> bound;  ///< of a string, sequence or map; the digits of a fixed
    std::optional<Expression> scale;  ///< of a fixed
};

struct AnnotationArgument {
    std::optional<Identifier> name;
    Expression value;
};

struct Annotation {
    ScopedName name;
    std::vector<AnnotationArgument> arguments;
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
    std::vector<Annotation> annotations;
};

struct Enum {
    std::vector<Enumerator> enumerators;
};

struct Bitmask {
    std::vector<Enumerator> flags;
};

struct Member {
    std::vector<Declaration> declared;  ///< the type that is declared in place: none or one
    Type type;
    Identifier name;
    std::vector<Expression> dimensions;       ///< of an array
    std::optional<Expression> default_value;  ///< only of an annotation's member
    std::vector<std::string> comment;
    std::vector<Annotation> annotations;
};

struct Struct {
    std::optional<ScopedName> base;
    std::vector<Member> members;
};

struct Exception {
    std::vector<Member> members;
};

struct UnionLabel {
    Location where;
    std::optional<Expression> value;  ///< nothing: default
};

struct UnionCase {
    std::vector<UnionLabel> labels;
    Member member;
};

struct Union {
    std::vector<Declaration> declared;  ///< the enum that is declared in switch ( ): none or one
    Type discriminator;
    std::vector<Annotation> discriminator_annotations;
    std::vector<UnionCase> cases;
};

struct Alias {
    Type type;
    std::vector<Expression> dimensions;
};

struct Native {};

/// A valuetype, of which only its name is kept.
struct ValueType {};

struct ForwardStruct {};
struct ForwardUnion {};

enum class InterfaceKind : std::uint8_t { plain, local, abstract };

struct ForwardInterface {
    InterfaceKind kind = InterfaceKind::plain;
};

struct Interface {
    InterfaceKind kind = InterfaceKind::plain;
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
    std::vector<Annotation> annotations;
};

struct Operation {
    bool oneway = false;
    std::optional<Type> result;  ///< nothing: void
    std::vector<Parameter> parameters;
    std::vector<ScopedName> raises;
    std::vector<std::string> context;
};

/// What names repository ids: #pragma prefix, ID, version, and typeprefix, typeid. Its
/// declaration's own name is empty; `where` of that name is the directive's place.
struct IdDirective {
    enum class Kind : std::uint8_t { prefix, id, version, type_prefix, type_id };

    Kind kind = Kind::prefix;
    ScopedName name;   ///< of what; empty of a #pragma prefix
    std::string text;  ///< the prefix, the id, "2.3"
};

/// @annotation Name { ... }: from then on its use is no unknown annotation.
struct AnnotationType {
    std::vector<Declaration> declared;  ///< enums, constants and typedefs inside of it
    std::vector<Member> members;
};

/// One name: a typedef of two names is two declarations.
struct Declaration {
    Identifier name;
    std::vector<std::string> comment;
    std::vector<Annotation> annotations;
    std::variant<Module, Constant, Enum, Bitmask, Struct, Union, Exception, Alias, Native,
                 ValueType, ForwardStruct, ForwardUnion, ForwardInterface, Interface, Attribute,
                 Operation, IdDirective, AnnotationType>
        body;
};

struct File {
    std::vector<Declaration> declarations;
};

/// The tree as text, one declaration a line, indented; for tests and people.
std::string dump(const File& file);

}  // namespace canorb::idlc::ast
