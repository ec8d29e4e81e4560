#pragma once

#include <string>
#include <vector>

#include "idlc/emit/names.hpp"
#include "idlc/model.hpp"

/// What the declarations of types consist of, and what comes with each in its namespace.
namespace canorb::idlc::emit {

/// How the generated struct or exception calls its member.
std::string member_name(const model::Definition& definition, const model::Member& member);

/// The context inside of the class of a struct, union or exception.
Context inside(const model::Definition& definition);

/// The context of the definition's codec, with what its functions declare themselves hidden.
Context around_codec(const model::Definition& definition);

/// The types that are declared in place within a struct, union or exception, and an empty line.
std::string nested_declarations(const model::Definitions& definitions, const Names& names);

/// What the member is made equal to where a default value of the C++ type would be wrong; else
/// empty.
std::string initial_value(const model::Member& member, const Names& names, const Context& context);

/// Whether it has a codec and a type code: it contains no local interface, and is none.
bool is_sendable(const model::Definition& definition);

/// The lines with which the codec of a recursive type begins; `coder` is "in" or "out".
std::string nesting(const std::string& coder);

/// The parts, with commas, in as many lines as they need; the lines but the first begin with
/// `margin`. The first has `taken` columns before it.
std::string folded(const std::vector<std::string>& parts, std::size_t taken,
                   const std::string& margin);

// Unions: unions.cpp.

std::string union_declaration(const model::Definition& definition, const Names& names,
                              const std::string& name);
std::string union_codec(const model::Definition& definition, const Names& names);

/// operator<< of an enum, bitmask, struct or exception; a union's is in its class: printing.cpp.
std::string printing(const model::Definition& definition, const Names& names);

/// type_code_of(), where the type can have one: type_codes.cpp.
std::string type_code_function(const model::Definition& definition, const Names& names);

}  // namespace canorb::idlc::emit
