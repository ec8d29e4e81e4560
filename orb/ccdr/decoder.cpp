#include "orb/ccdr/decoder.hpp"

#include <limits>

#include "orb/ccdr/binary128.hpp"
#include "orb/ccdr/format.hpp"

namespace canorb::ccdr {

Decoder::Variable Decoder::variable() {
    const std::uint8_t first = octet();
    if (!ok_) return {};
    for (std::size_t i = 0; i < std::size(variable_forms); ++i) {
        const VariableForm& form = variable_forms[i];
        if ((first & form.lead_mask) != form.lead) continue;
        std::uint32_t bits = first & static_cast<std::uint8_t>(~form.lead_mask);
        for (const std::uint8_t octet : octets(form.octets - 1)) bits = (bits << 8) | octet;
        return {i, ok_ ? bits : 0};
    }
    fail();
    return {};
}

std::uint32_t Decoder::long_unsigned(std::uint32_t highest) {
    const auto [form, value] = variable();
    const bool fits_shorter =
        form > 0 && value < (std::uint32_t{1} << variable_forms[form - 1].payload_bits);
    if (!ok_ || fits_shorter || value > highest) {
        fail();
        return 0;
    }
    return value;
}

std::int32_t Decoder::variable_signed(std::int32_t lowest, std::int32_t highest) {
    const auto [form, bits] = variable();
    if (!ok_) return 0;
    const unsigned unused = 32 - variable_forms[form].payload_bits;
    const std::int32_t value = static_cast<std::int32_t>(bits << unused) >> unused;
    bool fits_shorter = false;
    if (form > 0) {
        const std::int32_t limit = std::int32_t{1} << (variable_forms[form - 1].payload_bits - 1);
        fits_shorter = value >= -limit && value < limit;
    }
    if (fits_shorter || value < lowest || value > highest) {
        fail();
        return 0;
    }
    return value;
}

std::string_view Decoder::string() {
    const Bytes taken = octets(count());
    if (!ok_ || taken.empty()) {
        fail();
        return {};
    }
    const std::string_view text{reinterpret_cast<const char*>(taken.data()), taken.size()};
    if (text.find('\0') != text.size() - 1) {
        fail();
        return {};
    }
    return text.substr(0, text.size() - 1);
}

Bytes Decoder::wide_string(std::size_t highest) {
    const std::size_t units = count(2);
    const Bytes taken = octets(2 * units);
    const auto unit = [taken](std::size_t i) { return read_be16(taken.data() + 2 * i); };
    bool whole = ok_ && units > 0 && units - 1 <= highest && unit(units - 1) == 0;
    for (std::size_t i = 0; whole && i + 1 < units; ++i) whole = unit(i) != 0;
    if (!whole) {
        fail();
        return {};
    }
    return taken.first(2 * (units - 1));
}

bool Decoder::enter() {
    if (++levels_ > highest_levels) fail();
    return ok_;
}

namespace {

template <typename T>
void decode_signed(Decoder& in, T& value) {
    value = static_cast<T>(
        in.variable_signed(std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
}

}  // namespace

void decode(Decoder& in, std::int16_t& value) {
    decode_signed(in, value);
}
void decode(Decoder& in, std::int32_t& value) {
    decode_signed(in, value);
}
void decode(Decoder& in, long double& value) {
    Binary128 bits{};
    bits.high = in.fixed64();
    bits.low = in.fixed64();
    value = from_binary128<long double>(bits);
}
void decode(Decoder& in, char16_t& value) {
    const Bytes taken = in.octets(2);
    value = taken.empty() ? u'\0' : char16_t{read_be16(taken.data())};
}
void decode(Decoder& in, std::string& value) {
    const std::string_view text = in.string();
    // A new string is made faster than one that was empty is enlarged.
    if (text.size() > value.capacity()) {
        value = std::string{text};
    } else {
        value.assign(text);
    }
}
void decode(Decoder& in, std::u16string& value) {
    assign(value, in.wide_string());
}

void assign(std::u16string& text, Bytes units) {
    text.clear();
    text.reserve(units.size() / 2);
    for (std::size_t i = 0; i < units.size(); i += 2) text += char16_t{read_be16(&units[i])};
}

}  // namespace canorb::ccdr
