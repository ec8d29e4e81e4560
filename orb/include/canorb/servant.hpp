#pragma once

/// Servants: the objects behind the references. Derive from a generated XServant, or, without
/// generated code, from canorb::Servant itself:
///
///     class Echo final : public canorb::Servant {
///       public:
///         const canorb::InterfaceInfo& _interface_info() const override { return echo_interface; }
///         void _dispatch(canorb::ServerCall& call) override {
///             if (call.operation() == 0)
///             call.reply(canorb::RawOctets{call.remaining_parameters()});
///         }
///     };

#include "canorb/types.hpp"
#include "orb/poa/servant.hpp"

namespace canorb {

using poa::RawOctets;
using poa::Servant;
using poa::ServerCall;

}  // namespace canorb
