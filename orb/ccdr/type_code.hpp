#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orb/ccdr/bounded.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
#include "orb/ccdr/fixed.hpp"
#include "orb/ccdr/print.hpp"

namespace canorb {

/// The kinds of types, numbered as CORBA does. Those that are missing cannot be sent.
enum class TCKind : std::uint32_t {
    tk_null = 0,
    tk_void = 1,
    tk_short = 2,
    tk_long = 3,
    tk_ushort = 4,
    tk_ulong = 5,
    tk_float = 6,
    tk_double = 7,
    tk_boolean = 8,
    tk_char = 9,
    tk_octet = 10,  ///< int8 and uint8 too
    tk_any = 11,
    tk_TypeCode = 12,
    tk_objref = 14,
    tk_struct = 15,
    tk_union = 16,
    tk_enum = 17,
    tk_string = 18,
    tk_sequence = 19,  ///< of structs of key and value: a map
    tk_array = 20,
    tk_alias = 21,
    tk_except = 22,
    tk_longlong = 23,
    tk_ulonglong = 24,
    tk_longdouble = 25,
    tk_wchar = 26,
    tk_wstring = 27,
    tk_fixed = 28,
    tk_recursion = 0xFFFFFFFF,  ///< within a type code: one of those around it
};

/// A description of an IDL type, CORBA::TypeCode: what a canorb::Any says its value is.
class TypeCode {
  public:
    /// That of nothing: tk_null.
    TypeCode() : octets_(1, '\0') {}

    /// A type code as octets, doc/wire/ccdr.md, "Type codes". What is not well-formed is BAD_PARAM
    /// when it is sent.
    explicit TypeCode(std::string octets) : octets_(std::move(octets)) {}

    TCKind kind() const;
    /// The repository id of a type that has one; else empty.
    std::string_view id() const;
    Bytes octets() const {
        return {reinterpret_cast<const std::uint8_t*>(octets_.data()), octets_.size()};
    }

    /// Whether it is the same type but for names and aliases.
    bool equivalent(const TypeCode& other) const;
    /// Whether every value of the type `other` is one of this type too: they are equivalent, or
    /// differ in that this one has no bound where the other has, or is Object where the other is
    /// another interface.
    bool accepts(const TypeCode& other) const;

    /// Octet by octet.
    friend bool operator==(const TypeCode&, const TypeCode&) = default;

    friend void encode(ccdr::Encoder& out, const TypeCode& value);
    friend void decode(ccdr::Decoder& in, TypeCode& value);

  private:
    std::string octets_;
};

/// "typecode 0F0100...", the octets in hex.
template <OutputStream Stream>
Stream& operator<<(Stream& out, const TypeCode& value) {
    out << "typecode ";
    return print_octets(out, value.octets());
}

}  // namespace canorb

namespace canorb::ccdr {

/// Reads a type code and gives its octets. It fails for an unknown kind, more than 16 levels, and
/// what describes no type. It does not allocate.
Bytes read_type_code(Decoder& in);

/// Reads one value of the type that `type_code`, from read_type_code(), describes, and gives its
/// octets. It fails where they are no such value. It does not allocate.
///
/// The work is limited: a long type code with many values, which no real type has, fails too.
Bytes read_value(Decoder& in, Bytes type_code);

/// Builds the octets of type codes.
void append_unsigned(std::string& to, std::uint32_t value);
void append_kind(std::string& to, TCKind kind);
/// An empty id and an empty name, and the number of members, behind which they follow.
void append_nameless_struct(std::string& to, std::uint32_t members);
/// The name of a member.
void append_empty_name(std::string& to);

/// How the type code of T is found. Generated code has for each struct, union, enum, bitmask,
/// exception and interface X, in its namespace,
///
///     constexpr std::string_view type_code_of(const X*) { return {"\x0F...", 42}; }
///
/// the whole type code; types that are more than 16 levels deep have none, and are in no any.
template <typename T>
struct TypeCodeOf {
    static void append(std::string& to) { to += type_code_of(static_cast<const T*>(nullptr)); }
};

template <TCKind Kind>
struct BasicTypeCode {
    static void append(std::string& to) { append_kind(to, Kind); }
};

template <>
struct TypeCodeOf<bool> : BasicTypeCode<TCKind::tk_boolean> {};
template <>
struct TypeCodeOf<char> : BasicTypeCode<TCKind::tk_char> {};
template <>
struct TypeCodeOf<char16_t> : BasicTypeCode<TCKind::tk_wchar> {};
template <>
struct TypeCodeOf<std::int8_t> : BasicTypeCode<TCKind::tk_octet> {};
template <>
struct TypeCodeOf<std::uint8_t> : BasicTypeCode<TCKind::tk_octet> {};
template <>
struct TypeCodeOf<std::int16_t> : BasicTypeCode<TCKind::tk_short> {};
template <>
struct TypeCodeOf<std::uint16_t> : BasicTypeCode<TCKind::tk_ushort> {};
template <>
struct TypeCodeOf<std::int32_t> : BasicTypeCode<TCKind::tk_long> {};
template <>
struct TypeCodeOf<std::uint32_t> : BasicTypeCode<TCKind::tk_ulong> {};
template <>
struct TypeCodeOf<std::int64_t> : BasicTypeCode<TCKind::tk_longlong> {};
template <>
struct TypeCodeOf<std::uint64_t> : BasicTypeCode<TCKind::tk_ulonglong> {};
template <>
struct TypeCodeOf<float> : BasicTypeCode<TCKind::tk_float> {};
template <>
struct TypeCodeOf<double> : BasicTypeCode<TCKind::tk_double> {};
template <>
struct TypeCodeOf<long double> : BasicTypeCode<TCKind::tk_longdouble> {};
template <>
struct TypeCodeOf<TypeCode> : BasicTypeCode<TCKind::tk_TypeCode> {};

template <TCKind Kind, std::size_t Bound>
struct TextTypeCode {
    static void append(std::string& to) {
        append_kind(to, Kind);
        append_unsigned(to, static_cast<std::uint32_t>(Bound));
    }
};
template <>
struct TypeCodeOf<std::string> : TextTypeCode<TCKind::tk_string, 0> {};
template <>
struct TypeCodeOf<std::string_view> : TextTypeCode<TCKind::tk_string, 0> {};
template <>
struct TypeCodeOf<std::u16string> : TextTypeCode<TCKind::tk_wstring, 0> {};
template <std::size_t N>
struct TypeCodeOf<BoundedString<N>> : TextTypeCode<TCKind::tk_string, N> {};

template <std::size_t D, std::size_t S>
struct TypeCodeOf<Fixed<D, S>> {
    static void append(std::string& to) {
        append_kind(to, TCKind::tk_fixed);
        // Both are below 64, so a short has the same octet as an unsigned short.
        append_unsigned(to, D);
        append_unsigned(to, S);
    }
};

template <TCKind Kind, typename T, std::size_t Count>
struct ElementsTypeCode {
    static void append(std::string& to) {
        append_kind(to, Kind);
        TypeCodeOf<T>::append(to);
        append_unsigned(to, static_cast<std::uint32_t>(Count));
    }
};
template <typename T>
struct TypeCodeOf<std::vector<T>> : ElementsTypeCode<TCKind::tk_sequence, T, 0> {};
template <typename T, std::size_t N>
struct TypeCodeOf<BoundedVector<T, N>> : ElementsTypeCode<TCKind::tk_sequence, T, N> {};
template <typename T, std::size_t N>
struct TypeCodeOf<std::array<T, N>> : ElementsTypeCode<TCKind::tk_array, T, N> {};

template <typename K, typename V>
struct TypeCodeOf<std::pair<const K, V>> {
    static void append(std::string& to) {
        append_kind(to, TCKind::tk_struct);
        append_nameless_struct(to, 2);
        append_empty_name(to);
        TypeCodeOf<K>::append(to);
        append_empty_name(to);
        TypeCodeOf<V>::append(to);
    }
};
template <typename K, typename V>
struct TypeCodeOf<std::map<K, V>>
    : ElementsTypeCode<TCKind::tk_sequence, std::pair<const K, V>, 0> {};

}  // namespace canorb::ccdr

namespace canorb {

/// The type code of a C++ type that generated code uses for an IDL type.
template <typename T>
TypeCode type_code() {
    std::string octets;
    ccdr::TypeCodeOf<T>::append(octets);
    return TypeCode{std::move(octets)};
}

}  // namespace canorb
