// Whatever decodes as a type encodes to the same octets again: there is one encoding of a value,
// but for the order of a map.
// The first octet chooses the type, the others are decoded.
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "orb/ccdr/any.hpp"
#include "orb/ccdr/bitmask.hpp"
#include "orb/ccdr/bounded.hpp"
#include "orb/ccdr/decoder.hpp"
#include "orb/ccdr/encoder.hpp"
#include "orb/ccdr/fixed.hpp"
#include "orb/ccdr/map.hpp"
#include "orb/ccdr/nesting.hpp"

using canorb::Any;
using canorb::BoundedString;
using canorb::BoundedVector;
using canorb::Bytes;
namespace ccdr = canorb::ccdr;

namespace {

struct Record {
    bool flag{};
    std::int16_t level{};
    std::uint64_t serial{};
    std::string name;
    std::vector<std::string> notes;
    std::array<float, 2> range{};
    BoundedVector<BoundedString<4>, 3> tags;
};

void encode(ccdr::Encoder& out, const Record& value) {
    encode(out, value.flag);
    encode(out, value.level);
    encode(out, value.serial);
    encode(out, value.name);
    encode(out, ccdr::bounded<4, 8>(value.notes));
    encode(out, value.range);
    encode(out, value.tags);
}

void decode(ccdr::Decoder& in, Record& value) {
    decode(in, value.flag);
    decode(in, value.level);
    decode(in, value.serial);
    decode(in, value.name);
    decode(in, ccdr::bounded<4, 8>(value.notes));
    decode(in, value.range);
    decode(in, value.tags);
}

enum class Alarms : std::uint16_t {};
[[maybe_unused]] canorb::BitmaskBits<12> bitmask_bits(const Alarms*) {
    return {};
}

struct Empty {
    using _takes_no_octets = void;
};
void encode(ccdr::Encoder&, const Empty&) {}
void decode(ccdr::Decoder&, Empty&) {}

struct Tree {
    Any value;
    std::vector<Tree> children;
};

void encode(ccdr::Encoder& out, const Tree& value) {
    const ccdr::Nesting nesting{out};
    if (!nesting) return;
    encode(out, value.value);
    encode(out, value.children);
}

void decode(ccdr::Decoder& in, Tree& value) {
    const ccdr::Nesting nesting{in};
    if (!nesting) return;
    decode(in, value.value);
    decode(in, value.children);
}

/// The octets of a value that was just read from so many.
template <typename T>
std::vector<std::uint8_t> encoded(const T& value, std::size_t size) {
    std::vector<std::uint8_t> buffer(size);
    ccdr::Encoder out{buffer};
    encode(out, value);
    if (out.error() != ccdr::EncodeError::none || out.size() != size) std::abort();
    return buffer;
}

template <typename T>
void check(Bytes octets) {
    ccdr::Decoder in{octets};
    T value{};
    decode(in, value);
    if (!in.ok()) return;
    const Bytes read = octets.first(octets.size() - in.remaining());
    const auto again = encoded(value, read.size());
    if (!std::equal(read.begin(), read.end(), again.begin())) std::abort();
}

/// For types of whose octets some are read but not written: then those that are written must be
/// read as the same again.
template <typename T>
void check_normal_form(Bytes octets) {
    ccdr::Decoder in{octets};
    T value{};
    decode(in, value);
    if (!in.ok()) return;
    const auto normal = encoded(value, octets.size() - in.remaining());
    check<T>(Bytes{normal});
}

template <typename T>
void check_taking(const Any& any) {
    T value{};
    if (!(any >>= value)) return;
    // Its octets are the same, though its type may have another name or bound.
    Any again;
    again <<= value;
    if constexpr (!std::same_as<T, long double>) {
        if (!std::equal(any.value().begin(), any.value().end(), again.value().begin(),
                        again.value().end())) {
            std::abort();
        }
    }
}

void check_any(Bytes octets) {
    check<Any>(octets);
    ccdr::Decoder in{octets};
    Any any;
    decode(in, any);
    check_taking<bool>(any);
    check_taking<std::uint16_t>(any);
    check_taking<std::string>(any);
    check_taking<std::u16string>(any);
    check_taking<std::vector<std::int32_t>>(any);
    check_taking<canorb::Fixed<5, 2>>(any);
    check_taking<canorb::TypeCode>(any);
    check_taking<long double>(any);
    check_taking<std::vector<Any>>(any);
    const canorb::TypeCode& type = any.type();
    if (!type.equivalent(type) || !type.accepts(type)) std::abort();
}

/// The first octets are a type code, or what is taken for one; the others another.
void check_type_codes(Bytes octets) {
    check<canorb::TypeCode>(octets);
    const std::string text{reinterpret_cast<const char*>(octets.data()), octets.size()};
    const canorb::TypeCode a{text.substr(0, text.size() / 2)};
    const canorb::TypeCode b{text.substr(text.size() / 2)};
    if (a.equivalent(b) != b.equivalent(a)) std::abort();
    if (a.equivalent(b) && !a.accepts(b)) std::abort();
    a.id();
}

void check_fixed_text(Bytes octets) {
    const std::string_view text{reinterpret_cast<const char*>(octets.data()), octets.size()};
    const canorb::Fixed<7, 3> value{text};
    if (!value.is_out_of_range() && canorb::Fixed<7, 3>{value.to_string()} != value) std::abort();
    double number = 0;
    ccdr::Decoder in{octets};
    decode(in, number);
    const canorb::Fixed<31, 16> wide{number};
    if (wide.is_out_of_range()) return;
    if (canorb::Fixed<31, 16>{wide.to_string()} != wide) std::abort();
    // 16 digits behind the point are exact to half of the last.
    const double error = double{wide} - number;
    if (error > 1e-16 || error < -1e-16) std::abort();
}

using Check = void (*)(Bytes);
constexpr Check checks[] = {
    check<bool>,
    check<char>,
    check<std::int8_t>,
    check<std::uint8_t>,
    check<std::int16_t>,
    check<std::uint16_t>,
    check<std::int32_t>,
    check<std::uint32_t>,
    check<std::int64_t>,
    check<std::uint64_t>,
    check<float>,
    check<double>,
    check<std::string>,
    check<BoundedString<8>>,
    check<std::array<std::int32_t, 3>>,
    check<std::vector<bool>>,
    check<std::vector<std::uint8_t>>,
    check<std::vector<std::uint32_t>>,
    check<std::vector<std::string>>,
    check<std::vector<std::vector<std::vector<std::int16_t>>>>,
    check<BoundedVector<std::uint16_t, 5>>,
    check<BoundedVector<std::uint8_t, 5>>,
    check<std::vector<BoundedString<3>>>,
    check<Record>,
    check<std::vector<Record>>,
    check<char16_t>,
    check<std::u16string>,
    check<std::vector<std::u16string>>,
    check_normal_form<long double>,
    check<canorb::Fixed<5, 2>>,
    check<canorb::Fixed<31, 31>>,
    check<std::vector<canorb::Fixed<2, 1>>>,
    check_normal_form<std::map<std::int16_t, std::string>>,
    check_normal_form<std::map<std::string, std::map<bool, std::u16string>>>,
    check<Alarms>,
    check<std::vector<std::vector<Empty>>>,
    check<BoundedVector<Empty, 9>>,
    check<Tree>,
    check<std::vector<Any>>,
    check_any,
    check_any,
    check_any,
    check_type_codes,
    check_fixed_text,
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    checks[data[0] % std::size(checks)](Bytes{data + 1, size - 1});
    return 0;
}
