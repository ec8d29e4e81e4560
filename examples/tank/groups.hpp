#pragma once

#include <canorb/types.hpp>

namespace tank {

/// The groups of tank.idl's interfaces; a lower one wins over a higher one.
inline constexpr canorb::GroupId round_group{1};        ///< Tank::Round
inline constexpr canorb::GroupId actuation_group{2};    ///< Tank::Actuation
inline constexpr canorb::GroupId measurement_group{3};  ///< Tank::Measurement

inline constexpr int default_node_a = 1;
inline constexpr int default_node_b = 2;

}  // namespace tank
