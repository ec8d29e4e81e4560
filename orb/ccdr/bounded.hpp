#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iosfwd>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"

namespace canorb {

/// IDL's `string<N>` without a heap: a text of at most N octets, and the NUL behind it.
///
///     canorb::BoundedString<16> name = "pump-3";
///     if (name == "pump-3") std::puts(name.c_str());
///
/// A longer text is cut after N octets, and the string remembers that it is overlong until it
/// gets a new text. To send an overlong string is BAD_PARAM, so half a text is never taken for a
/// whole one, and what assign() says may be ignored.
template <std::size_t N>
class BoundedString {
    static_assert(N >= 1 && N <= 0xFFFF, "a bound is 1 or more, and no message holds 64 Ki octets");

  public:
    constexpr BoundedString() = default;

    /// From a text of any kind: std::string_view, std::string, a literal.
    template <typename Text>
        requires std::convertible_to<const Text&, std::string_view>
    constexpr BoundedString(const Text& text) {  // NOLINT: implicit, as std::string is
        assign(text);
    }

    /// From another bound; it stays overlong if it was.
    template <std::size_t M>
        requires(M != N)
    constexpr BoundedString(const BoundedString<M>& other) {  // NOLINT: implicit
        assign(other.view());
        overlong_ = overlong_ || other.is_overlong();
    }

    /// False: the text is longer than N octets and the string is now overlong.
    constexpr bool assign(std::string_view text) {
        const std::string_view kept = text.substr(0, N);
        std::copy(kept.begin(), kept.end(), text_.begin());
        size_ = static_cast<std::uint16_t>(kept.size());
        text_[size_] = '\0';
        overlong_ = text.size() > N;
        return !overlong_;
    }

    constexpr void clear() { assign({}); }

    /// Whether it holds only the beginning of what it was given.
    constexpr bool is_overlong() const { return overlong_; }

    constexpr std::string_view view() const { return {text_.data(), size_}; }
    constexpr operator std::string_view() const { return view(); }  // NOLINT: implicit
    constexpr const char* c_str() const { return text_.data(); }
    constexpr const char* data() const { return text_.data(); }
    constexpr std::size_t size() const { return size_; }
    constexpr bool empty() const { return size_ == 0; }
    static constexpr std::size_t capacity() { return N; }

    constexpr char operator[](std::size_t index) const { return text_[index]; }
    constexpr const char* begin() const { return data(); }
    constexpr const char* end() const { return data() + size_; }

    // Templates, so that neither side is converted: for a literal there would be two ways.
    template <typename Text>
        requires std::convertible_to<const Text&, std::string_view>
    friend constexpr bool operator==(const BoundedString& a, const Text& b) {
        return a.view() == std::string_view{b};
    }
    template <typename Text>
        requires std::convertible_to<const Text&, std::string_view>
    friend constexpr auto operator<=>(const BoundedString& a, const Text& b) {
        return a.view() <=> std::string_view{b};
    }

    friend std::ostream& operator<<(std::ostream& out, const BoundedString& text) {
        return out << text.view();
    }

  private:
    std::array<char, N + 1> text_{};
    std::uint16_t size_ = 0;
    bool overlong_ = false;
};

/// IDL's `sequence<T, N>` without a heap: at most N elements, used as a std::vector is. T has a
/// default constructor; the places of elements that are not there hold such values, or any octets
/// where T is an octet.
///
///     canorb::BoundedVector<std::uint16_t, 8> samples = {1, 2, 3};
///     samples.push_back(4);
///
/// What does not fit is left out, and the vector remembers that it is overlong until clear() or
/// assign(). To send an overlong vector is BAD_PARAM, so half a sequence is never taken for a
/// whole one, and what push_back() says may be ignored.
template <typename T, std::size_t N>
class BoundedVector {
    static_assert(N >= 1, "a bound is 1 or more");
    static constexpr bool of_octets = std::same_as<T, std::uint8_t>;

  public:
    using value_type = T;
    using iterator = T*;
    using const_iterator = const T*;

    constexpr BoundedVector()
        requires(!of_octets)
        : elements_{} {}
    // To clear octets takes longer than to decode them. A constant must have all of its octets.
    constexpr BoundedVector()
        requires of_octets
    {
        if (std::is_constant_evaluated()) elements_.fill(0);
    }
    constexpr BoundedVector(std::initializer_list<T> elements) : BoundedVector() {
        assign(std::span<const T>{elements.begin(), elements.size()});
    }

    /// False: there are more than N elements and the vector is now overlong.
    constexpr bool assign(std::span<const T> elements) {
        const std::size_t kept = std::min(elements.size(), N);
        std::copy_n(elements.begin(), kept, elements_.begin());
        if constexpr (!of_octets) {
            for (std::size_t i = kept; i < size_; ++i) elements_[i] = T{};
        }
        size_ = kept;
        overlong_ = elements.size() > N;
        return !overlong_;
    }

    /// False: the vector was full and is now overlong.
    constexpr bool push_back(T element) {
        if (size_ == N) {
            overlong_ = true;
            return false;
        }
        elements_[size_++] = std::move(element);
        return true;
    }

    /// New elements get T's default value. False: `size` is more than N; the vector has N elements
    /// and is now overlong.
    constexpr bool resize(std::size_t size) {
        const std::size_t kept = std::min(size, N);
        if constexpr (of_octets) {
            for (std::size_t i = size_; i < kept; ++i) elements_[i] = 0;
        } else {
            for (std::size_t i = kept; i < size_; ++i) elements_[i] = T{};
        }
        size_ = kept;
        overlong_ = size > N;
        return !overlong_;
    }

    constexpr void clear() { resize(0); }

    /// Whether it holds only the beginning of what it was given.
    constexpr bool is_overlong() const { return overlong_; }

    constexpr std::size_t size() const { return size_; }
    constexpr bool empty() const { return size_ == 0; }
    static constexpr std::size_t capacity() { return N; }

    constexpr T* data() { return elements_.data(); }
    constexpr const T* data() const { return elements_.data(); }
    constexpr T& operator[](std::size_t index) { return elements_[index]; }
    constexpr const T& operator[](std::size_t index) const { return elements_[index]; }
    constexpr T& front() { return elements_[0]; }
    constexpr const T& front() const { return elements_[0]; }
    constexpr T& back() { return elements_[size_ - 1]; }
    constexpr const T& back() const { return elements_[size_ - 1]; }
    constexpr iterator begin() { return data(); }
    constexpr iterator end() { return data() + size_; }
    constexpr const_iterator begin() const { return data(); }
    constexpr const_iterator end() const { return data() + size_; }

    friend constexpr bool operator==(const BoundedVector& a, const BoundedVector& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

  private:
    std::array<T, N> elements_;
    std::size_t size_ = 0;
    bool overlong_ = false;
};

}  // namespace canorb

namespace canorb::ccdr {

template <std::size_t N>
inline constexpr std::size_t fewest_octets<BoundedString<N>> = fewest_octets<std::string>;

template <std::size_t N>
void encode(Encoder& out, const BoundedString<N>& value) {
    if (value.is_overlong()) return out.fail();
    out.string(value.view());
}

template <std::size_t N>
void decode(Decoder& in, BoundedString<N>& value) {
    const std::string_view text = in.string();
    if (!value.assign(text)) {
        in.fail();
        value.clear();
    }
}

template <typename T, std::size_t N>
void encode(Encoder& out, const BoundedVector<T, N>& value) {
    if (value.is_overlong()) return out.fail();
    out.count(value.size(), fewest_octets<T>);
    if constexpr (std::same_as<T, std::uint8_t>) {
        out.octets({value.data(), value.size()});
    } else {
        for (const T& element : value) encode(out, element);
    }
}

template <typename T, std::size_t N>
void decode(Decoder& in, BoundedVector<T, N>& value) {
    const std::size_t count = in.count(fewest_octets<T>, N);
    if constexpr (std::same_as<T, std::uint8_t>) {
        value.assign(in.octets(count));
    } else {
        value.clear();
        value.resize(count);
        for (T& element : value) decode(in, element);
    }
}

/// A std::string, std::u16string, std::vector, std::array or std::map with the bounds that IDL
/// gives it: see bounded().
template <typename T, std::size_t... Bounds>
struct Bounded {
    T& value;
};

/// Gives `value` its IDL bounds while it is encoded or decoded; 0 stands for none. The first is
/// that of the string or sequence itself, the next that of its elements, and so on; an array has
/// no bound of its own and hands all of them to its elements. The bounds behind a map's own are
/// first that of its key, if that is a std::string or std::u16string and for no other key, then
/// those of its values. Too long a value is bad_value to an Encoder; a count above its bound fails
/// a Decoder before anything is allocated.
///
///     encode(out, bounded<300>(text));              // string<300>
///     decode(in, bounded<1000, 300>(texts));        // sequence<string<300>, 1000>
///     decode(in, bounded<10>(names));               // map<long, string, 10>
///     decode(in, bounded<0, 300, 400>(names));      // map<string<300>, wstring<400>>
///     decode(in, bounded<0, 400>(names));           // map<long, wstring<400>>
template <std::size_t... Bounds, typename T>
constexpr Bounded<T, Bounds...> bounded(T& value) {
    return {value};
}

/// The most octets or elements that a bound allows.
constexpr std::size_t highest_count(std::size_t bound) {
    return bound == 0 ? std::numeric_limits<std::size_t>::max() : bound;
}

template <typename T, std::size_t... Bounds>
    requires(!std::is_const_v<T>)
void encode(Encoder& out, Bounded<T, Bounds...> bounded_value) {
    encode(out, Bounded<const T, Bounds...>{bounded_value.value});
}

template <std::size_t N>
void encode(Encoder& out, Bounded<const std::string, N> text) {
    if (text.value.size() > highest_count(N)) return out.fail();
    out.string(text.value);
}

template <std::size_t N>
void encode(Encoder& out, Bounded<const std::u16string, N> text) {
    if (text.value.size() > highest_count(N)) return out.fail();
    out.wide_string(text.value);
}

template <typename T, std::size_t N, std::size_t... Inner>
void encode(Encoder& out, Bounded<const std::vector<T>, N, Inner...> sequence) {
    if (sequence.value.size() > highest_count(N)) return out.fail();
    if constexpr (sizeof...(Inner) == 0) {
        encode(out, sequence.value);
    } else {
        out.count(sequence.value.size(), fewest_octets<T>);
        for (const T& element : sequence.value) encode(out, bounded<Inner...>(element));
    }
}

template <typename T, std::size_t M, std::size_t... Bounds>
void encode(Encoder& out, Bounded<const std::array<T, M>, Bounds...> array) {
    for (const T& element : array.value) encode(out, bounded<Bounds...>(element));
}

template <std::size_t N>
void decode(Decoder& in, Bounded<std::string, N> text) {
    const std::string_view octets = in.string();
    if (octets.size() > highest_count(N)) in.fail();
    text.value.assign(in.ok() ? octets : std::string_view{});
}

template <std::size_t N>
void decode(Decoder& in, Bounded<std::u16string, N> text) {
    assign(text.value, in.wide_string(highest_count(N)));
}

template <typename T, std::size_t N, std::size_t... Inner>
void decode(Decoder& in, Bounded<std::vector<T>, N, Inner...> sequence) {
    const std::size_t count = in.count(fewest_octets<T>, highest_count(N));
    decode_elements(in, sequence.value, count, [](Decoder& from, T& element) {
        if constexpr (sizeof...(Inner) == 0) {
            decode(from, element);
        } else {
            decode(from, bounded<Inner...>(element));
        }
    });
}

template <typename T, std::size_t M, std::size_t... Bounds>
void decode(Decoder& in, Bounded<std::array<T, M>, Bounds...> array) {
    for (T& element : array.value) decode(in, bounded<Bounds...>(element));
}

}  // namespace canorb::ccdr
