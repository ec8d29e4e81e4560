#pragma once

#include <algorithm>
#include <array>
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
class Decoder {
  public:
    /// `octets` and `context` belong to the caller and outlive this object. `levels` is how deep
    /// the values already are: see Nesting.
    explicit Decoder(Bytes octets, const DecodeContext* context = nullptr, unsigned levels = 0)
        : octets_(octets), context_(context), levels_(levels) {}

    /// As given to the constructor: nullptr where no references are expected.
    const DecodeContext* context() const { return context_; }

    [[nodiscard]] bool ok() const { return ok_; }
    /// No error, and nothing left over: a complete value was read.
    [[nodiscard]] bool finished() const { return ok_ && remaining() == 0; }
    std::size_t remaining() const { return octets_.size() - position_; }
    /// The octets that are not read yet.
    Bytes rest() const { return octets_.subspan(position_); }

    /// What was read is not a value of its type.
    void fail();

    std::uint8_t octet();
    /// The next `count` octets as they are; empty when there are fewer.
    Bytes octets(std::size_t count);
    std::uint32_t variable_unsigned(std::uint32_t highest);
    std::int32_t variable_signed(std::int32_t lowest, std::int32_t highest);
    std::uint64_t fixed64();
    std::uint32_t fixed32();
    /// A sequence's count. It fails when the octets left cannot hold so many elements of at least
    /// `element_octets` each, so nothing is allocated for a count that lies.
    /// It also fails above `highest`, the sequence's bound. Elements that take no octets are
    /// limited to `highest_octetless` in all that this object reads.
    std::size_t count(std::size_t element_octets = 1,
                      std::size_t highest = std::numeric_limits<std::size_t>::max());
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

    Bytes octets_;
    const DecodeContext* context_;
    std::size_t position_ = 0;
    std::size_t octetless_ = 0;  ///< elements without octets so far
    unsigned levels_ = 0;
    bool ok_ = true;
};

void decode(Decoder& in, bool& value);
void decode(Decoder& in, char& value);
void decode(Decoder& in, std::int8_t& value);
void decode(Decoder& in, std::uint8_t& value);
void decode(Decoder& in, std::int16_t& value);
void decode(Decoder& in, std::uint16_t& value);
void decode(Decoder& in, std::int32_t& value);
void decode(Decoder& in, std::uint32_t& value);
void decode(Decoder& in, std::int64_t& value);
void decode(Decoder& in, std::uint64_t& value);
void decode(Decoder& in, float& value);
void decode(Decoder& in, double& value);
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
