#include "orb/core/message_tracer.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <variant>

#include "orb/caniop/segmenter.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
#include "orb/giop/message.hpp"
#include "orb/giop/system_exception.hpp"

namespace canorb::core {
namespace {

constexpr std::size_t max_exception_id = 64;

/// Fit for a terminal, whatever a peer sent.
std::string printable(std::string_view text) {
    std::string result{text.substr(0, max_exception_id)};
    std::ranges::replace_if(result, [](char c) { return c <= ' ' || c > '~'; }, '?');
    return result;
}

void read_reply(MessageTrace& trace, const giop::Reply& reply) {
    trace.type = MessageTrace::Type::reply;
    trace.request_id = reply.id;
    trace.status = reply.status;
    ccdr::Decoder in{reply.body};
    if (reply.status == giop::ReplyStatus::user_exception) {
        trace.exception = printable(in.string());
    } else if (reply.status == giop::ReplyStatus::system_exception) {
        giop::decode(in, trace.error);
    }
}

void read_request(MessageTrace& trace, const giop::Request& request) {
    trace.type = MessageTrace::Type::request;
    trace.request_id = request.id;
    trace.operation = request.operation;
    if (std::holds_alternative<NodeId>(trace.to)) {
        trace.object = ObjectKey{request.object_key}.index();
    } else {
        trace.interface_key = request.object_key;
    }
}

MessageTrace between(caniop::Identifier identifier, MessageTrace::Direction direction) {
    MessageTrace trace;
    trace.direction = direction;
    trace.from = NodeId{identifier.sender};
    if (identifier.peer_to_peer) {
        trace.to = NodeId{identifier.receiver};
    } else {
        trace.to = GroupId{identifier.receiver};
    }
    return trace;
}

/// A whole message, which was well formed but perhaps for its reply status.
void read(MessageTrace& trace, Bytes message) {
    trace.octets = message.size();
    trace.frames = caniop::frame_count(message.size());
    const auto parsed = giop::parse(message);
    if (!parsed) {
        trace.type = MessageTrace::Type::reply;
        trace.request_id = read_be16(message.data() + giop::request_id_offset);
    } else if (const auto* request = std::get_if<giop::Request>(&*parsed)) {
        read_request(trace, *request);
    } else if (const auto* reply = std::get_if<giop::Reply>(&*parsed)) {
        read_reply(trace, *reply);
    } else {
        trace.type = MessageTrace::Type::message_error;
    }
}

MessageTrace local(NodeId node) {
    MessageTrace trace;
    trace.direction = MessageTrace::Direction::local;
    trace.from = node;
    trace.to = node;
    return trace;
}

MessageTrace::Fate fate(caniop::MessageOutcome outcome) {
    switch (outcome) {
        case caniop::MessageOutcome::sent:
            return MessageTrace::Fate::done;
        case caniop::MessageOutcome::expired:
            return MessageTrace::Fate::expired;
        case caniop::MessageOutcome::stopped:
            return MessageTrace::Fate::stopped;
        case caniop::MessageOutcome::failed:
            break;
    }
    return MessageTrace::Fate::failed;
}

}  // namespace

void MessageTracer::turn(bool on) {
    if (on == this->on()) return;
    if (on) {
        traces_.emplace(capacity);
        pending_.reserve(max_queued_messages_);
    } else {
        traces_.reset();
        pending_ = {};
    }
}

void MessageTracer::record(MessageTrace trace) {
    if (traces_->full()) {
        counters_.add(Counter::traces_lost);
        return;
    }
    trace.time = now_;
    traces_->push(std::move(trace));
}

void MessageTracer::queued(caniop::MessageHandle handle, caniop::Identifier to, Bytes message) {
    MessageTrace trace = between(to, MessageTrace::Direction::out);
    read(trace, message);
    pending_.push_back({handle, std::move(trace)});
}

void MessageTracer::is_oneway() {
    pending_.back().trace.oneway = true;
}

void MessageTracer::finished(const caniop::Finished& finished) {
    end(finished.handle, fate(finished.outcome));
}

void MessageTracer::withdrawn(caniop::MessageHandle handle) {
    end(handle, MessageTrace::Fate::cancelled);
}

void MessageTracer::end(caniop::MessageHandle handle, MessageTrace::Fate fate) {
    const auto found = std::ranges::find(pending_, handle, &Pending::handle);
    if (found == pending_.end()) return;
    found->trace.fate = fate;
    record(std::move(found->trace));
    pending_.erase(found);
}

void MessageTracer::received(caniop::Identifier from, Bytes message,
                             const InterfaceInfo* interface) {
    MessageTrace trace = between(from, MessageTrace::Direction::in);
    read(trace, message);
    if (interface != nullptr) trace.interface = interface->repository_id;
    record(std::move(trace));
}

void MessageTracer::refused(caniop::Identifier from, Bytes first_frame) {
    MessageTrace trace = between(from, MessageTrace::Direction::in);
    trace.fate = MessageTrace::Fate::refused;
    trace.octets = giop::message_length(first_frame).value_or(first_frame.size());
    trace.frames = caniop::frame_count(trace.octets);
    if (const auto request = giop::parse_request_header(first_frame)) {
        read_request(trace, *request);
    } else {
        trace.type = MessageTrace::Type::reply;
        trace.request_id = read_be16(first_frame.data() + giop::request_id_offset);
        if (const auto reply = giop::parse_reply_header(first_frame)) trace.status = reply->status;
    }
    record(std::move(trace));
}

void MessageTracer::malformed(caniop::Identifier from, Bytes first_frame) {
    MessageTrace trace = between(from, MessageTrace::Direction::in);
    trace.type = MessageTrace::Type::malformed;
    trace.octets = first_frame.size();
    trace.frames = 1;
    record(std::move(trace));
}

void MessageTracer::local_request(NodeId node, ObjectIndex object, OperationId operation,
                                  std::size_t octets, bool oneway, const InterfaceInfo* interface) {
    MessageTrace trace = local(node);
    trace.object = object;
    trace.operation = operation;
    trace.octets = octets;
    trace.oneway = oneway;
    if (interface != nullptr) trace.interface = interface->repository_id;
    record(std::move(trace));
}

void MessageTracer::local_reply(NodeId node, giop::ReplyStatus status, Bytes message) {
    MessageTrace trace = local(node);
    read_reply(trace, {0, status, message.subspan(giop::reply_header_size)});
    trace.octets = message.size();
    record(std::move(trace));
}

void MessageTracer::local_failure(NodeId node, const SystemError& error) {
    MessageTrace trace = local(node);
    trace.type = MessageTrace::Type::reply;
    trace.status = giop::ReplyStatus::system_exception;
    trace.error = error;
    std::array<std::uint8_t, giop::max_system_exception_octets> body;
    ccdr::Encoder out{body};
    giop::encode(out, error);
    trace.octets = giop::reply_header_size + out.size();
    record(std::move(trace));
}

}  // namespace canorb::core
