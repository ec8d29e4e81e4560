#include "orb/core/reference.hpp"

#include <charconv>
#include <optional>
#include <vector>

#include "orb/base/minor_codes.hpp"

namespace canorb::core {
namespace {

constexpr std::uint8_t caniop_profile = 0;
constexpr std::uint8_t nil_profile = 0xFF;
constexpr std::uint8_t object_type = 0;
constexpr std::uint8_t group_type = 1;

constexpr std::string_view ior_prefix = "CAN_IOR:";
constexpr std::string_view corbaloc_prefix = "corbaloc:caniop:";
constexpr std::string_view group_prefix = "group/";

/// Plain decimal: digits only, no sign, no leading zeros.
std::optional<unsigned> parse_decimal(std::string_view text) {
    if (text.empty() || (text.size() > 1 && text.front() == '0')) return std::nullopt;
    unsigned value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<std::uint8_t> hex_digit(char c) {
    if (c >= '0' && c <= '9') return static_cast<std::uint8_t>(c - '0');
    if (c >= 'a' && c <= 'f') return static_cast<std::uint8_t>(c - 'a' + 10);
    if (c >= 'A' && c <= 'F') return static_cast<std::uint8_t>(c - 'A' + 10);
    return std::nullopt;
}

Failure<ReferenceError> bad_param(std::string_view why) {
    return {{cause::bad_reference_text, why}};
}

Failure<ReferenceError> inv_objref(std::string_view why) {
    return {{cause::bad_reference_octets, why}};
}

Result<Reference, ReferenceError> parse_ior(std::string_view hex) {
    if (hex.empty()) return inv_objref("nothing follows CAN_IOR:");
    if (hex.size() % 2 != 0) return inv_objref("an odd number of hex digits");
    std::vector<std::uint8_t> octets;
    octets.reserve(hex.size() / 2);
    for (std::size_t i = 0; i < hex.size(); i += 2) {
        const auto high = hex_digit(hex[i]);
        const auto low = hex_digit(hex[i + 1]);
        if (!high || !low) return inv_objref("a character that is no hex digit");
        octets.push_back(static_cast<std::uint8_t>(*high << 4 | *low));
    }
    ccdr::Decoder in{octets};
    Reference reference;
    decode(in, reference);
    if (!in.ok()) return inv_objref("the octets are no object reference");
    if (!in.finished()) return inv_objref("octets are left over after the object reference");
    return reference;
}

Result<Reference, ReferenceError> parse_corbaloc(std::string_view address) {
    if (address.starts_with(group_prefix)) {
        const auto number = parse_decimal(address.substr(group_prefix.size()));
        const auto group = number ? GroupId::from(*number) : std::nullopt;
        if (!group) return bad_param("the group is not a number from 1 to 31");
        return Reference::to_group(*group, {});
    }
    const std::size_t slash = address.find('/');
    if (slash == std::string_view::npos) {
        return bad_param("corbaloc:caniop: wants NODE/INDEX or group/GROUP");
    }
    const auto node_number = parse_decimal(address.substr(0, slash));
    const auto node = node_number ? NodeId::from(*node_number) : std::nullopt;
    if (!node) return bad_param("the node is not a number from 0 to 30");
    const auto index = parse_decimal(address.substr(slash + 1));
    if (!index || *index > last_object_index) {
        return bad_param("the object index is not a number from 0 to 2047");
    }
    return Reference::to_object(ObjectKey{*node, static_cast<ObjectIndex>(*index)}, {});
}

}  // namespace

Reference Reference::to_object(ObjectKey key, std::string type_id) {
    Reference reference;
    reference.kind = Kind::object;
    reference.type_id = std::move(type_id);
    reference.key = key;
    return reference;
}

Reference Reference::to_group(GroupId group, std::string type_id) {
    Reference reference;
    reference.kind = Kind::group;
    reference.type_id = std::move(type_id);
    reference.group = group;
    return reference;
}

bool Reference::same_target(const Reference& other) const {
    if (kind != other.kind) return false;
    switch (kind) {
        case Kind::nil:
            return true;
        case Kind::object:
            return key == other.key;
        case Kind::group:
            return group == other.group;
    }
    return false;
}

void encode(ccdr::Encoder& out, const Reference& value) {
    switch (value.kind) {
        case Reference::Kind::nil:
            out.string("");
            out.octet(nil_profile);
            return;
        case Reference::Kind::object:
            out.string(value.type_id);
            out.octet(caniop_profile);
            out.octet(object_type);
            out.octet(value.key.node().value());
            out.octet(static_cast<std::uint8_t>(value.key.value() >> 8));
            out.octet(static_cast<std::uint8_t>(value.key.value()));
            return;
        case Reference::Kind::group:
            out.string(value.type_id);
            out.octet(caniop_profile);
            out.octet(group_type);
            out.octet(value.group.value());
            return;
    }
}

void decode(ccdr::Decoder& in, Reference& value) {
    value = Reference{};
    const std::string_view type_id = in.string();
    const std::uint8_t profile = in.octet();
    if (!in.ok()) return;
    if (profile == nil_profile) {
        if (!type_id.empty()) in.fail();
        return;
    }
    if (profile != caniop_profile) return in.fail();
    switch (in.octet()) {
        case object_type: {
            const NodeId node{in.octet()};
            const std::uint8_t high = in.octet();
            const std::uint8_t low = in.octet();
            const ObjectKey key{static_cast<std::uint16_t>(high << 8 | low)};
            if (!in.ok() || !node.is_valid() || key.node() != node) return in.fail();
            value = Reference::to_object(key, std::string{type_id});
            return;
        }
        case group_type: {
            const GroupId group{in.octet()};
            if (!in.ok() || !group.is_valid()) return in.fail();
            value = Reference::to_group(group, std::string{type_id});
            return;
        }
        default:
            return in.fail();
    }
}

std::string to_string(const Reference& reference) {
    // A type id is never longer than a message that carried it, or than generated code's constant.
    std::vector<std::uint8_t> octets(reference.type_id.size() + 16);
    ccdr::Encoder out{octets};
    encode(out, reference);
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text{ior_prefix};
    for (const std::uint8_t octet : out.octets()) {
        text += digits[octet >> 4];
        text += digits[octet & 0xF];
    }
    return text;
}

Result<Reference, ReferenceError> parse_reference(std::string_view text) {
    if (text.starts_with(ior_prefix)) return parse_ior(text.substr(ior_prefix.size()));
    if (text.starts_with(corbaloc_prefix))
        return parse_corbaloc(text.substr(corbaloc_prefix.size()));
    return bad_param("a reference begins with CAN_IOR: or corbaloc:caniop:");
}

}  // namespace canorb::core
