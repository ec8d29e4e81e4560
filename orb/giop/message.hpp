#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "orb/base/bytes.hpp"
#include "orb/base/ids.hpp"
#include "orb/giop/format.hpp"

namespace canorb::giop {

/// A call: doc/wire/giop.md, "Request".
struct Request {
    RequestId id = 0;
    /// Peer to peer an ObjectKey's value; to a group an InterfaceInfo's group_key(), or 0.
    std::uint16_t object_key = 0;
    OperationId operation = 0;
    Bytes parameters{};  ///< CCDR, not looked at; a view into the message's octets
};

/// The answer to a Request: doc/wire/giop.md, "Reply".
struct Reply {
    RequestId id = 0;
    ReplyStatus status = ReplyStatus::no_exception;
    Bytes body{};  ///< CCDR, not looked at; a view into the message's octets
};

/// "What you sent is not GIOP/CAN 1.0": doc/wire/giop.md, "MessageError".
struct MessageError {};

using Message = std::variant<Request, Reply, MessageError>;

/// The octets of a whole message, header included, told from the first of them: at most
/// max_message. Nothing where the message is malformed (type, version, flag bits, or a
/// message_size that this type cannot have) or `first_frame` has fewer octets than header_size.
[[nodiscard]] std::optional<std::size_t> message_length(Bytes first_frame);

/// A whole message. Nothing where message_length() says nothing or differs from the octets given,
/// or where reply_status is unknown.
[[nodiscard]] std::optional<Message> parse(Bytes message);

/// What the first octets of a Request say, without its parameters: for a Request that is too long
/// to be received and must be refused. Nothing where it is no Request, or malformed, or
/// `first_frame` has fewer octets than request_header_size.
[[nodiscard]] std::optional<Request> parse_request_header(Bytes first_frame);

/// The same for a Reply, of which reply_header_size octets are needed.
[[nodiscard]] std::optional<Reply> parse_reply_header(Bytes first_frame);

/// The most octets of parameters and of body that a message can carry.
inline constexpr std::size_t max_parameter_octets = max_message - request_header_size;
inline constexpr std::size_t max_body_octets = max_message - reply_header_size;

/// Completes a Request in place: `header` is the start of a buffer whose octets behind it, as many
/// as `parameter_octets` (at most max_parameter_octets), are the encoded parameters.
void write_request_header(std::span<std::uint8_t, request_header_size> header, RequestId id,
                          std::uint16_t object_key, OperationId operation,
                          std::size_t parameter_octets);

/// Completes a Reply in place; `body_octets` is at most max_body_octets.
void write_reply_header(std::span<std::uint8_t, reply_header_size> header, RequestId id,
                        ReplyStatus status, std::size_t body_octets);

/// A whole MessageError.
[[nodiscard]] std::array<std::uint8_t, header_size> message_error();

}  // namespace canorb::giop
