#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "idlc/source.hpp"

/// What a correct IDL file means: names resolved, constants computed, operations numbered. The
/// emitters read this and nothing else.
namespace canorb::idlc::model {

struct Definition;

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
    fixed,     ///< of `digits` digits, `scale` of them behind the point
    any,
    object,       ///< Object, the interface that all others inherit
    type_code,    ///< CORBA::TypeCode
    string,       ///< of at most `bound` characters
    wide_string,  ///< of at most `bound` UTF-16 code units
    sequence,     ///< of at most `bound` elements
    map,          ///< of at most `bound` entries, from `key` to `element`
    array,        ///< of `bound` elements
    named,        ///< an enum, bitmask, struct, union, alias or interface
};

struct Type {
    TypeKind kind = TypeKind::int32;
    std::uint32_t bound = 0;  ///< 0: none
    std::uint16_t digits = 0;
    std::uint16_t scale = 0;
    std::shared_ptr<const Type> element;  ///< of a sequence, map or array
    std::shared_ptr<const Type> key;      ///< of a map
    const Definition* definition = nullptr;
};

/// The type that an alias, or an alias of an alias, stands for.
const Type& resolved(const Type& type);

/// Whether a bounded string or sequence is small enough, 256 octets, to be kept in place, without
/// heap: a string with its NUL, a sequence of scalars or enums.
bool is_inline(const Type& type);

/// Whether it is a basic type, an enum or a bitmask, aliases resolved: what C++ passes by value.
bool is_scalar(const Type& type);

/// Whether it is or contains a local interface: it cannot be sent.
bool is_local(const Type& type);

struct Provenance {
    std::string file;  ///< as the preprocessor names it
    std::uint32_t line = 1;
};

/// Definitions that stand inside of another: of a module, an interface, and those declared in
/// place within a struct, union or exception.
using Definitions = std::vector<const Definition*>;

/// One opening of a module.
struct Module {
    Definitions definitions;
};

struct EnumeratorValue {
    const Definition* enumeration;
    std::size_t index;

    friend bool operator==(const EnumeratorValue&, const EnumeratorValue&) = default;
};

/// "-12.50" of a constant of type fixed: as many digits behind the point as its type's scale.
struct FixedValue {
    std::string text;

    /// How many digits it has, without a zero before the point.
    std::uint16_t digits() const;
    std::uint16_t scale() const;

    friend bool operator==(const FixedValue&, const FixedValue&) = default;
};

/// std::uint64_t for the unsigned integer types, octet and bitmasks, std::int64_t for the signed.
using Value = std::variant<std::int64_t, std::uint64_t, long double, char, char16_t, bool,
                           std::string, std::u16string, FixedValue, EnumeratorValue>;

struct Constant {
    Type type;
    Value value;
};

struct Enumerator {
    std::string name;
    std::uint32_t number = 0;  ///< what stands for it on the wire: its place, or its @value
    std::vector<std::string> comment;
};

struct Enum {
    std::vector<Enumerator> enumerators;
    std::size_t default_index = 0;  ///< of the @default_literal, or the first
};

struct Flag {
    std::string name;
    std::uint8_t position = 0;
    std::vector<std::string> comment;
};

struct Bitmask {
    std::uint8_t bit_bound = 32;  ///< 1 to 64
    std::vector<Flag> flags;
};

struct Member {
    Type type;
    std::string name;
    std::vector<std::string> comment;
    std::optional<Value> default_value;  ///< of @default
};

struct Struct {
    const Definition* base = nullptr;  ///< the struct that it inherits
    Definitions definitions;
    std::vector<Member> members;  ///< its own
};

struct UnionCase {
    Member member;
    std::vector<Value> labels;  ///< without default
    bool is_default = false;
};

struct Union {
    Type discriminator;
    Definitions definitions;
    std::vector<UnionCase> cases;
    /// A value of the discriminator that no label has, so that it selects the default member or
    /// none; nothing where the labels are all values there are.
    std::optional<Value> unlabelled;
};

struct Exception {
    Definitions definitions;
    std::vector<Member> members;
};

struct Alias {
    Type type;
};

/// A type that is known by name only: nothing is generated for it, and nothing can use it.
struct Unusable {
    std::string_view kind;  ///< "native", "valuetype"
};

enum class Direction : std::uint8_t { in, out, inout };

struct Parameter {
    Direction direction;
    Type type;
    std::string name;
};

enum class OperationKind : std::uint8_t { operation, get, set };

/// An operation, or one of the two of an attribute.
struct Operation {
    OperationKind kind = OperationKind::operation;
    std::string name;  ///< as in the IDL, an attribute's too
    std::uint8_t id = 0;
    bool oneway = false;
    std::optional<Type> result;  ///< nothing: void
    std::vector<Parameter> parameters;
    Definitions raises;
    Provenance provenance;
    std::vector<std::string> comment;
};

/// "start", "_get_ramp", "_set_ramp".
std::string wire_name(const Operation& operation);

/// Whether it may be sent to a group: no result, no out or inout parameter, no raises clause.
bool groupable(const Operation& operation);

/// A declaration of a struct, union or interface whose definition follows, in this file or, of an
/// interface, perhaps not at all.
struct Forward {
    const Definition* definition = nullptr;
};

enum class InterfaceKind : std::uint8_t { plain, local, abstract };

struct Interface {
    InterfaceKind kind = InterfaceKind::plain;
    Definitions bases;
    Definitions definitions;            ///< types and constants declared in it
    std::vector<Operation> operations;  ///< its own, by id
};

struct Definition {
    std::string name;
    /// The module, interface, struct, union or exception around it; null: none.
    const Definition* parent = nullptr;
    std::string repository_id;
    Provenance provenance;
    std::vector<std::string> comment;
    bool in_main_file = false;
    std::variant<Module, Constant, Enum, Bitmask, Struct, Union, Exception, Alias, Unusable,
                 Forward, Interface>
        body = Module{};
};

/// The members of a struct, those that it inherits first.
std::vector<const Member*> all_members(const Struct& structure);
/// The same, or the members of an exception; none of other definitions.
std::vector<const Member*> all_members(const Definition& definition);

/// Whether a value of this struct or union can contain another of the same, through a sequence or
/// map.
bool is_recursive(const Definition& definition);

/// Whether no value of the type takes an octet on the wire: an empty struct, and what consists of
/// such only.
bool takes_no_octets(const Type& type);

/// What is generated for an interface is named after it, with one of these behind.
inline constexpr std::string_view generated_suffixes[] = {"Servant", "Interface", "Bases",
                                                          "_operations"};

/// "Devices::Motor".
std::string scoped_name(const Definition& definition);

/// An operation together with the interface that declares it.
struct InheritedOperation {
    const Definition* interface;
    const Operation* operation;
};

/// The operations of all interfaces that this one inherits, each once, without its own.
std::vector<InheritedOperation> inherited_operations(const Interface& interface);

/// Why there is no C++ for something that is good IDL.
struct Obstacle {
    Location where;
    std::string problem;
};

/// One compilation. The addresses of the definitions do not change.
struct Model {
    std::string main_file;
    std::vector<std::string> includes;  ///< of the main file, as spelled there
    Definitions definitions;
    std::vector<std::unique_ptr<Definition>> storage;  ///< all, at any depth
    std::vector<Obstacle> obstacles;
};

/// The operation ids of the main file's interfaces as a table, for people.
std::string operation_table(const Model& model);

}  // namespace canorb::idlc::model
