#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "orb/ccdr/type_code.hpp"

namespace canorb {

/// IDL's `any`: a value of a type that only it knows.
///
///     canorb::Any any;
///     any <<= 21.5;
///     any <<= Devices::Status{.speed = 3};
///     Devices::Status status;
///     if (any >>= status) std::cout << status.speed;
///
/// It keeps the value as octets, so one that was received need not be of a type this program
/// knows: it can be passed on. A value that cannot be sent, as a BoundedString that is overlong,
/// leaves an any that cannot be sent either: BAD_PARAM. It may outlive the Orb of the call.
class Any {
  public:
    /// Of no value: tk_null.
    Any() = default;

    const TypeCode& type() const { return type_; }
    /// The value in CCDR.
    Bytes value() const { return value_; }

    /// What the object references in the value belong to.
    const ccdr::DecodeContext* context() const { return context_.get(); }

    using EncodeValue = void (*)(ccdr::Encoder& out, const void* value);
    /// What <<= calls: the octets that `encode_value` writes of `value`, of the type `type`.
    void assign(TypeCode type, EncodeValue encode_value, const void* value);

    /// The same type and value, octet by octet.
    friend bool operator==(const Any& a, const Any& b) {
        return a.type_ == b.type_ && a.value_ == b.value_ && a.is_bad_ == b.is_bad_;
    }

    friend void encode(ccdr::Encoder& out, const Any& any);
    friend void decode(ccdr::Decoder& in, Any& any);

  private:
    TypeCode type_;
    std::vector<std::uint8_t> value_;
    std::shared_ptr<const ccdr::DecodeContext> context_;
    bool is_bad_ = false;
};

/// Sets type and value. T is any type that generated code uses for an IDL type.
template <typename T>
void operator<<=(Any& any, const T& value) {
    any.assign(
        type_code<T>(),
        [](ccdr::Encoder& out, const void* from) { encode(out, *static_cast<const T*>(from)); },
        &value);
}
inline void operator<<=(Any& any, const char* text) {
    any <<= std::string_view{text};
}

/// Whether it holds a T, which is then in `value`; otherwise `value` is as it was. A text or
/// sequence with a bound may be taken as one without, any object reference as a canorb::ObjectRef.
template <typename T>
bool operator>>=(const Any& any, T& value) {
    if (!type_code<T>().accepts(any.type())) return false;
    ccdr::Decoder in{any.value(), any.context()};
    T result{};
    decode(in, result);
    if (!in.finished()) return false;
    value = std::move(result);
    return true;
}

/// "any(kind 3: 2A)", the value in hex.
template <OutputStream Stream>
Stream& operator<<(Stream& out, const Any& any) {
    out << "any(kind " << static_cast<std::uint32_t>(any.type().kind()) << ": ";
    print_octets(out, any.value()) << ')';
    return out;
}

}  // namespace canorb

namespace canorb::ccdr {

template <>
struct TypeCodeOf<Any> : BasicTypeCode<TCKind::tk_any> {};

}  // namespace canorb::ccdr
