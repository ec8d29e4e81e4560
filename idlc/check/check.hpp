#pragma once

#include "idlc/ast.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/model.hpp"
#include "idlc/source.hpp"

namespace canorb::idlc::check {

/// Checks what the grammar cannot say, and builds the model. The model is only of use when
/// `diagnostics` has no error.
model::Model build_model(const ast::File& file, const Source& source, Diagnostics& diagnostics);

}  // namespace canorb::idlc::check
