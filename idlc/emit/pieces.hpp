#pragma once

#include <string>

#include "idlc/emit/names.hpp"
#include "idlc/emit/order.hpp"
#include "idlc/model.hpp"

/// The parts that a generated file is put together from. Each function gives the text for one
/// definition, and nothing for kinds that it does not concern.
namespace canorb::idlc::emit {

// Header, part 1, types and codec: types.cpp.

/// The enum, struct, exception, alias or constant; without the codec. `name` is what its head
/// calls it: "Link", or "Motor::Link" where it is defined behind the class that it belongs to.
std::string type_declaration(const model::Definition& definition, const Names& names,
                             const std::string& name);
/// encode() and decode() of the definition and of the types in it, for a namespace.
std::string codec_declaration(const model::Definition& definition, const Names& names);
std::string codec_definition(const model::Definition& definition, const Names& names);

// Parts 2, stubs: stubs.cpp.

std::string stub_declaration(const model::Definition& interface, const std::vector<Step>& steps,
                             const Names& names);
std::string operations(const model::Definition& interface, const Names& names);
std::string stub_definition(const model::Definition& interface, const Names& names);

// Part 2, their asynchronous functions: asynchronous.cpp.

/// What the stub's class declares.
std::string asynchronous_members(const model::Definition& interface, const Names& names);
/// Inline, for the end of the header: what nobody uses costs no octets, and all types are there.
std::string asynchronous_definitions(const model::Definition& interface, const Names& names);

/// The types of an interface, in its class: those that must wait for the class are only named.
std::string nested_types(const model::Definition& interface, const std::vector<Step>& steps,
                         const Names& names);

/// The class of a local interface, with its types.
std::string local_declaration(const model::Definition& interface, const std::vector<Step>& steps,
                              const Names& names);

// Part 3, servants: servants.cpp.

std::string servant_declaration(const model::Definition& interface, const Names& names);
std::string servant_definition(const model::Definition& interface, const Names& names);

/// "float speed(std::uint16_t channel)": what stub and servant have in common. `scope` is put
/// before the operation's name.
std::string signature(const model::Operation& operation, const Names& names,
                      const Context& result_context, const Context& parameter_context,
                      const std::string& scope = {});

/// ", raises Failed, Stopped", or nothing.
std::string raised_remark(const model::Operation& operation, const Names& names,
                          const Context& context);

/// The operation's name among an interface's operation constants: "start", "_get_ramp".
std::string operation_constant(const model::Operation& operation);

/// `wanted`, with an underscore before it where a parameter of the operation has that name.
std::string local_name(const std::string& wanted, const model::Operation& operation);

}  // namespace canorb::idlc::emit
