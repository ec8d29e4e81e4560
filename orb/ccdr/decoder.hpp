#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/ccdr/fewest_octets.hpp"
#include "orb/ccdr/format.hpp"
#include "orb/ccdr/octet_order.hpp"

namespace canorb::ccdr {

/// What object references that are decoded belong to: the ORB. This layer only hands it on; the
/// runtime derives from it and knows its own type again.
struct DecodeContext {
    /// The same context, kept alive: what a value asks for that decodes a part of itself later.
    /// Empty where nothing can keep it.
    virtual std::shared_ptr<const DecodeContext> shared() const { return nullptr; }

  protected:
    ~DecodeContext() = default;
};

/// Reads CCDR octets. The first malformed value sticks: from then on every read gives a zero or
/// empty value, and ok() is false. There is one cause to tell, MARSHAL, so there is no error kind.
///
///     ccdr::Decoder in{octets};
///     std::uint16_t channel{};
///     decode(in, channel);
///     if (!in.finished()) return marshal;
///
/// What small arguments need is inline: a call for each would take longer than reading it.
class Decoder {
  public:
    /// `octets` and `context` belong to the caller and outlive this object. `levels` is how deep
    /// the values already are: see Nesting.
    explicit Decoder(Bytes octets, const DecodeContext* context = nullptr, unsigned levels = 0)
        : next_(octets.data()),
          end_(next_ + octets.size()),
          context_(context),
          levels_(static_cast<std::uint16_t>(levels)) {}

    /// As given to the constructor: nullptr where no references are expected.
    const DecodeContext* context() const { return context_; }

    [[nodiscard]] bool ok() const { return ok_; }
    /// No error, and nothing left over: a complete value was read.
    [[nodiscard]] bool finished() const { return ok_ && remaining() == 0; }
    std::size_t remaining() const { return static_cast<std::size_t>(end_ - next_); }
    /// The octets that are not read yet.
    Bytes rest() const { return {next_, remaining()}; }

    /// What was read is not a value of its type.
    void fail() {
        ok_ = false;
        next_ = end_;
    }

    std::uint8_t octet() { return has(1) ? *advance(1) : std::uint8_t{0}; }
    /// The next `count` octets as they are; empty when there are fewer.
    Bytes octets(std::size_t count) { return has(count) ? Bytes{advance(count), count} : Bytes{}; }
    std::uint32_t variable_unsigned(std::uint32_t highest) {
        // One and two octets here; whatever is not right about them long_unsigned() finds, too.
        if (next_ != end_ && *next_ < 0x80 && *next_ <= highest) return *next_++;
        if (remaining() >= 2) {
            const std::uint32_t value = read_be16(next_) ^ 0x8000U;
            if (value < 0x4000 && value >= 0x80 && value <= highest) {
                next_ += 2;
                return value;
            }
        }
        return long_unsigned(highest);
    }
    std::int32_t variable_signed(std::int32_t lowest, std::int32_t highest);
    std::uint64_t fixed64() { return has(8) ? read_be64(advance(8)) : 0; }
    std::uint32_t fixed32() { return has(4) ? read_be32(advance(4)) : 0; }
    /// A sequence's count. It fails when the octets left cannot hold so many elements of at least
    /// `element_octets` each, so nothing is allocated for a count that lies.
    /// It also fails above `highest`, the sequence's bound. Elements that take no octets are
    /// limited to `highest_octetless` in all that this object reads.
    std::size_t count(std::size_t element_octets = 1,
                      std::size_t highest = std::numeric_limits<std::size_t>::max()) {
        const std::size_t value = variable_unsigned(std::numeric_limits<std::uint32_t>::max());
        const std::size_t room =
            element_octets == 0 ? highest_octetless - octetless_ : remaining() / element_octets;
        if (!ok_ || value > room || value > highest) {
            fail();
            return 0;
        }
        if (element_octets == 0) octetless_ += static_cast<std::uint32_t>(value);
        return value;
    }
    /// A string, without its NUL; the view is into the octets being read.
    std::string_view string();
    /// The code units of a wide string, two octets each, without the final one; it fails for more
    /// than `highest`.
    Bytes wide_string(std::size_t highest = std::numeric_limits<std::size_t>::max());

    /// What Nesting calls.
    bool enter();
    void leave() { --levels_; }
    unsigned levels() const { return levels_; }

  private:
    /// The form and the bits of a variable integer, sign not yet extended.
    struct Variable {
        std::size_t form;
        std::uint32_t bits;
    };
    Variable variable();
    std::uint32_t long_unsigned(std::uint32_t highest);
    /// Whether so many octets are left; otherwise it fails.
    bool has(std::size_t count) {
        if (remaining() >= count) [[likely]]
            return true;
        fail();
        return false;
    }
    /// Past so many octets, which are left; where they begin.
    const std::uint8_t* advance(std::size_t count) {
        const std::uint8_t* from = next_;
        next_ += count;
        return from;
    }

    // Small, as one is made for each message.
    const std::uint8_t* next_;
    const std::uint8_t* end_;
    const DecodeContext* context_;
    std::uint32_t octetless_ = 0;  ///< elements without octets so far
    std::uint16_t levels_ = 0;
    bool ok_ = true;
    [[maybe_unused]] std::uint8_t filler_ = 0;  ///< as in Encoder
};

inline void decode(Decoder& in, bool& value) {
    const std::uint8_t octet = in.octet();
    if (octet > 1) in.fail();
    value = octet == 1;
}
inline void decode(Decoder& in, char& value) {
    value = static_cast<char>(in.octet());
}
inline void decode(Decoder& in, std::int8_t& value) {
    value = static_cast<std::int8_t>(in.octet());
}
inline void decode(Decoder& in, std::uint8_t& value) {
    value = in.octet();
}
void decode(Decoder& in, std::int16_t& value);
inline void decode(Decoder& in, std::uint16_t& value) {
    value =
        static_cast<std::uint16_t>(in.variable_unsigned(std::numeric_limits<std::uint16_t>::max()));
}
void decode(Decoder& in, std::int32_t& value);
inline void decode(Decoder& in, std::uint32_t& value) {
    value = in.variable_unsigned(std::numeric_limits<std::uint32_t>::max());
}
inline void decode(Decoder& in, std::int64_t& value) {
    value = static_cast<std::int64_t>(in.fixed64());
}
inline void decode(Decoder& in, std::uint64_t& value) {
    value = in.fixed64();
}
inline void decode(Decoder& in, float& value) {
    value = std::bit_cast<float>(in.fixed32());
}
inline void decode(Decoder& in, double& value) {
    value = std::bit_cast<double>(in.fixed64());
}
void decode(Decoder& in, long double& value);
void decode(Decoder& in, char16_t& value);
void decode(Decoder& in, std::string& value);
void decode(Decoder& in, std::u16string& value);

/// Code units as Decoder::wide_string() gives them.
void assign(std::u16string& text, Bytes units);

template <typename T, std::size_t N>
void decode(Decoder& in, std::array<T, N>& value);
template <typename T>
void decode(Decoder& in, std::vector<T>& value);

template <typename T, std::size_t N>
void decode(Decoder& in, std::array<T, N>& value) {
    for (T& element : value) decode(in, element);
}

/// Reads `count` elements, each by `decode_element(in, element)`.
template <typename T, typename DecodeElement>
void decode_elements(Decoder& in, std::vector<T>& value, std::size_t count,
                     DecodeElement decode_element) {
    value.clear();
    if constexpr (std::same_as<T, std::uint8_t>) {
        const Bytes octets = in.octets(count);
        value.assign(octets.begin(), octets.end());
    } else {
        // An element may be far larger in memory than in the fewest octets: a count that lies must
        // not get megabytes, an honest one may well grow step by step.
        constexpr std::size_t memory_per_octet = 8;
        value.reserve(std::min(count, 1 + in.remaining() * memory_per_octet / sizeof(T)));
        for (std::size_t i = 0; i < count && in.ok(); ++i) {
            T element{};
            decode_element(in, element);
            value.push_back(std::move(element));
        }
    }
}

template <typename T>
void decode(Decoder& in, std::vector<T>& value) {
    const std::size_t count = in.count(fewest_octets<T>);
    decode_elements(in, value, count, [](Decoder& from, T& element) { decode(from, element); });
}

}  // namespace canorb::ccdr
