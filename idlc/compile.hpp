#pragma once

#include "idlc/diagnostics.hpp"
#include "idlc/model.hpp"
#include "idlc/source.hpp"

namespace canorb::idlc {

/// All stages from text to model. The model is only of use when `diagnostics` has no error.
model::Model compile(const Source& source, Diagnostics& diagnostics);

}  // namespace canorb::idlc
