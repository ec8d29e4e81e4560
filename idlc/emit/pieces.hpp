#pragma once

#include <string>

#include "idlc/emit/names.hpp"
#include "idlc/model.hpp"

/// The parts that a generated file is put together from. Each function gives the text for one
/// definition, and nothing for kinds that it does not concern.
namespace canorb::idlc::emit {

// Header, part 1, types and codec: types.cpp.

/// The enum, struct, exception, alias or constant; without the codec.
std::string type_declaration(const model::Definition& definition, const Names& names);
/// encode() and decode() of the definition and of the types in it, for a namespace.
std::string codec_declaration(const model::Definition& definition, const Names& names);
std::string codec_definition(const model::Definition& definition, const Names& names);

// Parts 2, stubs: stubs.cpp.

std::string stub_declaration(const model::Definition& interface, const Names& names);
std::string operations(const model::Definition& interface, const Names& names);
std::string stub_definition(const model::Definition& interface, const Names& names);

// Part 3, servants: servants.cpp.

std::string servant_declaration(const model::Definition& interface, const Names& names);
std::string servant_definition(const model::Definition& interface, const Names& names);

/// "float speed(std::uint16_t channel)": what stub and servant have in common. `scope` is put
/// before the operation's name.
std::string signature(const model::Operation& operation, const Names& names,
                      const Context& result_context, const Context& parameter_context,
                      const std::string& scope = {});

/// The operation's name among an interface's operation constants: "start", "_get_ramp".
std::string operation_constant(const model::Operation& operation);

/// `wanted`, with an underscore before it where a parameter of the operation has that name.
std::string local_name(const std::string& wanted, const model::Operation& operation);

}  // namespace canorb::idlc::emit
