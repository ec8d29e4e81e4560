#include "orb/ccdr/encoder.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "orb/ccdr/binary128.hpp"
#include "orb/ccdr/format.hpp"

namespace canorb::ccdr {

void Encoder::fail(EncodeError error) {
    if (error_ == EncodeError::none) error_ = error;
}

std::uint8_t* Encoder::reserve(std::size_t octets) {
    if (error_ != EncodeError::none) return nullptr;
    if (buffer_.size() - size_ < octets) {
        fail(EncodeError::buffer_full);
        return nullptr;
    }
    std::uint8_t* start = buffer_.data() + size_;
    size_ += octets;
    return start;
}

void Encoder::octet(std::uint8_t value) {
    if (std::uint8_t* to = reserve(1)) *to = value;
}

void Encoder::octets(Bytes value) {
    if (std::uint8_t* to = reserve(value.size())) std::copy(value.begin(), value.end(), to);
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

void Encoder::variable_unsigned(std::uint32_t value) {
    const VariableForm& form = shortest_unsigned_form(value);
    std::uint8_t* to = reserve(form.octets);
    if (to == nullptr) return;
    for (std::size_t i = form.octets; i-- > 0; value >>= 8)
        to[i] = static_cast<std::uint8_t>(value);
    to[0] = static_cast<std::uint8_t>((to[0] & ~form.lead_mask) | form.lead);
}

void Encoder::variable_signed(std::int32_t value) {
    const VariableForm& form = shortest_signed_form(value);
    std::uint8_t* to = reserve(form.octets);
    if (to == nullptr) return;
    auto bits = static_cast<std::uint32_t>(value);
    for (std::size_t i = form.octets; i-- > 0; bits >>= 8) to[i] = static_cast<std::uint8_t>(bits);
    to[0] = static_cast<std::uint8_t>((to[0] & ~form.lead_mask) | form.lead);
}

void Encoder::fixed32(std::uint32_t value) {
    if (std::uint8_t* to = reserve(4)) {
        for (std::size_t i = 4; i-- > 0; value >>= 8) to[i] = static_cast<std::uint8_t>(value);
    }
}

void Encoder::fixed64(std::uint64_t value) {
    if (std::uint8_t* to = reserve(8)) {
        for (std::size_t i = 8; i-- > 0; value >>= 8) to[i] = static_cast<std::uint8_t>(value);
    }
}

void Encoder::count(std::size_t value, std::size_t element_octets) {
    if (value > std::numeric_limits<std::uint32_t>::max()) return fail();
    if (element_octets == 0) {
        if (value > highest_octetless - octetless_) return fail();
        octetless_ += value;
    }
    variable_unsigned(static_cast<std::uint32_t>(value));
}

void Encoder::string(std::string_view value) {
    if (value.find('\0') != std::string_view::npos) return fail();
    count(value.size() + 1);
    if (std::uint8_t* to = reserve(value.size() + 1)) {
        std::copy(value.begin(), value.end(), to);
        to[value.size()] = 0;
    }
}

void Encoder::wide_string(std::u16string_view value) {
    if (value.find(u'\0') != std::u16string_view::npos) return fail();
    count(value.size() + 1);
    if (std::uint8_t* to = reserve(2 * (value.size() + 1))) {
        for (const char16_t unit : value) {
            write_be16(to, unit);
            to += 2;
        }
        write_be16(to, 0);
    }
}

bool Encoder::enter() {
    if (++levels_ > highest_levels) fail();
    return error_ == EncodeError::none;
}

void encode(Encoder& out, bool value) {
    out.octet(value ? 1 : 0);
}
void encode(Encoder& out, char value) {
    out.octet(static_cast<std::uint8_t>(value));
}
void encode(Encoder& out, std::int8_t value) {
    out.octet(static_cast<std::uint8_t>(value));
}
void encode(Encoder& out, std::uint8_t value) {
    out.octet(value);
}
void encode(Encoder& out, std::int16_t value) {
    out.variable_signed(value);
}
void encode(Encoder& out, std::uint16_t value) {
    out.variable_unsigned(value);
}
void encode(Encoder& out, std::int32_t value) {
    out.variable_signed(value);
}
void encode(Encoder& out, std::uint32_t value) {
    out.variable_unsigned(value);
}
void encode(Encoder& out, std::int64_t value) {
    out.fixed64(static_cast<std::uint64_t>(value));
}
void encode(Encoder& out, std::uint64_t value) {
    out.fixed64(value);
}
void encode(Encoder& out, float value) {
    out.fixed32(std::bit_cast<std::uint32_t>(value));
}
void encode(Encoder& out, double value) {
    out.fixed64(std::bit_cast<std::uint64_t>(value));
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
void encode(Encoder& out, std::string_view value) {
    out.string(value);
}
void encode(Encoder& out, std::u16string_view value) {
    out.wide_string(value);
}

}  // namespace canorb::ccdr
