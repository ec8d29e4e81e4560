#include "orb/core/engine.hpp"

#include <algorithm>

#include "orb/base/minor_codes.hpp"
#include "orb/giop/message.hpp"
#include "orb/giop/system_exception.hpp"

namespace canorb::core {
namespace {

/// Notices beyond those that every queued message can cause at once.
constexpr std::size_t spare_notices = 256;
constexpr std::size_t standard_identifiers = 2048;
constexpr Duration duplicate_notice_interval = std::chrono::seconds{1};

std::span<std::uint8_t, giop::request_header_size> request_header(MutableBytes message) {
    return message.first<giop::request_header_size>();
}

}  // namespace

Engine::Engine(const EngineOptions& options)
    : options_(options),
      reassembler_(options.receive, {giop::header_size, giop::message_length}, counters_),
      queue_(options.transmit),
      calls_(options.max_outstanding_calls),
      incoming_(options.max_incoming_requests),
      notices_(options.transmit.max_messages + spare_notices),
      tracer_(counters_, options.transmit.max_messages),
      next_request_id_(options.first_request_id),
      last_request_ids_(standard_identifiers) {
    held_.reserve(options.max_held_requests);
}

void Engine::set_node(std::optional<NodeId> node) {
    if (node == options_.node) return;
    options_.node = node;
    filters_changed_ = true;
    last_duplicate_notice_.reset();  // it was about the other number
}

bool Engine::join(GroupId group, const mca::Member& member) {
    const std::size_t groups = agent_.groups().size();
    const bool joined = agent_.join(group, member);
    note_groups(groups);
    return joined;
}

void Engine::leave(GroupId group, ObjectIndex index) {
    const std::size_t groups = agent_.groups().size();
    agent_.leave(group, index);
    note_groups(groups);
}

bool Engine::deactivate(ObjectIndex index) {
    const std::size_t groups = agent_.groups().size();
    agent_.leave_all(index);
    note_groups(groups);
    held_may_go_ = true;  // what is held for it is refused
    return adapter_.deactivate(index);
}

void Engine::destroy_poa(poa::PoaId poa) {
    for (ObjectIndex index = first_user_index; index <= last_object_index; ++index) {
        const auto of = adapter_.poa_of(index);
        if (of && adapter_.is_within(*of, poa)) static_cast<void>(deactivate(index));
    }
    adapter_.destroy(poa);
}

bool Engine::set_manager_state(poa::ManagerId manager, PoaManagerState state) {
    held_may_go_ = true;
    return adapter_.set_state(manager, state);
}

// One change only ever adds groups or only takes some away, so their number tells. Filters are not
// touched without need: a controller may miss frames while it takes new ones.
void Engine::note_groups(std::size_t groups_before) {
    if (agent_.groups().size() != groups_before) filters_changed_ = true;
}

// ---- calls out

RequestId Engine::take_request_id() {
    while (calls_.has_request_id(next_request_id_)) ++next_request_id_;
    return next_request_id_++;
}

std::optional<SystemError> Engine::obstacle() const {
    if (!options_.node) return cause::no_node_number;
    if (link_down_) return cause::link_down;
    return std::nullopt;
}

Result<caniop::MessageHandle, SystemError> Engine::enqueue(caniop::Identifier to, Bytes message,
                                                           TimePoint deadline) {
    const auto handle = queue_.enqueue(to, message, deadline);
    if (!handle) return Failure{cause::transmit_queue_full};
    if (tracer_.on()) tracer_.queued(*handle, to, message);
    return *handle;
}

bool Engine::queue_local(IncomingRequest request, Bytes parameters) {
    if (incoming_.full()) return false;
    request.parameters = buffers_.copy_of(parameters);
    incoming_.push(std::move(request));
    return true;
}

Result<CallHandle, SystemError> Engine::call(ObjectKey target, OperationId operation,
                                             MutableBytes message, TimePoint deadline) {
    const bool own = is_own(target);
    if (const auto error = own ? std::nullopt : obstacle()) return Failure{*error};
    if (message.size() > giop::max_message) return Failure{cause::request_too_long};
    OutstandingCalls::Call* call = calls_.open(deadline);
    if (call == nullptr) return Failure{cause::too_many_calls};
    if (own) {
        IncomingRequest request;
        request.answer_to = LocalCaller{call->handle};
        request.object = target.index();
        request.operation = operation;
        if (!queue_local(std::move(request), message.subspan(giop::request_header_size))) {
            calls_.discard(*call);
            return Failure{cause::own_objects_busy};
        }
        if (tracer_.on()) trace_local_request(target, operation, message, false);
        return call->handle;
    }
    call->request_id = take_request_id();
    call->peer = target.node();
    giop::write_request_header(request_header(message), call->request_id, target.value(), operation,
                               message.size() - giop::request_header_size);
    const auto queued =
        enqueue(caniop::Identifier::to_node(target.node(), *options_.node), message, deadline);
    if (!queued) {
        calls_.discard(*call);
        return Failure{queued.error()};
    }
    call->message = *queued;
    return call->handle;
}

Engine::Sent Engine::send(ObjectKey target, OperationId operation, MutableBytes message,
                          TimePoint deadline) {
    if (message.size() > giop::max_message) return Failure{cause::request_too_long};
    if (is_own(target)) {
        IncomingRequest request;
        request.object = target.index();
        request.operation = operation;
        if (!queue_local(std::move(request), message.subspan(giop::request_header_size))) {
            return Failure{cause::own_objects_busy};
        }
        if (tracer_.on()) trace_local_request(target, operation, message, true);
        return std::optional<caniop::MessageHandle>{};
    }
    if (const auto error = obstacle()) return Failure{*error};
    giop::write_request_header(request_header(message), take_request_id(), target.value(),
                               operation, message.size() - giop::request_header_size);
    const auto queued =
        enqueue(caniop::Identifier::to_node(target.node(), *options_.node), message, deadline);
    if (!queued) return Failure{queued.error()};
    if (tracer_.on()) tracer_.is_oneway();
    return std::optional{*queued};
}

Engine::Sent Engine::multicast(GroupId group, std::uint16_t interface_key, OperationId operation,
                               MutableBytes message, TimePoint deadline) {
    if (const auto error = obstacle()) return Failure{*error};
    if (message.size() > giop::max_message) return Failure{cause::request_too_long};
    // Before anything is sent: a call that fails must not have reached some of the members.
    if (agent_.has_members(group) && incoming_.full()) {
        return Failure{cause::own_objects_busy};
    }
    giop::write_request_header(request_header(message), take_request_id(), interface_key, operation,
                               message.size() - giop::request_header_size);
    const auto queued =
        enqueue(caniop::Identifier::to_group(group, *options_.node), message, deadline);
    if (!queued) return Failure{queued.error()};
    if (agent_.has_members(group)) {
        IncomingRequest request;
        request.group = group;
        request.interface_key = interface_key;
        request.operation = operation;
        if (!queue_local(std::move(request), message.subspan(giop::request_header_size))) {
            counters_.add(Counter::group_requests_dropped);
        }
    }
    return std::optional{*queued};
}

// ---- answers

void Engine::answer(const AnswerTo& to, giop::ReplyStatus status, MutableBytes message,
                    TimePoint now) {
    if (message.size() > giop::max_message) {
        refuse(to, cause::reply_too_long, now);
    } else if (const auto* local = std::get_if<LocalCaller>(&to)) {
        if (tracer_.on()) {
            tracer_.set_time(now);
            tracer_.local_reply(own_number(), status, message);
        }
        if (OutstandingCalls::Call* call = calls_.find_waiting(local->call)) {
            const Bytes body = message.subspan(giop::reply_header_size);
            calls_.end(*call, CallAnswer{status, buffers_.copy_of(body)});
        } else {
            drop_reply(calls_.drop_cancelled(local->call));
        }
    } else if (const auto* remote = std::get_if<RemoteCaller>(&to)) {
        giop::write_reply_header(message.first<giop::reply_header_size>(), remote->request_id,
                                 status, message.size() - giop::reply_header_size);
        const bool queued =
            !obstacle() && enqueue(caniop::Identifier::to_node(remote->node, *options_.node),
                                   message, now + options_.answer_lifetime)
                               .ok();
        if (!queued) counters_.add(Counter::answers_dropped);
    }
}

void Engine::refuse(const AnswerTo& to, const SystemError& error, TimePoint now) {
    if (const auto* local = std::get_if<LocalCaller>(&to)) {
        if (tracer_.on()) {
            tracer_.set_time(now);
            tracer_.local_failure(own_number(), error);
        }
        if (OutstandingCalls::Call* call = calls_.find_waiting(local->call)) {
            calls_.end(*call, error);
        } else {
            drop_reply(calls_.drop_cancelled(local->call));
        }
        return;
    }
    std::array<std::uint8_t, giop::reply_header_size + giop::max_system_exception_octets> message;
    ccdr::Encoder body{MutableBytes{message}.subspan(giop::reply_header_size)};
    giop::encode(body, error);
    answer(to, giop::ReplyStatus::system_exception,
           MutableBytes{message}.first(giop::reply_header_size + body.size()), now);
}

// ---- the link

void Engine::on_event(const can::ControllerEvent& event, TimePoint now) {
    tracer_.set_time(now);
    if (const auto* received = std::get_if<can::Received>(&event)) {
        on_frame(*received, now);
    } else if (const auto* result = std::get_if<can::TransmitResult>(&event)) {
        if (result->outcome == can::TransmitOutcome::sent) counters_.add(Counter::frames_sent);
        queue_.on_result(*result, now);
        collect_finished();
    } else if (const auto* change = std::get_if<can::StateChanged>(&event)) {
        on_state(*change, now);
    } else if (const auto* loss = std::get_if<can::FramesLost>(&event)) {
        reassembler_.drop_all();
        if (loss->count == 0) return;
        counters_.add(Counter::frames_lost_by_link, loss->count);
        notify(LinkLostFrames{*loss});
    }
}

void Engine::on_state(const can::StateChanged& change, TimePoint now) {
    link_down_ = change.status.state == can::ControllerState::bus_off ||
                 change.status.state == can::ControllerState::stopped;
    if (link_down_) {
        reassembler_.drop_all();  // what the bus carries meanwhile is lost here
        queue_.fail_all(now);
        collect_finished();
        fail_calls(std::nullopt, cause::link_failed_during_call);
    }
    notify(ControllerChanged{change});
}

void Engine::on_frame(const can::Received& received, TimePoint now) {
    const auto admitted = caniop::admit(received.frame, options_.node, agent_.groups());
    if (const auto* cause = std::get_if<Counter>(&admitted)) {
        counters_.add(*cause);
        if (*cause != Counter::frames_of_duplicate_node) return;
        // One notice tells it; a line for each frame would drown everything else.
        if (!last_duplicate_notice_ || now - *last_duplicate_notice_ >= duplicate_notice_interval) {
            last_duplicate_notice_ = now;
            notify(DuplicateNodeSeen{received.time});
        }
        return;
    }
    counters_.add(Counter::frames_received);
    const caniop::Reception reception = reassembler_.accept(
        std::get<caniop::Identifier>(admitted), received.frame.payload(), received.time);
    if (const auto* message = std::get_if<caniop::Message>(&reception)) {
        on_message(*message, now);
    } else if (const auto* oversize = std::get_if<caniop::Oversize>(&reception)) {
        on_oversize(*oversize, now);
    } else if (const auto* malformed = std::get_if<caniop::Malformed>(&reception)) {
        on_malformed(*malformed, received.time, now);
    }
}

void Engine::on_message(const caniop::Message& message, TimePoint now) {
    const caniop::Identifier from = message.from;
    const NodeId peer{from.sender};
    const auto parsed = giop::parse(message.octets);
    if (tracer_.on()) trace_received(message);
    if (!from.peer_to_peer && !(parsed && std::holds_alternative<giop::Request>(*parsed))) {
        counters_.add(Counter::replies_on_group);
        return;
    }
    if (!parsed) {
        // Its length was right, so it is a Reply whose status is none.
        counters_.add(Counter::malformed_messages);
        const RequestId id = read_be16(message.octets.data() + giop::request_id_offset);
        if (auto* call = calls_.find_waiting(peer, id)) {
            calls_.end(*call, cause::bad_reply);
        } else if (calls_.drop_cancelled(peer, id)) {
            drop_reply(true);
        }
    } else if (const auto* request = std::get_if<giop::Request>(&*parsed)) {
        if (is_duplicate(from, request->id)) return;
        if (from.peer_to_peer) {
            on_request(from, *request, now);
        } else {
            on_group_request(from, *request);
        }
    } else if (const auto* reply = std::get_if<giop::Reply>(&*parsed)) {
        on_reply(peer, *reply);
    } else {
        on_message_error(peer);
    }
}

bool Engine::is_duplicate(caniop::Identifier from, RequestId id) {
    std::optional<RequestId>& last = last_request_ids_[from.can_id()];
    if (last == id) {
        counters_.add(Counter::duplicate_requests);
        return true;
    }
    last = id;
    return false;
}

void Engine::on_group_request(caniop::Identifier from, const giop::Request& request) {
    IncomingRequest incoming;
    incoming.group = GroupId{from.receiver};
    incoming.interface_key = request.object_key;
    incoming.operation = request.operation;
    if (!queue_local(std::move(incoming), request.parameters)) {
        counters_.add(Counter::group_requests_dropped);
    }
}

void Engine::on_request(caniop::Identifier from, const giop::Request& request, TimePoint now) {
    const ObjectKey key{request.object_key};
    const RemoteCaller caller{NodeId{from.sender}, request.id};
    IncomingRequest incoming;
    incoming.answer_to = caller;
    incoming.object = key.index();
    incoming.operation = request.operation;
    if (!is_own(key)) {
        counters_.add(Counter::requests_refused);
        refuse(caller, cause::object_of_another_node, now);
    } else if (!queue_local(std::move(incoming), request.parameters)) {
        counters_.add(Counter::requests_refused);
        refuse(caller, cause::server_busy, now);
    }
}

void Engine::on_reply(NodeId peer, const giop::Reply& reply) {
    OutstandingCalls::Call* call = calls_.find_waiting(peer, reply.id);
    if (call == nullptr) {
        drop_reply(calls_.drop_cancelled(peer, reply.id));
        return;
    }
    if (reply.status == giop::ReplyStatus::system_exception) {
        ccdr::Decoder in{reply.body};
        SystemError error;
        giop::decode(in, error);
        if (!in.finished()) error = cause::bad_reply;
        calls_.end(*call, error);
    } else {
        calls_.end(*call, CallAnswer{reply.status, buffers_.copy_of(reply.body)});
    }
}

void Engine::on_message_error(NodeId peer) {
    counters_.add(Counter::message_errors_received);
    fail_calls(peer, cause::peer_sent_message_error);
}

void Engine::on_oversize(const caniop::Oversize& message, TimePoint now) {
    if (tracer_.on()) tracer_.refused(message.from, message.first_frame);
    const NodeId peer{message.from.sender};
    if (!message.from.peer_to_peer) return;  // counted by the reassembler, and nobody to tell
    if (const auto request = giop::parse_request_header(message.first_frame)) {
        if (is_duplicate(message.from, request->id)) return;
        counters_.add(Counter::requests_refused);
        refuse(RemoteCaller{peer, request->id}, cause::request_above_limit, now);
    } else {
        // A Reply, whatever its status is. Only a MessageError is shorter, and never too long.
        const RequestId id = read_be16(message.first_frame.data() + giop::request_id_offset);
        if (auto* call = calls_.find_waiting(peer, id)) {
            calls_.end(*call, cause::reply_above_limit);
        } else {
            drop_reply(calls_.drop_cancelled(peer, id));
        }
    }
}

void Engine::on_malformed(const caniop::Malformed& message, TimePoint received, TimePoint now) {
    if (tracer_.on()) tracer_.malformed(message.from, message.first_frame);
    const std::uint8_t first = message.first_frame.front();
    const bool in_answer = first == giop::type_and_flags(giop::MessageType::reply) ||
                           first == giop::type_and_flags(giop::MessageType::message_error);
    if (!message.from.peer_to_peer || in_answer || obstacle()) return;
    std::optional<TimePoint>& last = last_message_error_[message.from.sender];
    if (last && received - *last < options_.receive.inter_frame_timeout) {
        counters_.add(Counter::message_errors_suppressed);
        return;
    }
    last = received;
    const auto octets = giop::message_error();
    const auto to = caniop::Identifier::to_node(NodeId{message.from.sender}, *options_.node);
    const bool queued = enqueue(to, octets, now + options_.answer_lifetime).ok();
    counters_.add(queued ? Counter::message_errors_sent : Counter::answers_dropped);
}

std::optional<caniop::FilterSet> Engine::take_filters(const can::Capabilities& capabilities) {
    if (!filters_changed_) return std::nullopt;
    filters_changed_ = false;
    // With fewer places than groups the two registers are what a controller surely has.
    const std::size_t exact = 1 + agent_.groups().size();
    if (capabilities.filter_list < exact) {
        return caniop::mask_filters(options_.node, agent_.groups());
    }
    caniop::FilterSet filters = caniop::exact_filters(options_.node, agent_.groups());
    if (options_.node && capabilities.filter_list > exact) {
        filters.add(caniop::duplicate_node_filter(*options_.node));
    }
    return filters;
}

// ---- time

void Engine::on_time(TimePoint now) {
    tracer_.set_time(now);
    // First, the messages not begun: their deadline is their call's, which ends with NO.
    queue_.expire(now);
    collect_finished();
    calls_.expire_cancelled(now);
    calls_.for_each_waiting([&](OutstandingCalls::Call& call) {
        if (call.deadline > now) return;
        const bool not_begun = !call.peer && !call.begun;
        counters_.add(Counter::calls_timed_out);
        calls_.end(call, not_begun ? cause::expired_behind_local_calls : cause::deadline_passed);
    });
}

TimePoint Engine::next_deadline() const {
    return std::min(queue_.next_deadline(), calls_.next_deadline());
}

void Engine::fail_calls(std::optional<NodeId> peer, const SystemError& error) {
    calls_.for_each_waiting([&](OutstandingCalls::Call& call) {
        if (call.peer && (!peer || call.peer == peer)) calls_.end(call, error);
    });
}

void Engine::collect_finished() {
    while (const auto finished = queue_.next_finished()) {
        if (tracer_.on()) tracer_.finished(*finished);
        OutstandingCalls::Call* call = calls_.find_waiting(finished->handle);
        switch (finished->outcome) {
            case caniop::MessageOutcome::sent:
                counters_.add(Counter::messages_sent);
                if (call != nullptr) call->message.reset();
                notify(MessageSent{finished->handle});
                continue;
            case caniop::MessageOutcome::expired:
                counters_.add(Counter::messages_expired);
                if (call != nullptr) {
                    counters_.add(Counter::calls_timed_out);
                    calls_.end(*call, cause::expired_in_queue);
                }
                break;
            case caniop::MessageOutcome::stopped:
                counters_.add(Counter::messages_stopped);
                if (call != nullptr) calls_.end(*call, cause::sending_stopped);
                break;
            case caniop::MessageOutcome::failed:
                counters_.add(Counter::messages_failed);
                if (call != nullptr) {
                    calls_.end(*call, finished->begun ? cause::link_failed_during_call
                                                      : cause::link_failed_before_sending);
                }
                break;
        }
        notify(MessageDropped{finished->handle});
    }
}

void Engine::notify(Notice notice) {
    if (notices_.full()) {
        counters_.add(Counter::notices_lost);
        return;
    }
    notices_.push(std::move(notice));
}

}  // namespace canorb::core
