#pragma once

#include <vector>

#include "idlc/model.hpp"

namespace canorb::idlc::emit {

/// One definition in its turn, or, with `declare_only`, a mere declaration of it whose definition
/// comes in a later step.
struct Step {
    const model::Definition* definition;
    bool declare_only = false;
};

/// The order in which C++ can have the definitions of one module: that of the IDL, but structs and
/// exceptions that contain references to interfaces defined behind them come behind those.
std::vector<Step> cpp_order(const std::vector<const model::Definition*>& definitions);

}  // namespace canorb::idlc::emit
