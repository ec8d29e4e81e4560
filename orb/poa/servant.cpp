#include "orb/poa/servant.hpp"

#include <string>

namespace canorb::poa {

void ServerCall::begin(Outcome outcome) {
    outcome_ = outcome;
    out_ = ccdr::Encoder{reply_buffer_};
}

void ServerCall::end() {
    switch (out_.error()) {
        case ccdr::EncodeError::none:
            return;
        case ccdr::EncodeError::buffer_full:
            return fail(cause::reply_too_long);
        case ccdr::EncodeError::bad_value:
            return fail(cause::bad_result);
    }
}

void ServerCall::fail(const SystemError& error) {
    begin(Outcome::system_exception);
    error_ = error;
}

void dispatch(Servant& servant, ServerCall& call) {
    switch (call.operation()) {
        case is_a_operation: {
            std::string id;
            if (!call.read(id)) return;
            call.reply(id == corba_object_id || servant._interface_info().is_a(id));
            return;
        }
        case non_existent_operation:
            if (call.read()) call.reply(false);
            return;
        case interface_operation:
            if (call.read()) call.reply(servant._interface_info().repository_id);
            return;
        default:
            break;
    }
    const bool to_group = call.is_oneway();
    // What lies above belongs to the ORB, whatever a servant makes of it.
    if (call.operation() <= highest_user_operation) servant._dispatch(call);
    // A oneway operation has no answer; where the servant did not say itself that it is one,
    // only an unknown operation leaves the parameters alone.
    const bool done = call.is_oneway() && (!to_group || call.was_read());
    if (call.outcome() == ServerCall::Outcome::none && !done) {
        call.fail(cause::no_such_operation);
    }
}

}  // namespace canorb::poa
