#pragma once

#include <canorb/types.hpp>
#include <string_view>
#include <variant>

#include "variables.hpp"

namespace plant {

/// What people tell a node, as a line of text.

struct SetValue {  ///< "value temperature 80"
    Variable variable;
    float value;
};
struct SetLimit {  ///< "limit temperature 70"
    Variable variable;
    float limit;
};
struct Change {  ///< "raise temperature 5", "lower temperature 5": a sensor's value, a limit
    Variable variable;
    float by;
};
struct Join {  ///< "join 5"
    canorb::GroupId group;
};
struct Leave {  ///< "leave 5"
    canorb::GroupId group;
};
struct Forget {  ///< "forget 12"
    int sensor;
};
struct Quit {};  ///< "quit"

using Command = std::variant<SetValue, SetLimit, Change, Join, Leave, Forget, Quit>;

/// Values and limits are within this, both ways.
inline constexpr float greatest_value = 1000.0F;

/// A variable may be shortened ("t"). Throws std::invalid_argument, which says what is wrong.
Command parse_command(std::string_view line);

/// A group's number, 1 to 31. Throws std::invalid_argument.
canorb::GroupId parse_group(std::string_view text);

}  // namespace plant
