// Whatever parses as a message is written again as the same octets, and what its first octets say
// agrees with the whole.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <variant>
#include <vector>

#include "orb/giop/message.hpp"
#include "orb/giop/system_exception.hpp"

using canorb::Bytes;
namespace ccdr = canorb::ccdr;
namespace giop = canorb::giop;

namespace {

void require(bool condition) {
    if (!condition) std::abort();
}

bool equal(Bytes a, Bytes b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

void check(const giop::Request& request, Bytes message) {
    std::array<std::uint8_t, giop::request_header_size> header{};
    giop::write_request_header(header, request.id, request.object_key, request.operation,
                               request.parameters.size());
    require(equal(header, message.first(header.size())));
    require(equal(request.parameters, message.subspan(header.size())));
    const auto early = giop::parse_request_header(message.first(header.size()));
    require(early && early->id == request.id && early->object_key == request.object_key &&
            early->operation == request.operation && early->parameters.empty());
}

void check(const giop::Reply& reply, Bytes message) {
    std::array<std::uint8_t, giop::reply_header_size> header{};
    giop::write_reply_header(header, reply.id, reply.status, reply.body.size());
    require(equal(header, message.first(header.size())));
    require(equal(reply.body, message.subspan(header.size())));
    const auto early = giop::parse_reply_header(message.first(header.size()));
    require(early && early->id == reply.id && early->status == reply.status && early->body.empty());

    if (reply.status != giop::ReplyStatus::system_exception) return;
    ccdr::Decoder in{reply.body};
    canorb::SystemError error;
    giop::decode(in, error);
    if (!in.finished()) return;
    std::array<std::uint8_t, giop::max_system_exception_octets> buffer{};
    ccdr::Encoder out{buffer};
    giop::encode(out, error);
    require(out.error() == ccdr::EncodeError::none);
    // An id that canorb does not know is read as UNKNOWN; any other is written as it was read.
    require(error.kind == canorb::SystemErrorKind::unknown || equal(out.octets(), reply.body));
}

void check(const giop::MessageError&, Bytes message) {
    require(equal(giop::message_error(), message));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Bytes octets{data, size};
    const auto length = giop::message_length(octets);
    require(!length || (*length >= giop::header_size && *length <= giop::max_message));
    if (length && *length < size) {
        // The octets behind a message do not change what it says.
        require(!giop::parse(octets));
    }
    const Bytes message = octets.first(std::min(size, length.value_or(size)));
    if (const auto parsed = giop::parse(message)) {
        require(length == message.size());
        std::visit([&](const auto& content) { check(content, message); }, *parsed);
    }
    return 0;
}
