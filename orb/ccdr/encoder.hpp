#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/ccdr/fewest_octets.hpp"
#include "orb/ccdr/octet_order.hpp"

namespace canorb::ccdr {

struct DecodeContext;
struct VariableForm;

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
///
/// What small arguments need is inline: a call for each would take longer than writing it.
class Encoder {
  public:
    explicit Encoder(MutableBytes buffer)
        : begin_(buffer.data()),
          limit_(static_cast<std::uint32_t>(
              std::min(buffer.size(), std::size_t{std::numeric_limits<std::uint32_t>::max()}))) {}

    [[nodiscard]] EncodeError error() const { return error_; }
    /// What was written so far.
    Bytes octets() const { return {begin_, size_}; }
    std::size_t size() const { return size_; }

    /// The value cannot be sent: BAD_PARAM for the caller.
    void fail() { fail(EncodeError::bad_value); }

    void octet(std::uint8_t value) {
        if (has_room(1)) *advance(1) = value;
    }
    /// Octets as they are, without a count.
    void octets(Bytes value);
    void variable_unsigned(std::uint32_t value) {
        if (value < 0x80) return octet(static_cast<std::uint8_t>(value));
        if (value >= 0x4000) return long_unsigned(value);
        if (has_room(2)) write_be16(advance(2), static_cast<std::uint16_t>(0x8000 | value));
    }
    void variable_signed(std::int32_t value) {
        if (value >= -0x40 && value < 0x40) return octet(static_cast<std::uint8_t>(value & 0x7F));
        if (value < -0x2000 || value >= 0x2000) return long_signed(value);
        if (has_room(2))
            write_be16(advance(2), static_cast<std::uint16_t>(0x8000 | (value & 0x3FFF)));
    }
    void fixed64(std::uint64_t value) {
        if (has_room(8)) write_be64(advance(8), value);
    }
    void fixed32(std::uint32_t value) {
        if (has_room(4)) write_be32(advance(4), value);
    }
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
    /// Whether so many octets can be written; otherwise it fails. Behind an error there is no
    /// room, so that one comparison tells both.
    bool has_room(std::size_t octets) {
        if (limit_ - size_ >= octets) [[likely]]
            return true;
        fail(EncodeError::buffer_full);
        return false;
    }
    /// Where to write so many octets, for which there is room.
    std::uint8_t* advance(std::size_t octets) {
        std::uint8_t* start = begin_ + size_;
        size_ += static_cast<std::uint32_t>(octets);
        return start;
    }
    void long_unsigned(std::uint32_t value);
    void long_signed(std::int32_t value);
    void write(const VariableForm& form, std::uint32_t bits);

    // Small, as one is made for each message. No message is longer than 32 bits can say.
    std::uint8_t* begin_;
    std::uint32_t size_ = 0;
    std::uint32_t limit_;  ///< of size_
    const DecodeContext* context_ = nullptr;
    std::uint32_t octetless_ = 0;  ///< elements without octets so far
    std::uint16_t levels_ = 0;
    EncodeError error_ = EncodeError::none;
    // Without it, 31 octets would be copied as two halves that overlap, and reading a member that
    // is in both then has to wait for both.
    [[maybe_unused]] std::uint8_t filler_ = 0;
};

inline void encode(Encoder& out, bool value) {
    out.octet(value ? 1 : 0);
}
inline void encode(Encoder& out, char value) {
    out.octet(static_cast<std::uint8_t>(value));
}
inline void encode(Encoder& out, std::int8_t value) {
    out.octet(static_cast<std::uint8_t>(value));
}
inline void encode(Encoder& out, std::uint8_t value) {
    out.octet(value);
}
inline void encode(Encoder& out, std::int16_t value) {
    out.variable_signed(value);
}
inline void encode(Encoder& out, std::uint16_t value) {
    out.variable_unsigned(value);
}
inline void encode(Encoder& out, std::int32_t value) {
    out.variable_signed(value);
}
inline void encode(Encoder& out, std::uint32_t value) {
    out.variable_unsigned(value);
}
inline void encode(Encoder& out, std::int64_t value) {
    out.fixed64(static_cast<std::uint64_t>(value));
}
inline void encode(Encoder& out, std::uint64_t value) {
    out.fixed64(value);
}
inline void encode(Encoder& out, float value) {
    out.fixed32(std::bit_cast<std::uint32_t>(value));
}
inline void encode(Encoder& out, double value) {
    out.fixed64(std::bit_cast<std::uint64_t>(value));
}
void encode(Encoder& out, long double value);
void encode(Encoder& out, char16_t value);
inline void encode(Encoder& out, std::string_view value) {
    out.string(value);
}
inline void encode(Encoder& out, std::u16string_view value) {
    out.wide_string(value);
}
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
