#include "canorb/exceptions.hpp"
#include "canorb/stub.hpp"
#include "orb/giop/message.hpp"
#include "orb/runtime/orb_impl.hpp"

namespace canorb {
namespace {

std::string description(const OperationInfo& operation, const core::Reference& target) {
    std::string text{operation.name};
    if (target.kind == core::Reference::Kind::group) {
        return text + " on group " + std::to_string(target.group.value());
    }
    return text + " on node " + std::to_string(target.key.node().value()) + ", object " +
           std::to_string(target.key.index());
}

/// 0, unchecked, where nobody knows the interface.
std::uint16_t group_key(const InterfaceInfo& interface) {
    return interface.repository_id.empty() ? std::uint16_t{0} : interface.group_key();
}

}  // namespace

ClientCall::ClientCall(const ObjectRef& target, const OperationInfo& operation)
    : target_(target),
      operation_(operation),
      out_(MutableBytes{}),
      reply_(target.orb_.get(), *target.to_, operation) {
    if (target.is_nil()) throw_system_exception(cause::nil_reference, operation.name);
    if (!target.orb_) throw_system_exception(cause::reference_without_orb, operation.name);
    if (target.is_group() && !operation.groupable) {
        throw_system_exception(
            cause::not_for_groups,
            description(operation, *target.to_) +
                ": an operation with a result, an out or inout parameter or a raises "
                "clause cannot be sent to a group");
    }
    request_ = target.orb_->message_buffers().take();
    out_ = ccdr::Encoder{MutableBytes{request_}.subspan(giop::request_header_size)};
}

ClientCall::~ClientCall() {
    if (!request_.empty()) target_.orb_->message_buffers().give_back(std::move(request_));
}

void ClientCall::check_written() const {
    switch (out_.error()) {
        case ccdr::EncodeError::none:
            return;
        case ccdr::EncodeError::buffer_full:
            throw_system_exception(cause::request_too_long,
                                   description(operation_, *target_.to_) +
                                       ": the parameters are longer than a message can be");
        case ccdr::EncodeError::bad_value:
            throw_system_exception(cause::bad_value,
                                   description(operation_, *target_.to_) +
                                       ": a parameter is not a value of its IDL type");
    }
}

MutableBytes ClientCall::message() {
    return MutableBytes{request_}.first(giop::request_header_size + out_.size());
}

void ClientCall::fail(const SystemError& error) const {
    throw_system_exception(error, description(operation_, *target_.to_));
}

bool ClientCall::send_unanswered() {
    if (!target_.is_group() && !operation_.oneway) return false;
    runtime::OrbImpl& orb = *target_.orb_;
    const core::Reference& to = *target_.to_;
    const auto error =
        target_.is_group()
            ? orb.multicast(to.group, group_key(*operation_.declared_in), operation_.id, message(),
                            target_.timeout_, target_.sent_)
            : orb.send(to.key, operation_.id, message(), target_.timeout_, target_.sent_);
    if (error) fail(*error);
    return true;
}

void ClientCall::perform() {
    if (send_unanswered()) return;
    core::CallResult result = target_.orb_->call(target_.to_->key, operation_.id, message(),
                                                 target_.timeout_, target_.sent_);
    reply_.accept(std::move(result));
}

PendingReply ClientCall::send() {
    core::CallHandle call{};
    if (!send_unanswered()) {
        const auto begun = target_.orb_->begin_call(target_.to_->key, operation_.id, message(),
                                                    target_.timeout_, target_.sent_);
        if (!begun) fail(begun.error());
        call = *begun;
    }
    return {target_.orb_, target_.to_, operation_, call};
}

// ---- the Reply

CallReply::~CallReply() {
    if (has_reply_) orb_->give_back(std::move(body_));
}

void CallReply::accept(core::CallResult result) {
    if (const auto* error = std::get_if<SystemError>(&result)) {
        throw_system_exception(*error, description(operation_, to_));
    }
    auto& answer = std::get<core::CallAnswer>(result);
    body_ = std::move(answer.body);
    in_ = ccdr::Decoder{body_, orb_->decode_context()};
    has_reply_ = true;
    if (answer.status == giop::ReplyStatus::no_exception) return;
    is_user_exception_ = true;
    exception_id_ = in_.string();
    if (!in_.ok()) throw_system_exception(cause::bad_reply, "a user exception without its id");
}

void CallReply::check_read() const {
    if (in_.finished()) return;
    throw_system_exception(
        cause::bad_reply,
        description(operation_, to_) + ": the reply is not the encoding of the declared types");
}

void CallReply::raise_unknown() const {
    throw_system_exception(cause::unexpected_user_exception,
                           description(operation_, to_) + " raised " + std::string{exception_id_});
}

}  // namespace canorb
