#pragma once

#include <concepts>
#include <cstddef>
#include <map>
#include <string>
#include <type_traits>
#include <utility>

#include "orb/ccdr/bounded.hpp"

namespace canorb::ccdr {

template <typename K, typename V>
void encode(Encoder& out, const std::map<K, V>& value) {
    encode(out, bounded<0>(value));
}

template <typename K, typename V>
void decode(Decoder& in, std::map<K, V>& value) {
    decode(in, bounded<0>(value));
}

/// Whether a map's bounds contain one for its key: only these keys have no bound of their own.
template <typename K>
concept BoundableKey = std::same_as<K, std::string> || std::same_as<K, std::u16string>;

/// Calls `code(coder, key, value)` with the bounds that a map hands on to them.
template <std::size_t... Inner, typename Coder, typename K, typename V>
void code_entry(Coder& coder, K& key, V& value) {
    const auto code = [&coder](auto&& part) {
        if constexpr (std::same_as<Coder, Encoder>) {
            encode(coder, part);
        } else {
            decode(coder, part);
        }
    };
    if constexpr (sizeof...(Inner) == 0) {
        code(key);
        code(value);
    } else if constexpr (BoundableKey<std::remove_const_t<K>>) {
        [&]<std::size_t KeyBound, std::size_t... ValueBounds>(
            std::index_sequence<KeyBound, ValueBounds...>) {
            code(bounded<KeyBound>(key));
            if constexpr (sizeof...(ValueBounds) == 0) {
                code(value);
            } else {
                code(bounded<ValueBounds...>(value));
            }
        }(std::index_sequence<Inner...>{});
    } else {
        code(key);
        code(bounded<Inner...>(value));
    }
}

template <typename K, typename V, std::size_t N, std::size_t... Inner>
void encode(Encoder& out, Bounded<const std::map<K, V>, N, Inner...> map) {
    if (map.value.size() > highest_count(N)) return out.fail();
    out.count(map.value.size());
    for (const auto& [key, value] : map.value) code_entry<Inner...>(out, key, value);
}

/// The entries come in any order. A key that comes twice fails.
template <typename K, typename V, std::size_t N, std::size_t... Inner>
void decode(Decoder& in, Bounded<std::map<K, V>, N, Inner...> map) {
    map.value.clear();
    const std::size_t count = in.count(fewest_octets<K> + fewest_octets<V>, highest_count(N));
    for (std::size_t i = 0; i < count && in.ok(); ++i) {
        K key{};
        V value{};
        code_entry<Inner...>(in, key, value);
        if (!map.value.try_emplace(std::move(key), std::move(value)).second) in.fail();
    }
}

}  // namespace canorb::ccdr
