#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "idlc/model.hpp"

namespace canorb::idlc::emit {

/// An IDL identifier as C++ can have it: `class` becomes `_cxx_class`.
std::string identifier(std::string_view idl_name);

/// Where in C++ a name is written; it decides how much of the name must be written.
struct Context {
    enum class Kind { in_namespace, in_stub, in_servant };

    Kind kind = Kind::in_namespace;
    /// The module around, or the interface whose stub or servant class it is in; null: none.
    const model::Definition* around = nullptr;
    /// Parameters and members that would be found first.
    std::vector<std::string> hidden{};
};

/// The context of what stands beside the definition.
Context beside(const model::Definition& definition);
/// The context of what stands in the namespace that the definition is in, at whatever depth.
Context in_namespace_of(const model::Definition& definition);
Context in_stub(const model::Definition& interface);
Context in_servant(const model::Definition& interface);

/// Spells names and types in C++: as short as they are found where they are written.
class Names {
  public:
    explicit Names(const model::Model& model);

    /// The definition's own name, unqualified.
    std::string own(const model::Definition& definition) const;
    std::string spell(const model::Definition& definition, const Context& context) const;
    std::string type(const model::Type& type, const Context& context) const;
    /// "std::string name;" or "long count{};": nothing is left undefined.
    std::string variable(const model::Type& type, std::string_view name,
                         const Context& context) const;
    /// What follows "sendp_" and "sendc_" in the names of an operation's asynchronous functions:
    /// "speed", "get_ramp", with as many "ami_" before it as it takes to be no other name there.
    std::string asynchronous(const model::Operation& operation) const;
    /// As a parameter: by value what is a scalar, else by reference.
    std::string parameter(const model::Parameter& parameter, const Context& context) const;
    /// A value as an expression of the type.
    std::string value(const model::Value& value, const model::Type& type,
                      const Context& context) const;

  private:
    std::string path(const model::Definition* definition) const;
    void name_asynchronous(const model::Definition& interface);
    std::string lookup_in_interface(std::string_view name, const model::Definition& interface,
                                    bool stub) const;
    /// The path of what C++ finds for an unqualified name.
    std::string lookup(std::string_view name, const Context& context) const;

    std::set<std::string, std::less<>> declared_;
    std::set<std::string, std::less<>> operations_;  ///< and their asynchronous functions
    std::map<const model::Operation*, std::string> asynchronous_;
};

/// How `value` of the type is passed to the codec: as it is, or with the bounds that its C++ type
/// does not have.
std::string coded(const model::Type& type, std::string_view value);
/// The same as a type, for what decodes it later; `spelled` is the C++ type.
std::string coded_type(const model::Type& type, const std::string& spelled);

/// "devices.idl:12".
std::string place(const model::Provenance& provenance);

/// The comment lines, each ended.
std::string comment(const std::vector<std::string>& lines);

}  // namespace canorb::idlc::emit
