#pragma once

#include <compare>
#include <cstdint>
#include <optional>

namespace canorb {

/// A node's number on the bus, 0..30 (31 stands for "no number yet" and is never a destination).
class NodeId {
  public:
    static constexpr std::uint8_t highest = 30;

    constexpr explicit NodeId(std::uint8_t value) : value_(value) {}

    /// Nothing when `value` is not 0..30.
    static constexpr std::optional<NodeId> from(long long value) {
        if (value < 0 || value > highest) return std::nullopt;
        return NodeId{static_cast<std::uint8_t>(value)};
    }

    constexpr std::uint8_t value() const { return value_; }
    constexpr bool is_valid() const { return value_ <= highest; }
    constexpr auto operator<=>(const NodeId&) const = default;

  private:
    std::uint8_t value_;
};

/// A group's number, 1..31 for applications. Group 0 is reserved for network management. A lower
/// number wins arbitration over a higher one, and every group over every peer-to-peer message.
class GroupId {
  public:
    static constexpr std::uint8_t highest = 31;

    constexpr explicit GroupId(std::uint8_t value) : value_(value) {}

    /// Nothing when `value` is not 1..31.
    static constexpr std::optional<GroupId> from(long long value) {
        if (value < 1 || value > highest) return std::nullopt;
        return GroupId{static_cast<std::uint8_t>(value)};
    }

    constexpr std::uint8_t value() const { return value_; }
    /// Whether an application may use it: 1..31.
    constexpr bool is_valid() const { return value_ >= 1 && value_ <= highest; }
    constexpr auto operator<=>(const GroupId&) const = default;

  private:
    std::uint8_t value_;
};

/// An object's number within its node, 0..2047. 0 is the node's management object, 1..1023 are
/// numbers that users choose, 1024..2047 numbers that the ORB hands out.
using ObjectIndex = std::uint16_t;

inline constexpr ObjectIndex management_object_index = 0;
inline constexpr ObjectIndex first_user_index = 1;
inline constexpr ObjectIndex last_user_index = 1023;
inline constexpr ObjectIndex first_system_index = 1024;
inline constexpr ObjectIndex last_object_index = 2047;

/// The object_key of a peer-to-peer Request: bits 15..11 node, bits 10..0 object index.
class ObjectKey {
  public:
    constexpr explicit ObjectKey(std::uint16_t value) : value_(value) {}
    constexpr ObjectKey(NodeId node, ObjectIndex index)
        : value_(static_cast<std::uint16_t>((node.value() << 11) | (index & last_object_index))) {}

    constexpr std::uint16_t value() const { return value_; }
    constexpr NodeId node() const { return NodeId{static_cast<std::uint8_t>(value_ >> 11)}; }
    constexpr ObjectIndex index() const { return value_ & last_object_index; }
    constexpr auto operator<=>(const ObjectKey&) const = default;

  private:
    std::uint16_t value_;
};

/// An operation's number within its interface, assigned by the IDL compiler from 0. 0xF8..0xFF
/// are the ORB's own.
using OperationId = std::uint8_t;

inline constexpr OperationId highest_user_operation = 0xF7;
inline constexpr OperationId interface_operation = 0xFD;     ///< string _interface()
inline constexpr OperationId non_existent_operation = 0xFE;  ///< boolean _non_existent()
inline constexpr OperationId is_a_operation = 0xFF;          ///< boolean _is_a(in string id)

/// Pairs a Reply with its Request; one counter per ORB.
using RequestId = std::uint16_t;

}  // namespace canorb
