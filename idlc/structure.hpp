#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "idlc/model.hpp"

namespace canorb::idlc {

/// The word of IDL for a kind of type: "unsigned long", "sequence"; empty for TypeKind::named.
std::string_view keyword(model::TypeKind kind);

/// The word of IDL for what it declares: "struct".
std::string_view kind_of(const model::Definition& definition);

/// The type in one line, aliases resolved: "sequence<string<16>,4>", "array<long,3>" for long[3],
/// "fixed<5,2>"; `name` spells enums, bitmasks, structs, unions and interfaces.
std::string spell(const model::Type& type, std::string (*name)(const model::Definition&));

/// The number that stands on the wire for the label of a union's case.
std::string label_number(const model::Value& label);

/// All that an interface means on the wire, as text of one line for each operation, inherited ones
/// too, and for each type that they use. What does not change it, and what does, is in
/// doc/evolution.md.
std::string structure(const model::Definition& interface);

/// What a Request to a group carries to name the interface: CRC-16/CCITT-FALSE of the repository
/// id, 1 where that is 0 (doc/wire/giop.md).
std::uint16_t group_key(const model::Definition& interface);

/// CRC-32 (IEEE 802.3) of a text.
std::uint32_t crc32(std::string_view text);

/// CRC-32 of structure(), 1 where that is 0: 0 says that the structure is not known.
std::uint32_t structural_hash(const model::Definition& interface);

}  // namespace canorb::idlc
