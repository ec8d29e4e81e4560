#include "tools/console/integers.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

namespace canorb::console {
namespace {

template <typename Integer>
IntegerRange range_of() {
    return {static_cast<std::int64_t>(std::numeric_limits<Integer>::min()),
            static_cast<std::uint64_t>(std::numeric_limits<Integer>::max())};
}

template <typename Integer>
std::uint64_t decode_as(ccdr::Decoder& in) {
    Integer value{};
    decode(in, value);
    return static_cast<std::uint64_t>(value);
}

}  // namespace

std::string IntegerRange::text() const {
    return std::to_string(lowest) + " to " + std::to_string(highest);
}

IntegerRange integer_range(Kind kind) {
    switch (kind) {
        case Kind::int8:
            return range_of<std::int8_t>();
        case Kind::int16:
            return range_of<std::int16_t>();
        case Kind::uint16:
            return range_of<std::uint16_t>();
        case Kind::int32:
            return range_of<std::int32_t>();
        case Kind::uint32:
            return range_of<std::uint32_t>();
        case Kind::int64:
            return range_of<std::int64_t>();
        case Kind::uint64:
            return range_of<std::uint64_t>();
        default:
            return range_of<std::uint8_t>();
    }
}

std::optional<std::uint64_t> parse_integer(std::string_view text, const IntegerRange& range) {
    const bool is_negative = text.starts_with('-');
    if (is_negative || text.starts_with('+')) text.remove_prefix(1);
    const bool is_hex = text.starts_with("0x");
    if (is_hex) text.remove_prefix(2);
    std::uint64_t magnitude = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, magnitude, is_hex ? 16 : 10);
    if (error != std::errc{} || rest != end) return std::nullopt;
    if (!is_negative) {
        if (magnitude > range.highest) return std::nullopt;
        return magnitude;
    }
    const std::uint64_t most_negative = 0 - static_cast<std::uint64_t>(range.lowest);
    if (magnitude > most_negative) return std::nullopt;
    return 0 - magnitude;
}

void encode_integer(ccdr::Encoder& out, Kind kind, std::uint64_t bits) {
    switch (kind) {
        case Kind::int16:
        case Kind::int32:
            return out.variable_signed(static_cast<std::int32_t>(bits));
        case Kind::uint16:
        case Kind::uint32:
            return out.variable_unsigned(static_cast<std::uint32_t>(bits));
        case Kind::int64:
        case Kind::uint64:
            return out.fixed64(bits);
        case Kind::wide_character:
            return encode(out, static_cast<char16_t>(bits));
        default:
            return out.octet(static_cast<std::uint8_t>(bits));
    }
}

std::uint64_t decode_integer(ccdr::Decoder& in, Kind kind) {
    switch (kind) {
        case Kind::int8:
            return decode_as<std::int8_t>(in);
        case Kind::int16:
            return decode_as<std::int16_t>(in);
        case Kind::uint16:
            return decode_as<std::uint16_t>(in);
        case Kind::int32:
            return decode_as<std::int32_t>(in);
        case Kind::uint32:
            return decode_as<std::uint32_t>(in);
        case Kind::int64:
        case Kind::uint64:
            return in.fixed64();
        default:
            return in.octet();
    }
}

std::int64_t decode_label(ccdr::Decoder& in, Kind kind) {
    switch (kind) {
        case Kind::boolean:
            return static_cast<std::int64_t>(decode_as<bool>(in));
        case Kind::wide_character:
            return static_cast<std::int64_t>(decode_as<char16_t>(in));
        case Kind::enumeration:
            return static_cast<std::int64_t>(decode_as<std::uint32_t>(in));
        default:
            return static_cast<std::int64_t>(decode_integer(in, kind));
    }
}

const Member* selected_member(const Definition& choice, std::int64_t label) {
    const Member* selected = nullptr;
    for (const Member& member : choice.members) {
        if (std::find(member.labels.begin(), member.labels.end(), label) != member.labels.end())
            return &member;
        if (member.is_default) selected = &member;
    }
    return selected;
}

Kind kind_of_bitmask(const Definition& bitmask) {
    if (bitmask.bit_bound <= 8) return Kind::uint8;
    if (bitmask.bit_bound <= 16) return Kind::uint16;
    return bitmask.bit_bound <= 32 ? Kind::uint32 : Kind::uint64;
}

bool takes_no_octets(const Type& type) {
    if (type.kind == Kind::array) return takes_no_octets(*type.element);
    if (type.kind != Kind::structure) return false;
    const auto& members = type.definition->members;
    return std::all_of(members.begin(), members.end(),
                       [](const Member& each) { return takes_no_octets(each.type); });
}

}  // namespace canorb::console
