#include "orb/ccdr/encoder.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "orb/ccdr/binary128.hpp"
#include "orb/ccdr/format.hpp"

namespace canorb::ccdr {

void Encoder::fail(EncodeError error) {
    if (error_ == EncodeError::none) error_ = error;
    limit_ = size_;
}

void Encoder::octets(Bytes value) {
    if (value.empty() || !has_room(value.size())) return;
    std::memcpy(advance(value.size()), value.data(), value.size());
}

namespace {

const VariableForm& shortest_unsigned_form(std::uint32_t value) {
    for (const VariableForm& form : variable_forms) {
        if (form.payload_bits >= 32 || value < (std::uint32_t{1} << form.payload_bits)) return form;
    }
    return variable_forms[std::size(variable_forms) - 1];
}

const VariableForm& shortest_signed_form(std::int32_t value) {
    for (const VariableForm& form : variable_forms) {
        if (form.payload_bits >= 32) return form;
        const std::int32_t limit = std::int32_t{1} << (form.payload_bits - 1);
        if (value >= -limit && value < limit) return form;
    }
    return variable_forms[std::size(variable_forms) - 1];
}

}  // namespace

void Encoder::long_unsigned(std::uint32_t value) {
    write(shortest_unsigned_form(value), value);
}

void Encoder::long_signed(std::int32_t value) {
    write(shortest_signed_form(value), static_cast<std::uint32_t>(value));
}

void Encoder::write(const VariableForm& form, std::uint32_t bits) {
    if (!has_room(form.octets)) return;
    std::uint8_t* to = advance(form.octets);
    for (std::size_t i = form.octets; i-- > 0; bits >>= 8) to[i] = static_cast<std::uint8_t>(bits);
    to[0] = static_cast<std::uint8_t>((to[0] & ~form.lead_mask) | form.lead);
}

void Encoder::count(std::size_t value, std::size_t element_octets) {
    if (value > std::numeric_limits<std::uint32_t>::max()) return fail();
    if (element_octets == 0) {
        if (value > highest_octetless - octetless_) return fail();
        octetless_ += static_cast<std::uint32_t>(value);
    }
    variable_unsigned(static_cast<std::uint32_t>(value));
}

void Encoder::string(std::string_view value) {
    if (value.find('\0') != std::string_view::npos) return fail();
    count(value.size() + 1);
    if (!has_room(value.size() + 1)) return;
    std::uint8_t* to = advance(value.size() + 1);
    if (!value.empty()) std::memcpy(to, value.data(), value.size());
    to[value.size()] = 0;
}

void Encoder::wide_string(std::u16string_view value) {
    if (value.find(u'\0') != std::u16string_view::npos) return fail();
    count(value.size() + 1);
    if (!has_room(2 * (value.size() + 1))) return;
    for (const char16_t unit : value) write_be16(advance(2), unit);
    write_be16(advance(2), 0);
}

bool Encoder::enter() {
    if (++levels_ > highest_levels) fail();
    return error_ == EncodeError::none;
}

void encode(Encoder& out, long double value) {
    const Binary128 bits = to_binary128(value);
    out.fixed64(bits.high);
    out.fixed64(bits.low);
}
void encode(Encoder& out, char16_t value) {
    out.octet(static_cast<std::uint8_t>(value >> 8));
    out.octet(static_cast<std::uint8_t>(value & 0xFF));
}

}  // namespace canorb::ccdr
