#pragma once

#include <cstddef>
#include <cstdint>

/// The constants of GIOP/CAN 1.0; the page is doc/wire/giop.md.
namespace canorb::giop {

/// type_and_flags: bits 1..0 of the first octet.
enum class MessageType : std::uint8_t { request = 0, reply = 1, message_error = 2 };

/// reply_status, the sixth octet of a Reply.
enum class ReplyStatus : std::uint8_t {
    no_exception = 0,
    user_exception = 1,
    system_exception = 2,
};

inline constexpr unsigned major_version = 1;  ///< type_and_flags: bits 5..4
inline constexpr unsigned minor_version = 0;  ///< type_and_flags: bits 3..2

/// The first octet of a message of this type: 0x10, 0x11, 0x12.
constexpr std::uint8_t type_and_flags(MessageType type) {
    return static_cast<std::uint8_t>((major_version << 4) | (minor_version << 2) |
                                     static_cast<unsigned>(type));
}

/// type_and_flags and message_size, which every message begins with.
inline constexpr std::size_t header_size = 3;
/// Header, request_id, object_key, operation: what precedes a Request's parameters.
inline constexpr std::size_t request_header_size = header_size + 5;
/// Header, request_id, reply_status: what precedes a Reply's body.
inline constexpr std::size_t reply_header_size = header_size + 3;

/// The longest message, header included: message_size has 16 bits.
inline constexpr std::size_t max_message = header_size + 0xFFFF;

// Where the fields are, in octets from the message's start.
inline constexpr std::size_t message_size_offset = 1;
inline constexpr std::size_t request_id_offset = 3;
inline constexpr std::size_t object_key_offset = 5;
inline constexpr std::size_t operation_offset = 7;
inline constexpr std::size_t reply_status_offset = 5;

}  // namespace canorb::giop
