#pragma once

#include <type_traits>
#include <utility>

#include "random.hpp"
#include "subject.hpp"
#include "tests/support/soak.hpp"

namespace canorb::test {

/// As which an `in` parameter is passed.
template <typename T>
using Parameter = std::conditional_t<std::is_arithmetic_v<T> || std::is_enum_v<T>, T, const T&>;

/// What the servants' operations do: the result is what `second` was, which becomes `first`.
template <typename T>
T echo(const T& first, T& second, T& third) {
    third = second;
    return std::exchange(second, first);
}

/// Checks the struct that has a type in all roles of data, and the exception.
void check_roles(std::string_view type, Subject& structure, Subject& exception);

/// Checks the struct in which `first` stands next to itself and all types behind it in the list.
void check_row(std::string_view first, Subject& row);

}  // namespace canorb::test
