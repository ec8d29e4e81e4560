#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/ids.hpp"
#include "orb/base/interface_info.hpp"

namespace canorb::console {

struct Definition;

/// The types that CCDR knows; typedefs are resolved.
enum class Kind : std::uint8_t {
    boolean,
    character,
    wide_character,
    uint8,
    int8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64,
    float128,
    string,
    wide_string,
    fixed,
    any,
    type_code,
    object,  ///< a reference, to an interface or to any object
    enumeration,
    bitmask,
    structure,
    choice,  ///< a union
    sequence,
    map,
    array,
    native,  ///< is never on the bus
};

/// An IDL type where it is used.
struct Type {
    Kind kind = Kind::boolean;
    /// As people write it: "unsigned short", "string<8>", "Devices::Samples".
    std::string name{};
    std::uint32_t bound = 0;   ///< of texts, sequences and maps, 0: none; an array's length
    std::uint32_t digits = 0;  ///< of fixed
    std::uint32_t scale = 0;
    std::shared_ptr<const Type> key{};
    std::shared_ptr<const Type> element{};
    /// Of an enum, bitmask, struct or union. It belongs to the Model.
    const Definition* definition = nullptr;
    std::string interface_id{};  ///< the repository id of what an object reference is to
};

struct Member {
    std::string name;
    Type type;
    std::vector<std::int64_t> labels{};  ///< of a union; unsigned ones by their bits
    bool is_default = false;
};

struct Enumerator {
    std::string name;
    std::uint32_t number;
};

struct Flag {
    std::string name;
    unsigned position;
};

/// A type or exception that has a name.
struct Definition {
    std::string name;
    std::string repository_id;
    std::vector<Enumerator> enumerators{};
    std::vector<Flag> flags{};
    unsigned bit_bound = 0;
    std::vector<Member> members{};
    Type discriminator{};
    /// A value of it may contain others of it: each of them counts as a level in CCDR.
    bool is_recursive = false;
};

enum class Direction : std::uint8_t { in, out, inout };

struct Parameter {
    std::string name;
    Direction direction;
    Type type;
};

struct Operation {
    OperationId id;
    std::string name;  ///< of an attribute `_get_x` and `_set_x`
    std::string declared_in;
    std::string declared_in_id;  ///< its repository id
    bool oneway;
    bool groupable;
    std::optional<Type> result;
    std::vector<Parameter> parameters;
    std::vector<std::string> raises;

    /// "float speed(in unsigned short channel) raises (Devices::Fault)".
    std::string signature() const;
    std::size_t arguments() const;  ///< how many a call takes: in and inout parameters
};

struct Interface {
    std::string name;
    std::string repository_id;
    bool is_local = false;
    bool defined = true;
    std::vector<Operation> operations{};

    /// By its name; an attribute `x` also as `_get_x`, which `arguments` 0 asks for, or `_set_x`.
    const Operation* find(std::string_view name, std::size_t arguments) const;
    const Operation* find(OperationId id) const;
};

/// What IDL files declare, read from what `canorb-idlc --emit json` writes (doc/idl-json.md).
class Model {
  public:
    Model() = default;
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;

    /// Adds what one document declares. What is known already, from a file that both include, must
    /// be the same. An error is a sentence for people, in which `source` is what the document is
    /// called; the model is not to be used then.
    [[nodiscard]] std::optional<std::string> add(std::string_view json, const std::string& source);

    /// By scoped name or repository id.
    const Interface* find_interface(std::string_view name_or_id) const;
    const Interface* find_interface(std::uint16_t group_key) const;
    const Definition* find_exception(std::string_view repository_id) const;
    /// A basic type by its keywords, or a type, interface or typedef by its scoped name.
    std::optional<Type> find_type(std::string_view name) const;

    const std::map<std::string, Interface>& interfaces() const { return interfaces_; }
    /// The type that type codes with this repository id mean.
    const Type* find_type_by_id(std::string_view repository_id) const;

  private:
    class Reader;

    std::map<std::string, Interface> interfaces_;
    std::map<std::string, Type> types_;
    std::map<std::string, std::unique_ptr<Definition>> definitions_;
    std::map<std::string, Definition> exceptions_;  ///< by scoped name
    std::map<std::string, std::string> documents_;  ///< each entry as it was read, by scoped name
};

}  // namespace canorb::console
