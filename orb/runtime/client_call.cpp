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
    : target_(target), operation_(operation), out_(MutableBytes{}), in_(Bytes{}) {
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
    if (request_.empty()) return;
    target_.orb_->message_buffers().give_back(std::move(request_));
    target_.orb_->give_back(std::move(reply_));
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

bool ClientCall::perform() {
    runtime::OrbImpl& orb = *target_.orb_;
    const core::Reference& to = *target_.to_;
    const MutableBytes message =
        MutableBytes{request_}.first(giop::request_header_size + out_.size());
    if (target_.is_group() || operation_.oneway) {
        const auto error =
            target_.is_group()
                ? orb.multicast(to.group, group_key(*operation_.declared_in), operation_.id,
                                message, target_.timeout_, target_.sent_)
                : orb.send(to.key, operation_.id, message, target_.timeout_, target_.sent_);
        if (error) throw_system_exception(*error, description(operation_, to));
        return true;
    }
    core::CallResult result =
        orb.call(to.key, operation_.id, message, target_.timeout_, target_.sent_);
    if (const auto* error = std::get_if<SystemError>(&result)) {
        throw_system_exception(*error, description(operation_, to));
    }
    auto& answer = std::get<core::CallAnswer>(result);
    reply_ = std::move(answer.body);
    in_ = ccdr::Decoder{reply_, orb.decode_context()};
    has_reply_ = true;
    if (answer.status == giop::ReplyStatus::no_exception) return true;
    exception_id_ = in_.string();
    if (!in_.ok()) throw_system_exception(cause::bad_reply, "a user exception without its id");
    return false;
}

void ClientCall::check_read() const {
    if (in_.finished()) return;
    throw_system_exception(cause::bad_reply,
                           description(operation_, *target_.to_) +
                               ": the reply is not the encoding of the declared types");
}

void ClientCall::raise_unknown_user_exception() const {
    throw_system_exception(
        cause::unexpected_user_exception,
        description(operation_, *target_.to_) + " raised " + std::string{exception_id_});
}

}  // namespace canorb
