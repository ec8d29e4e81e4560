#pragma once

#include <optional>
#include <string>

#include "orb/ccdr/type_code.hpp"
#include "tools/console/model.hpp"

namespace canorb::console {

/// The type code that a canorb::Any has with a value of this type. Nothing where there is none: a
/// type of more than 16 levels.
std::optional<TypeCode> type_code(const Type& type);

/// The type that a type code describes, where it is a basic one, a sequence of such, or
/// one that the model knows by its repository id and that is the same there.
std::optional<Type> find_type(const TypeCode& code, const Model& model);

}  // namespace canorb::console
