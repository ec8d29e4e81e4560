#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/ccdr/fewest_octets.hpp"

namespace canorb::ccdr {

struct DecodeContext;

enum class EncodeError : std::uint8_t {
    none,
    buffer_full,  ///< the message is longer than the buffer
    bad_value,    ///< a bound exceeded, a NUL in a string, a value outside its enum
};

/// Writes values as CCDR octets into a buffer that the caller owns. It does not allocate. The
/// first error sticks: what follows is not written, and error() tells at the end.
///
///     std::array<std::uint8_t, 64> buffer;
///     ccdr::Encoder out{buffer};
///     encode(out, std::uint16_t{118});
///     if (out.error() == EncodeError::none) send(out.octets());
class Encoder {
  public:
    explicit Encoder(MutableBytes buffer) : buffer_(buffer) {}

    [[nodiscard]] EncodeError error() const { return error_; }
    /// What was written so far.
    Bytes octets() const { return Bytes{buffer_}.first(size_); }
    std::size_t size() const { return size_; }

    /// The value cannot be sent: BAD_PARAM for the caller.
    void fail() { fail(EncodeError::bad_value); }

    void octet(std::uint8_t value);
    /// Octets as they are, without a count.
    void octets(Bytes value);
    void variable_unsigned(std::uint32_t value);
    void variable_signed(std::int32_t value);
    void fixed64(std::uint64_t value);
    void fixed32(std::uint32_t value);
    /// A sequence's count, or a string's length with its NUL. It fails for more elements without
    /// octets than a Decoder reads.
    void count(std::size_t value, std::size_t element_octets = 1);
    /// Length with the NUL, octets, NUL. A NUL inside fails.
    void string(std::string_view value);
    /// Length with the final 0, code units, 0. A 0 inside fails.
    void wide_string(std::u16string_view value);

    /// What an object reference that is written belongs to, and with it the octets: an any must
    /// read them again. Null changes nothing.
    void belongs_to(const DecodeContext* context) {
        if (context != nullptr) context_ = context;
    }
    const DecodeContext* context() const { return context_; }

    /// What Nesting calls.
    bool enter();
    void leave() { --levels_; }
    unsigned levels() const { return levels_; }

  private:
    void fail(EncodeError error);
    std::uint8_t* reserve(std::size_t octets);

    MutableBytes buffer_;
    std::size_t size_ = 0;
    std::size_t octetless_ = 0;  ///< elements without octets so far
    const DecodeContext* context_ = nullptr;
    unsigned levels_ = 0;
    EncodeError error_ = EncodeError::none;
};

void encode(Encoder& out, bool value);
void encode(Encoder& out, char value);
void encode(Encoder& out, std::int8_t value);
void encode(Encoder& out, std::uint8_t value);
void encode(Encoder& out, std::int16_t value);
void encode(Encoder& out, std::uint16_t value);
void encode(Encoder& out, std::int32_t value);
void encode(Encoder& out, std::uint32_t value);
void encode(Encoder& out, std::int64_t value);
void encode(Encoder& out, std::uint64_t value);
void encode(Encoder& out, float value);
void encode(Encoder& out, double value);
void encode(Encoder& out, long double value);
void encode(Encoder& out, char16_t value);
void encode(Encoder& out, std::string_view value);
void encode(Encoder& out, std::u16string_view value);
// Nothing else converts by accident.
template <typename T>
    requires std::is_pointer_v<T>
void encode(Encoder& out, T value) = delete;

template <typename T, std::size_t N>
void encode(Encoder& out, const std::array<T, N>& value);
template <typename T>
void encode(Encoder& out, const std::vector<T>& value);

template <typename T, std::size_t N>
void encode(Encoder& out, const std::array<T, N>& value) {
    for (const T& element : value) encode(out, element);
}

template <typename T>
void encode(Encoder& out, const std::vector<T>& value) {
    out.count(value.size(), fewest_octets<T>);
    if constexpr (std::same_as<T, std::uint8_t>) {
        out.octets(value);
    } else {
        // The cast is for std::vector<bool>, whose elements are proxies.
        for (const auto& element : value) encode(out, static_cast<const T&>(element));
    }
}

}  // namespace canorb::ccdr
