#pragma once

#include "idlc/diagnostics.hpp"
#include "idlc/model.hpp"
#include "idlc/source.hpp"

namespace canorb::idlc {

/// All stages from text to model. The model is only of use when `diagnostics` has no error.
model::Model compile(const Source& source, Diagnostics& diagnostics);

/// Reports what is good IDL, but what no code can be generated for: as errors when that is to be
/// done, else as warnings.
void report_obstacles(const model::Model& model, Severity severity, Diagnostics& diagnostics);

}  // namespace canorb::idlc
