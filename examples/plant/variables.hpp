#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "plant.hpp"

namespace plant {

using Plant::Variable;

struct VariableInfo {
    std::string_view name;
    std::string_view unit;
    float start;  ///< what a sensor measures at first
    float limit;  ///< what a controller allows at first
    float step;   ///< what one key changes
};

/// In the order of Plant::Variable.
inline constexpr std::array<VariableInfo, 3> variables{{
    {"temperature", "C", 20.0F, 70.0F, 5.0F},
    {"pressure", "bar", 2.0F, 5.0F, 0.5F},
    {"level", "%", 50.0F, 90.0F, 5.0F},
}};

constexpr std::size_t index_of(Variable variable) {
    return static_cast<std::size_t>(variable);
}
constexpr const VariableInfo& info_of(Variable variable) {
    return variables[index_of(variable)];
}

inline constexpr std::array<Variable, variables.size()> all_variables{
    Variable::temperature, Variable::pressure, Variable::level};

/// One number for each variable.
using Values = std::array<float, variables.size()>;

/// The start values, or the limits, of all.
constexpr Values values_of(float VariableInfo::* column) {
    Values values{};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = variables[i].*column;
    return values;
}

}  // namespace plant
