// Engine: what it tells its tracer, when that is on.

#include "orb/core/engine.hpp"
#include "orb/giop/message.hpp"

namespace canorb::core {

const InterfaceInfo* Engine::interface_of(ObjectIndex object) const {
    const poa::Servant* servant = adapter_.find(object);
    return servant == nullptr ? nullptr : &servant->_interface_info();
}

void Engine::trace_local_request(ObjectKey target, OperationId operation, Bytes message,
                                 bool oneway) {
    tracer_.local_request(own_number(), target.index(), operation, message.size(), oneway,
                          interface_of(target.index()));
}

void Engine::trace_received(const caniop::Message& message) {
    const InterfaceInfo* interface = nullptr;
    if (message.from.peer_to_peer) {
        const auto request = giop::parse_request_header(message.octets);
        const ObjectKey key{request ? request->object_key : std::uint16_t{0}};
        if (request && is_own(key)) interface = interface_of(key.index());
    }
    tracer_.received(message.from, message.octets, interface);
}

}  // namespace canorb::core
