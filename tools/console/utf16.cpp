#include "tools/console/utf16.hpp"

#include <cstddef>
#include <cstdint>

namespace canorb::console {
namespace {

constexpr std::uint32_t first_surrogate = 0xD800;
constexpr std::uint32_t first_low_surrogate = 0xDC00;
constexpr std::uint32_t last_surrogate = 0xDFFF;
constexpr std::uint32_t first_of_pairs = 0x10000;
constexpr std::uint32_t last_code = 0x10FFFF;
constexpr std::uint32_t replacement = 0xFFFD;

bool is_surrogate(std::uint32_t code) {
    return code >= first_surrogate && code <= last_surrogate;
}

}  // namespace

std::optional<std::u16string> to_utf16(std::string_view utf8) {
    std::u16string units;
    for (std::size_t i = 0; i < utf8.size();) {
        const auto lead = static_cast<std::uint8_t>(utf8[i++]);
        unsigned trailing = 0;
        std::uint32_t code = lead;
        std::uint32_t lowest = 0;
        if (lead >= 0xF0 && lead < 0xF8) {
            trailing = 3;
            code = lead & 0x07U;
            lowest = first_of_pairs;
        } else if (lead >= 0xE0 && lead < 0xF0) {
            trailing = 2;
            code = lead & 0x0FU;
            lowest = 0x800;
        } else if (lead >= 0xC0 && lead < 0xE0) {
            trailing = 1;
            code = lead & 0x1FU;
            lowest = 0x80;
        } else if (lead >= 0x80) {
            return std::nullopt;
        }
        for (; trailing > 0; --trailing) {
            if (i == utf8.size() || (static_cast<std::uint8_t>(utf8[i]) & 0xC0U) != 0x80)
                return std::nullopt;
            code = code << 6 | (static_cast<std::uint8_t>(utf8[i++]) & 0x3FU);
        }
        if (code < lowest || code > last_code || is_surrogate(code)) return std::nullopt;
        if (code >= first_of_pairs) {
            code -= first_of_pairs;
            units += static_cast<char16_t>(first_surrogate + (code >> 10));
            units += static_cast<char16_t>(first_low_surrogate + (code & 0x3FFU));
        } else {
            units += static_cast<char16_t>(code);
        }
    }
    return units;
}

std::string to_utf8(std::u16string_view units) {
    std::string text;
    const auto octet = [&text](std::uint32_t value) { text += static_cast<char>(value); };
    for (std::size_t i = 0; i < units.size(); ++i) {
        std::uint32_t code = units[i];
        if (is_surrogate(code)) {
            const bool pair = code < first_low_surrogate && i + 1 < units.size() &&
                              units[i + 1] >= first_low_surrogate && is_surrogate(units[i + 1]);
            code = pair ? first_of_pairs + ((code - first_surrogate) << 10) +
                              (units[++i] - first_low_surrogate)
                        : replacement;
        }
        if (code < 0x80) {
            octet(code);
            continue;
        }
        if (code < 0x800) {
            octet(0xC0U | code >> 6);
        } else {
            if (code < first_of_pairs) {
                octet(0xE0U | code >> 12);
            } else {
                octet(0xF0U | code >> 18);
                octet(0x80U | (code >> 12 & 0x3FU));
            }
            octet(0x80U | (code >> 6 & 0x3FU));
        }
        octet(0x80U | (code & 0x3FU));
    }
    return text;
}

}  // namespace canorb::console
