#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// What a correct IDL file means: names resolved, constants computed, operations numbered. The
/// emitters read this and nothing else.
namespace canorb::idlc::model {

struct Definition;

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
    object,    ///< Object, the interface that all others inherit
    string,    ///< of at most `bound` characters
    sequence,  ///< of at most `bound` elements
    array,     ///< of `bound` elements
    named,     ///< an enum, struct, alias or interface
};

struct Type {
    TypeKind kind = TypeKind::int32;
    std::uint32_t bound = 0;              ///< 0: none
    std::shared_ptr<const Type> element;  ///< of a sequence or array
    const Definition* definition = nullptr;
};

/// The type that an alias, or an alias of an alias, stands for.
const Type& resolved(const Type& type);

/// Whether a bounded string or sequence is small enough, 256 octets, to be kept in place, without
/// heap: a string with its NUL, a sequence of scalars or enums.
bool is_inline(const Type& type);

/// Whether it is a basic type or an enum, aliases resolved: what C++ passes by value.
bool is_scalar(const Type& type);

struct Provenance {
    std::string file;  ///< as the preprocessor names it
    std::uint32_t line = 1;
};

struct Module {
    std::vector<const Definition*> definitions;
};

struct EnumeratorValue {
    const Definition* enumeration;
    std::size_t index;

    friend bool operator==(const EnumeratorValue&, const EnumeratorValue&) = default;
};

using Value =
    std::variant<std::int64_t, std::uint64_t, double, char, bool, std::string, EnumeratorValue>;

struct Constant {
    Type type;
    /// std::uint64_t for the unsigned integer types, std::int64_t for the signed.
    Value value;
};

struct Enumerator {
    std::string name;
    std::vector<std::string> comment;
};

struct Enum {
    std::vector<Enumerator> enumerators;
};

struct Member {
    Type type;
    std::string name;
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
    std::vector<const Definition*> raises;
    Provenance provenance;
    std::vector<std::string> comment;
};

/// "start", "_get_ramp", "_set_ramp".
std::string wire_name(const Operation& operation);

/// Whether it may be sent to a group: no result, no out or inout parameter, no raises clause.
bool groupable(const Operation& operation);

/// A declaration of an interface whose definition follows, in this file or not at all.
struct ForwardInterface {
    const Definition* definition = nullptr;  ///< null: not in this file
};

struct Interface {
    std::vector<const Definition*> bases;
    std::vector<const Definition*> definitions;  ///< types and constants declared in it
    std::vector<Operation> operations;           ///< its own, by id
};

struct Definition {
    std::string name;
    const Definition* parent = nullptr;  ///< the module or interface around it; null: none
    std::string repository_id;
    Provenance provenance;
    std::vector<std::string> comment;
    bool in_main_file = false;
    std::variant<Module, Constant, Enum, Struct, Exception, Alias, ForwardInterface, Interface>
        body = Module{};
};

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

/// One compilation. The addresses of the definitions do not change.
struct Model {
    std::string main_file;
    std::vector<std::string> includes;  ///< of the main file, as spelled there
    std::vector<const Definition*> definitions;
    std::vector<std::unique_ptr<Definition>> storage;  ///< all, at any depth
};

/// The operation ids of the main file's interfaces as a table, for people.
std::string operation_table(const Model& model);

}  // namespace canorb::idlc::model
