#include "orb/can/link/slcan_protocol.hpp"

#include <algorithm>

namespace canorb::can::slcan {
namespace {

constexpr char bel = '\a';
constexpr unsigned standard_digits = 3;
constexpr unsigned extended_digits = 8;
constexpr std::size_t time_stamp_digits = 4;
/// The first letters of lines in which no frame can have been lost.
constexpr std::string_view harmless = "CFLNOSVXZesz";

std::optional<std::uint32_t> digits(std::string_view text, std::uint32_t base) {
    std::uint32_t value = 0;
    for (const char c : text) {
        std::uint32_t digit = base;
        if (c >= '0' && c <= '9') digit = static_cast<std::uint32_t>(c - '0');
        if (c >= 'A' && c <= 'F') digit = static_cast<std::uint32_t>(c - 'A') + 10;
        if (c >= 'a' && c <= 'f') digit = static_cast<std::uint32_t>(c - 'a') + 10;
        if (digit >= base) return std::nullopt;
        value = value * base + digit;
    }
    return value;
}

std::optional<std::uint32_t> hex(std::string_view text) {
    return digits(text, 16);
}

/// The letter is one of t, T, r, R.
std::optional<Frame> parse_frame(std::string_view line) {
    Frame frame;
    frame.extended = line[0] == 'T' || line[0] == 'R';
    frame.remote = line[0] == 'r' || line[0] == 'R';
    const std::size_t id_digits = frame.extended ? extended_digits : standard_digits;
    line.remove_prefix(1);
    if (line.size() < id_digits + 1) return std::nullopt;
    const auto id = hex(line.substr(0, id_digits));
    const char length = line[id_digits];
    line.remove_prefix(id_digits + 1);
    if (!id || *id > highest_id(frame.extended) || length < '0' || length > '8') {
        return std::nullopt;
    }
    frame.id = *id;
    frame.length = static_cast<std::uint8_t>(length - '0');
    const std::size_t octets = frame.remote ? 0 : frame.length;
    const bool has_time = line.size() == octets * 2 + time_stamp_digits;
    if ((!has_time && line.size() != octets * 2) || !hex(line.substr(octets * 2))) {
        return std::nullopt;
    }
    for (std::size_t i = 0; i < octets; ++i) {
        const auto octet = hex(line.substr(i * 2, 2));
        if (!octet) return std::nullopt;
        frame.data[i] = static_cast<std::uint8_t>(*octet);
    }
    return frame;
}

/// "saRRRTTT": error active, warning, passive or bus-off, then REC and TEC in decimal.
std::optional<ErrorStatus> parse_state(std::string_view line) {
    if (line.size() != 8) return std::nullopt;
    const auto rec = digits(line.substr(2, 3), 10);
    const auto tec = digits(line.substr(5, 3), 10);
    if (!rec || !tec) return std::nullopt;
    ErrorStatus status;
    status.rec = static_cast<std::uint16_t>(*rec);
    status.tec = static_cast<std::uint16_t>(*tec);
    switch (line[1]) {
        case 'a':
        case 'w':
            break;
        case 'p':
            status.state = ControllerState::error_passive;
            break;
        case 'b':
            status.state = ControllerState::bus_off;
            break;
        default:
            return std::nullopt;
    }
    return status;
}

}  // namespace

std::optional<char> bitrate_digit(std::uint32_t bitrate) {
    const auto found = std::find(bitrates.begin(), bitrates.end(), bitrate);
    if (found == bitrates.end()) return std::nullopt;
    return static_cast<char>('0' + (found - bitrates.begin()));
}

void Command::append_hex(std::uint32_t value, unsigned count) {
    while (count > 0) {
        --count;
        append("0123456789ABCDEF"[value >> (4 * count) & 0xF]);
    }
}

Command bitrate_command(std::uint32_t bitrate) {
    Command command;
    command.append('S');
    command.append(*bitrate_digit(bitrate));
    command.append('\r');
    return command;
}

Command transmit_command(const Frame& frame) {
    Command command;
    if (frame.extended) {
        command.append(frame.remote ? 'R' : 'T');
        command.append_hex(frame.id, extended_digits);
    } else {
        command.append(frame.remote ? 'r' : 't');
        command.append_hex(frame.id, standard_digits);
    }
    command.append_hex(frame.length, 1);
    for (const std::uint8_t octet : frame.payload()) command.append_hex(octet, 2);
    command.append('\r');
    return command;
}

Message parse_line(std::string_view line) {
    if (line.empty() || line == "z" || line == "Z") return Done{};
    switch (line[0]) {
        case 't':
        case 'T':
        case 'r':
        case 'R':
            if (const auto frame = parse_frame(line)) return *frame;
            return Malformed{};
        case 'F':
            if (line.size() == 3) {
                if (const auto bits = hex(line.substr(1))) {
                    return Flags{static_cast<std::uint8_t>(*bits)};
                }
            }
            return Ignored{};
        case 'V':
            if (line.size() > 1) return Version{};
            return Ignored{};
        case 's':
            if (const auto status = parse_state(line)) return *status;
            return Ignored{};
        default:
            if (harmless.find(line[0]) != std::string_view::npos) return Ignored{};
            return Malformed{};
    }
}

std::optional<Message> Receiver::add(char octet) {
    if (octet != '\r' && octet != bel) {
        if (size_ < longest_line) {
            line_[size_++] = octet;
        } else {
            size_ = longest_line + 1;
        }
        return std::nullopt;
    }
    const std::size_t size = size_;
    size_ = 0;
    if (octet == bel) return Refused{size > 0};
    if (size > longest_line) return Malformed{};
    return parse_line({line_.data(), size});
}

}  // namespace canorb::can::slcan
