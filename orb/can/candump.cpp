#include "orb/can/candump.hpp"

#include <algorithm>
#include <optional>

namespace canorb::can {
namespace {

constexpr std::uint32_t error_flag = 0x20000000;    // CAN_ERR_FLAG of linux/can.h
constexpr std::size_t longest_interface_name = 15;  // IFNAMSIZ - 1
constexpr std::size_t seconds_digits = 10;
constexpr std::size_t longest_seconds = 10;  // beyond, nanoseconds overflow
constexpr std::uint64_t highest_seconds = 9'223'372'035;

void append_digits(std::string& out, std::uint64_t value, std::size_t width) {
    const std::string digits = std::to_string(value);
    if (digits.size() < width) out.append(width - digits.size(), '0');
    out += digits;
}

void append_hex(std::string& out, std::uint32_t value, int width) {
    for (int shift = 4 * (width - 1); shift >= 0; shift -= 4) {
        out += "0123456789ABCDEF"[(value >> shift) & 0xFU];
    }
}

std::optional<std::uint32_t> hex_digit(char c) {
    if (c >= '0' && c <= '9') return static_cast<std::uint32_t>(c - '0');
    if (c >= 'A' && c <= 'F') return static_cast<std::uint32_t>(c - 'A' + 10);
    if (c >= 'a' && c <= 'f') return static_cast<std::uint32_t>(c - 'a' + 10);
    return std::nullopt;
}

std::optional<std::uint32_t> parse_hex(std::string_view digits) {
    std::uint32_t value = 0;
    for (const char c : digits) {
        const auto digit = hex_digit(c);
        if (!digit) return std::nullopt;
        value = (value << 4) | *digit;
    }
    return value;
}

std::optional<std::uint64_t> parse_decimal(std::string_view digits) {
    if (digits.empty()) return std::nullopt;
    std::uint64_t value = 0;
    for (const char c : digits) {
        if (c < '0' || c > '9') return std::nullopt;
        value = value * 10 + static_cast<std::uint64_t>(c - '0');
    }
    return value;
}

/// Takes what is before the first `end` (which goes too) off the front of `text`.
std::optional<std::string_view> take_until(std::string_view& text, char end) {
    const std::size_t at = text.find(end);
    if (at == std::string_view::npos) return std::nullopt;
    const std::string_view taken = text.substr(0, at);
    text.remove_prefix(at + 1);
    return taken;
}

std::optional<TimePoint> parse_time(std::string_view text) {
    const auto seconds_text = take_until(text, '.');
    if (!seconds_text || seconds_text->size() > longest_seconds || text.size() != 6) {
        return std::nullopt;
    }
    const auto seconds = parse_decimal(*seconds_text);
    const auto microseconds = parse_decimal(text);
    if (!seconds || !microseconds || *seconds > highest_seconds) return std::nullopt;
    return TimePoint{
        Duration{static_cast<Duration::rep>(*seconds * 1'000'000'000U + *microseconds * 1'000U)}};
}

bool parse_identifier(std::string_view text, Frame& frame) {
    if (text.size() != 3 && text.size() != 8) return false;
    const auto id = parse_hex(text);
    if (!id) return false;
    frame.id = *id;
    if (text.size() == 3) return frame.id <= highest_id(false);
    frame.error = (*id & error_flag) != 0;
    frame.extended = !frame.error;
    frame.id = *id & ~error_flag;
    return frame.id <= highest_id(true);
}

bool is_fd_length(std::size_t octets) {
    return octets <= 8 || octets == 12 || octets == 16 || octets == 20 || octets == 24 ||
           octets == 32 || octets == 48 || octets == 64;
}

/// A DLC of 9 to 15 with 8 octets: "_9" to "_F".
bool is_raw_dlc(std::string_view text, const Frame& frame) {
    if (text.size() != 2 || text[0] != '_' || frame.fd || frame.length != 8) return false;
    const auto digit = hex_digit(text[1]);
    return digit && *digit >= 9;
}

bool parse_remote(std::string_view text, Frame& frame) {
    frame.remote = true;
    if (frame.error || frame.fd) return false;
    if (text.empty()) return true;
    const auto length = hex_digit(text[0]);
    if (!length || *length > Frame::max_classic_payload) return false;
    frame.length = static_cast<std::uint8_t>(*length);
    text.remove_prefix(1);
    return text.empty() || is_raw_dlc(text, frame);
}

/// `text` is what follows the first '#'.
bool parse_content(std::string_view text, Frame& frame) {
    if (!text.empty() && text[0] == '#') {
        if (text.size() < 2 || !hex_digit(text[1]) || frame.error) return false;
        frame.fd = true;
        text.remove_prefix(2);
    } else if (!text.empty() && (text[0] == 'R' || text[0] == 'r')) {
        return parse_remote(text.substr(1), frame);
    }
    const std::size_t limit = frame.fd ? Frame::max_payload : Frame::max_classic_payload;
    std::size_t length = 0;
    while (text.size() >= 2 && text[0] != '_') {
        if (text[0] == '.') text.remove_prefix(1);  // allowed between octets
        if (text.size() < 2 || length == limit) return false;
        const auto octet = parse_hex(text.substr(0, 2));
        if (!octet) return false;
        frame.data[length++] = static_cast<std::uint8_t>(*octet);
        text.remove_prefix(2);
    }
    frame.length = static_cast<std::uint8_t>(length);
    return is_fd_length(length) && (text.empty() || is_raw_dlc(text, frame));
}

}  // namespace

std::string_view name(CandumpError error) {
    switch (error) {
        case CandumpError::time:
            return "bad time stamp";
        case CandumpError::interface:
            return "bad interface name";
        case CandumpError::identifier:
            return "bad identifier";
        case CandumpError::data:
            return "bad data";
        case CandumpError::trailing:
            return "text after the frame";
    }
    return "?";
}

std::string format_candump(TimePoint time, std::string_view interface, const Frame& frame) {
    const auto since_start = std::max(time.time_since_epoch(), Duration::zero());
    const auto microseconds = static_cast<std::uint64_t>(since_start.count()) / 1'000U;
    std::string line = "(";
    append_digits(line, microseconds / 1'000'000U, seconds_digits);
    line += '.';
    append_digits(line, microseconds % 1'000'000U, 6);
    line += ") ";
    line += interface;
    line += ' ';
    if (frame.error) {
        append_hex(line, frame.id | error_flag, 8);
    } else {
        append_hex(line, frame.id, frame.extended ? 8 : 3);
    }
    line += '#';
    if (frame.remote) {
        line += 'R';
        if (frame.length > 0) append_hex(line, frame.length, 1);
        return line;
    }
    if (frame.fd) line += "#0";
    for (const std::uint8_t octet : frame.payload()) append_hex(line, octet, 2);
    return line;
}

Result<CandumpLine, CandumpError> parse_candump(std::string_view line) {
    CandumpLine result;
    if (line.empty() || line[0] != '(') return Failure{CandumpError::time};
    line.remove_prefix(1);
    const auto time_text = take_until(line, ')');
    const auto time = time_text ? parse_time(*time_text) : std::nullopt;
    if (!time || line.empty() || line[0] != ' ') return Failure{CandumpError::time};
    result.time = *time;
    line.remove_prefix(1);

    const auto interface = take_until(line, ' ');
    if (!interface || interface->empty() || interface->size() > longest_interface_name) {
        return Failure{CandumpError::interface};
    }
    result.interface = std::string{*interface};

    const auto identifier = take_until(line, '#');
    if (!identifier || !parse_identifier(*identifier, result.frame)) {
        return Failure{CandumpError::identifier};
    }
    const std::size_t end = std::min(line.find(' '), line.size());
    if (!parse_content(line.substr(0, end), result.frame)) return Failure{CandumpError::data};
    line.remove_prefix(end);
    if (!line.empty() && line != " T" && line != " R") return Failure{CandumpError::trailing};
    return result;
}

}  // namespace canorb::can
