#pragma once

/// Random values of all types of types.idl, found by argument-dependent lookup.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "canorb/orb.hpp"
#include "types.hpp"

namespace canorb::test {

/// The source of all of them, and how deep they are nested so far.
struct Random {
    explicit Random(std::uint64_t seed) : engine(seed) {}

    std::uint64_t bits() { return engine(); }
    /// 0 to count - 1.
    std::size_t below(std::size_t count) { return static_cast<std::size_t>(bits() % count); }
    bool one_in(std::size_t count) { return below(count) == 0; }

    std::mt19937_64 engine;
    unsigned levels = 0;
};

template <typename T>
T random_value(Random& random) {
    T value{};
    randomize(value, random);
    return value;
}

/// A few of the values are the lowest and highest, and half of the others are small.
template <typename T>
    requires std::is_integral_v<T>
void randomize(T& value, Random& random) {
    value = static_cast<T>(random.bits() >> random.below(64));
    if (random.one_in(2)) value = static_cast<T>(~static_cast<std::uint64_t>(value));
    if (random.one_in(10)) value = std::numeric_limits<T>::max();
    if (random.one_in(10)) value = std::numeric_limits<T>::min();
}
inline void randomize(bool& value, Random& random) {
    value = random.one_in(2);
}

/// Any but those that do not equal themselves.
template <typename T>
    requires std::is_floating_point_v<T>
void randomize(T& value, Random& random) {
    using Limits = std::numeric_limits<T>;
    const T mantissa = static_cast<T>(static_cast<std::int64_t>(random.bits()));
    const int exponents = Limits::max_exponent - Limits::min_exponent;
    const int exponent =
        static_cast<int>(random.below(static_cast<std::size_t>(exponents))) - exponents / 2;
    value = std::ldexp(mantissa, exponent);
    constexpr T specials[] = {
        T{0}, T{1}, Limits::max(), Limits::min(), Limits::denorm_min(), Limits::infinity()};
    if (random.one_in(3)) value = specials[random.below(std::size(specials))];
    if (random.one_in(2)) value = -value;
}

template <std::size_t D, std::size_t S>
void randomize(Fixed<D, S>& value, Random& random) {
    std::string text = random.one_in(2) ? "-" : "";
    const std::size_t zeros = random.below(D + 1);
    for (std::size_t i = 0; i < D; ++i) {
        if (i == D - S) text += '.';
        text += i < zeros ? '0' : static_cast<char>('0' + random.below(10));
    }
    value = Fixed<D, S>{text};
}

/// Texts up to `longest`, mostly short.
template <typename Text>
Text random_text(std::size_t longest, Random& random) {
    using Unit = typename Text::value_type;
    Text text(random.below((random.one_in(8) ? longest : std::min<std::size_t>(longest, 8)) + 1),
              Unit{'x'});
    for (Unit& unit : text) {
        randomize(unit, random);
        if (unit == Unit{0}) unit = Unit{'0'};
    }
    return text;
}
inline void randomize(std::string& value, Random& random) {
    value = random_text<std::string>(300, random);
}
template <std::size_t N>
void randomize(BoundedString<N>& value, Random& random) {
    value = random_text<std::string>(N, random);
}
/// For wstring<8>, whose type has no bound.
inline void randomize(std::u16string& value, Random& random) {
    value = random_text<std::u16string>(8, random);
}

template <typename T>
    requires std::is_enum_v<T> && Bitmask<T>
void randomize(T& value, Random& random) {
    value = static_cast<T>(random.bits() & bitmask_all<T>);
}
/// An enum that is numbered from 0 says its last, the others all that they have.
constexpr Matrix::T_enum last_of(const Matrix::T_enum*) {
    return Matrix::T_enum::BLUE;
}
constexpr Matrix::T_enum_in_interface last_of(const Matrix::T_enum_in_interface*) {
    return Matrix::T_enum_in_interface::ON;
}
constexpr auto last_of(const Matrix::T_struct_in_struct::Within::Way*) {
    return Matrix::T_struct_in_struct::Within::Way::DOWN;
}
template <typename T>
    requires requires(const T* of) { last_of(of); }
void randomize(T& value, Random& random) {
    const auto last = static_cast<std::size_t>(last_of(static_cast<const T*>(nullptr)));
    value = static_cast<T>(random.below(last + 1));
}
inline void randomize(Matrix::T_sparse_enum& value, Random& random) {
    using enum Matrix::T_sparse_enum;
    value = std::array{LOW, HIGH, TOP}[random.below(3)];
}

/// Nil, an object or a group. It has no type: what it refers to is nobody's.
template <typename T>
    requires std::is_base_of_v<ObjectRef, T>
void randomize(T& value, Random& random) {
    const auto node = static_cast<std::uint8_t>(random.below(31));
    const auto group = static_cast<std::uint8_t>(1 + random.below(31));
    const auto key = static_cast<std::uint8_t>(node << 3);
    const std::array<std::vector<std::uint8_t>, 3> kinds = {{
        {1, 0, 0xFF},
        {1, 0, 0, 0, node, key, 7},
        {1, 0, 0, 1, group},
    }};
    ccdr::Decoder in{kinds[random.below(kinds.size())]};
    decode(in, value);
}

inline void randomize(TypeCode& value, Random& random) {
    const std::array<TypeCode, 6> some = {
        TypeCode{},
        type_code<bool>(),
        type_code<Matrix::T_string_8>(),
        type_code<Matrix::T_map_wstring>(),
        type_code<Matrix::T_recursive_union>(),
        type_code<Matrix::T_union_enum>(),
    };
    value = some[random.below(some.size())];
}

template <typename T>
void set_random(Any& any, Random& random) {
    any <<= random_value<T>(random);
}
inline void randomize(Any& value, Random& random) {
    ++random.levels;
    using Set = void (*)(Any&, Random&);
    constexpr std::array<Set, 9> some = {
        [](Any& any, Random&) { any = Any{}; },
        set_random<bool>,
        set_random<std::string>,
        set_random<std::u16string>,
        set_random<double>,
        set_random<Fixed<5, 2>>,
        set_random<Matrix::T_struct>,
        set_random<Matrix::T_recursive_struct>,
        set_random<Any>,
    };
    some[random.below(random.levels > 5 ? 2 : some.size())](value, random);
    --random.levels;
}

template <typename T>
void randomize(std::vector<T>& value, Random& random) {
    value.clear();
    ++random.levels;
    // No bound of those in types.idl is lower.
    const std::size_t count = random.levels > 5 ? 0 : random.below(3);
    for (std::size_t i = 0; i < count; ++i) value.push_back(random_value<T>(random));
    --random.levels;
}
template <typename T, std::size_t N>
void randomize(BoundedVector<T, N>& value, Random& random) {
    value.clear();
    const std::size_t count = random.below(N + 1);
    for (std::size_t i = 0; i < count; ++i) value.push_back(random_value<T>(random));
}
template <typename T, std::size_t N>
void randomize(std::array<T, N>& value, Random& random) {
    for (T& element : value) randomize(element, random);
}
template <typename K, typename V>
void randomize(std::map<K, V>& value, Random& random) {
    value.clear();
    const std::size_t count = random.below(4);
    for (std::size_t i = 0; i < count; ++i) {
        value.insert_or_assign(random_value<K>(random), random_value<V>(random));
    }
}

template <typename... Members>
void randomize_all(Random& random, Members&... members) {
    (randomize(members, random), ...);
}
inline void randomize(Matrix::T_struct& value, Random& random) {
    randomize_all(random, value.count, value.name, value.colour);
}
inline void randomize(Matrix::T_empty_struct&, Random&) {}
inline void randomize(Matrix::T_octetless_struct&, Random&) {}
inline void randomize(Matrix::T_derived_struct& value, Random& random) {
    randomize(static_cast<Matrix::T_struct&>(value), random);
    randomize(value.weight, random);
}
inline void randomize(Matrix::T_struct_in_struct& value, Random& random) {
    randomize_all(random, value.inner.first, value.inner.direction, value.second);
}
inline void randomize(Matrix::T_union_in_struct::Inside& value, Random& random) {
    randomize_all(random, value.count, value.colour);
}
inline void randomize(Matrix::T_union_in_struct& value, Random& random) {
    using Inside = Matrix::T_union_in_struct::Inside;
    randomize(value.first, random);
    value.second.nested(random_value<Inside>(random));
    if (random.one_in(2)) value.second.several(random_value<std::array<Inside, 2>>(random));
}
inline void randomize(Matrix::T_struct_in_interface& value, Random& random) {
    randomize_all(random, value.now, value.label);
}
inline void randomize(Matrix::T_recursive_struct& value, Random& random) {
    randomize_all(random, value.value, value.below);
}

template <typename Union>
constexpr bool has_third = requires(Union value) { value.three(); };
template <typename Union>
constexpr bool has_none = requires(Union value) { value._default(); };

/// A union whose members are one, two, perhaps three, and perhaps none.
template <typename Union>
    requires requires(Union value) {
        value.one();
        value.two();
    }
void randomize(Union& value, Random& random) {
    ++random.levels;
    switch (random.below(4)) {
        case 0:
            if constexpr (has_none<Union>) {
                value._default();
                break;
            }
            [[fallthrough]];
        case 1:
            if constexpr (has_third<Union>) {
                value.three(random_value<std::decay_t<decltype(value.three())>>(random));
                break;
            }
            [[fallthrough]];
        case 2:
            value.two(random_value<std::decay_t<decltype(value.two())>>(random));
            break;
        default:
            value.one(random_value<std::decay_t<decltype(value.one())>>(random));
            break;
    }
    --random.levels;
}
inline void randomize(Matrix::T_union_in_interface& value, Random& random) {
    value.details(random_value<Matrix::T_struct_in_interface>(random));
    if (random.one_in(2)) value._default();
}

}  // namespace canorb::test
