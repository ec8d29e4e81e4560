#include "orb/giop/message.hpp"

#include <cassert>

namespace canorb::giop {
namespace {

std::optional<MessageType> message_type(std::uint8_t first_octet) {
    for (const MessageType type :
         {MessageType::request, MessageType::reply, MessageType::message_error}) {
        if (first_octet == type_and_flags(type)) return type;
    }
    return std::nullopt;
}

bool is_possible_length(MessageType type, std::size_t length) {
    switch (type) {
        case MessageType::request:
            return length >= request_header_size;
        case MessageType::reply:
            return length >= reply_header_size;
        case MessageType::message_error:
            break;
    }
    return length == header_size;
}

std::optional<ReplyStatus> reply_status(std::uint8_t octet) {
    if (octet > static_cast<std::uint8_t>(ReplyStatus::system_exception)) return std::nullopt;
    return static_cast<ReplyStatus>(octet);
}

void write_header(std::uint8_t* to, MessageType type, std::size_t length) {
    assert(length <= max_message);
    to[0] = type_and_flags(type);
    write_be16(to + message_size_offset, static_cast<std::uint16_t>(length - header_size));
}

/// Of a Request of at least that many octets, without its parameters.
Request request_header(Bytes octets) {
    return Request{.id = read_be16(octets.data() + request_id_offset),
                   .object_key = read_be16(octets.data() + object_key_offset),
                   .operation = octets[operation_offset]};
}

/// Of a Reply of at least that many octets, without its body; nothing for an unknown status.
std::optional<Reply> reply_header(Bytes octets) {
    const std::optional<ReplyStatus> status = reply_status(octets[reply_status_offset]);
    if (!status) return std::nullopt;
    return Reply{.id = read_be16(octets.data() + request_id_offset), .status = *status};
}

bool is_message_of_type(Bytes octets, MessageType type) {
    return message_length(octets).has_value() && message_type(octets[0]) == type;
}

}  // namespace

std::optional<std::size_t> message_length(Bytes first_frame) {
    if (first_frame.size() < header_size) return std::nullopt;
    const std::optional<MessageType> type = message_type(first_frame[0]);
    const std::size_t length = header_size + read_be16(first_frame.data() + message_size_offset);
    if (!type || !is_possible_length(*type, length)) return std::nullopt;
    return length;
}

std::optional<Request> parse_request_header(Bytes first_frame) {
    if (!is_message_of_type(first_frame, MessageType::request) ||
        first_frame.size() < request_header_size) {
        return std::nullopt;
    }
    return request_header(first_frame);
}

std::optional<Reply> parse_reply_header(Bytes first_frame) {
    if (!is_message_of_type(first_frame, MessageType::reply) ||
        first_frame.size() < reply_header_size) {
        return std::nullopt;
    }
    return reply_header(first_frame);
}

std::optional<Message> parse(Bytes message) {
    const std::optional<std::size_t> length = message_length(message);
    if (!length || *length != message.size()) return std::nullopt;
    switch (*message_type(message[0])) {
        case MessageType::request: {
            Request request = request_header(message);
            request.parameters = message.subspan(request_header_size);
            return request;
        }
        case MessageType::reply: {
            std::optional<Reply> reply = reply_header(message);
            if (!reply) return std::nullopt;
            reply->body = message.subspan(reply_header_size);
            return *reply;
        }
        case MessageType::message_error:
            break;
    }
    return MessageError{};
}

void write_request_header(std::span<std::uint8_t, request_header_size> header, RequestId id,
                          std::uint16_t object_key, OperationId operation,
                          std::size_t parameter_octets) {
    write_header(header.data(), MessageType::request, request_header_size + parameter_octets);
    write_be16(header.data() + request_id_offset, id);
    write_be16(header.data() + object_key_offset, object_key);
    header[operation_offset] = operation;
}

void write_reply_header(std::span<std::uint8_t, reply_header_size> header, RequestId id,
                        ReplyStatus status, std::size_t body_octets) {
    write_header(header.data(), MessageType::reply, reply_header_size + body_octets);
    write_be16(header.data() + request_id_offset, id);
    header[reply_status_offset] = static_cast<std::uint8_t>(status);
}

std::array<std::uint8_t, header_size> message_error() {
    std::array<std::uint8_t, header_size> octets{};
    write_header(octets.data(), MessageType::message_error, header_size);
    return octets;
}

}  // namespace canorb::giop
