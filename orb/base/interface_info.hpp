#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "orb/base/ids.hpp"

namespace canorb {

/// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, not reflected, no final XOR.
constexpr std::uint16_t crc16_ccitt_false(std::string_view text) {
    std::uint32_t crc = 0xFFFF;
    for (const char c : text) {
        crc ^= static_cast<std::uint32_t>(static_cast<std::uint8_t>(c)) << 8;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 0x8000U) != 0 ? (crc << 1) ^ 0x1021U : crc << 1;
        }
        crc &= 0xFFFFU;
    }
    return static_cast<std::uint16_t>(crc);
}

/// An IDL interface as generated code describes it: one constant for each, compared by
/// repository id.
struct InterfaceInfo {
    std::string_view repository_id;                 ///< "IDL:Devices/Motor:1.0"
    std::span<const InterfaceInfo* const> bases{};  ///< direct bases, declaration order
    /// CRC-32 of all that the interface means on the wire (doc/evolution.md); 0: not known, written
    /// by hand.
    std::uint32_t structural_hash = 0;

    /// What a group Request carries as object_key to name this interface: the CRC of the
    /// repository id, 1 where that is 0, because 0 means "unchecked".
    constexpr std::uint16_t group_key() const {
        const std::uint16_t crc = crc16_ccitt_false(repository_id);
        return crc == 0 ? 1 : crc;
    }

    /// Whether it is, or inherits, the interface with this repository id.
    constexpr bool is_a(std::string_view id) const {
        if (repository_id == id) return true;
        for (const InterfaceInfo* base : bases) {
            if (base->is_a(id)) return true;
        }
        return false;
    }

    /// Whether it is, or inherits, an interface with this group key.
    constexpr bool has_group_key(std::uint16_t key) const {
        if (group_key() == key) return true;
        for (const InterfaceInfo* base : bases) {
            if (base->has_group_key(key)) return true;
        }
        return false;
    }
};

/// The repository id that every object answers true for in _is_a.
inline constexpr std::string_view corba_object_id = "IDL:omg.org/CORBA/Object:1.0";

/// One operation as a stub calls it.
struct OperationInfo {
    const InterfaceInfo* declared_in;  ///< the interface that declares it
    OperationId id;
    std::string_view name;  ///< as in the IDL; an attribute's are "_get_x" and "_set_x"
    bool oneway = false;    ///< declared `oneway`: no Reply
    bool groupable =
        false;  ///< no result, no out or inout parameter, no raises: a group may get it
};

}  // namespace canorb
