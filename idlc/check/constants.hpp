#pragma once

#include <functional>
#include <optional>

#include "idlc/ast.hpp"
#include "idlc/diagnostics.hpp"
#include "idlc/model.hpp"

namespace canorb::idlc::check {

/// Finds the constant or enumerator that a name in an expression stands for; reports when there
/// is none.
using FindConstant = std::function<std::optional<model::Value>(const ast::ScopedName&)>;

/// Computes `expression` as a value of `type`, a basic type, string or enum. Reports what does not
/// fit, and then gives nothing.
std::optional<model::Value> evaluate(const ast::Expression& expression, const model::Type& type,
                                     const FindConstant& find, Diagnostics& diagnostics);

}  // namespace canorb::idlc::check
