// canorb-bits: a CAN frame bit by bit, as it is on the bus.

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orb/base/counted.hpp"
#include "orb/base/result.hpp"
#include "orb/can/candump.hpp"
#include "orb/can/frame_bits.hpp"
#include "orb/can/link/address.hpp"

namespace {

using namespace canorb;

constexpr int output_error = 1;
constexpr int usage_error = 2;

/// CiA 301's most common bit rates, in bit/s.
constexpr std::array<std::uint32_t, 4> usual_bitrates{125'000, 250'000, 500'000, 1'000'000};

int fail(const std::string& reason) {
    std::fprintf(stderr, "canorb-bits: %s\n", reason.c_str());
    return usage_error;
}

std::string hex(std::uint32_t value, int digits) {
    std::array<char, 16> text;
    std::snprintf(text.data(), text.size(), "0x%0*X", digits, value);
    return text.data();
}

Result<can::Frame, std::string> parse_frame(std::string_view text) {
    const auto refused = [text](std::string_view reason) {
        return Failure{'"' + std::string{text} + "\" is no frame: " + std::string{reason}};
    };
    const std::size_t separator = text.find('#');
    if (separator == std::string_view::npos) {
        return refused("ID#DATA is expected, for example 123#DEADBEEF, 12345678#00 or 123#R4");
    }
    // What a log has after or beside a frame is no part of it.
    if (text.find(' ') != std::string_view::npos) return refused("there is a blank in it");
    if (text.find('_') != std::string_view::npos) return refused("a DLC above 8 is not supported");
    const auto line = can::parse_candump("(0.000000) x " + std::string{text});
    if (!line && line.error() == can::CandumpError::identifier) {
        return refused(
            "bad identifier: 3 hexadecimal digits up to 7FF, or 8 up to 1FFFFFFF for an extended "
            "frame, are expected before the '#'");
    }
    if (!line) {
        return refused(
            "bad data: up to 8 octets of 2 hexadecimal digits each, or R with a digit up to 8 for "
            "a remote frame, are expected after the '#'");
    }
    if (line->frame.fd) return refused("CAN FD is not supported");
    if (line->frame.error) return refused("error frames of SocketCAN are not on the bus");
    return line->frame;
}

/// A field, or an octet of the data, on its line of the table.
struct Row {
    std::string field;
    std::string value;
    std::string bits;
};

std::string field_of(const can::Frame& frame, can::FramePosition position) {
    switch (position.field) {
        case can::FrameField::remote_request:
            if (frame.extended) return "SRR";  // what receivers find it to be
            break;
        case can::FrameField::extended_remote_request:
            return "RTR";
        case can::FrameField::data:
            return "data " + std::to_string(position.index / 8);
        default:
            break;
    }
    return std::string{name(position.field)};
}

std::string value_of(const can::Frame& frame, can::FramePosition position, std::uint16_t crc) {
    switch (position.field) {
        case can::FrameField::identifier:
            return hex(frame.extended ? frame.id >> 18 : frame.id, 3);
        case can::FrameField::extended_identifier:
            return hex(frame.id & 0x3FFFF, 5);
        case can::FrameField::data_length_code:
            return std::to_string(frame.length);
        case can::FrameField::data:
            return hex(frame.data[position.index / 8U], 2);
        case can::FrameField::crc:
            return hex(crc, 4);
        default:
            return {};
    }
}

std::vector<Row> rows_of(const can::Frame& frame, const can::FrameBits& bits) {
    std::vector<Row> rows;
    for (const can::FrameBit& bit : bits) {
        std::string field = field_of(frame, bit.position);
        if (rows.empty() || rows.back().field != field) {
            rows.push_back({std::move(field), value_of(frame, bit.position, bits.crc), {}});
        }
        const char digit = bit.level == 0 ? '0' : '1';
        if (bit.position.stuff) {
            rows.back().bits += {'(', digit, ')'};
        } else {
            rows.back().bits += digit;
        }
    }
    return rows;
}

/// In microseconds, to the nanosecond.
std::string time_of(std::size_t bits, std::uint32_t bitrate) {
    const std::uint64_t nanoseconds = (bits * std::uint64_t{1'000'000'000} + bitrate / 2) / bitrate;
    std::array<char, 40> text;
    std::snprintf(text.data(), text.size(), "%llu.%03llu us",
                  static_cast<unsigned long long>(nanoseconds / 1'000),
                  static_cast<unsigned long long>(nanoseconds % 1'000));
    return text.data();
}

void print(std::string_view text, const can::Frame& frame,
           std::span<const std::uint32_t> bitrates) {
    const can::FrameBits bits = can::frame_bits(frame);
    std::printf("%.*s: %s %s frame, identifier %s, ", static_cast<int>(text.size()), text.data(),
                frame.extended ? "extended" : "standard", frame.remote ? "remote" : "data",
                hex(frame.id, frame.extended ? 8 : 3).c_str());
    if (frame.remote) {
        std::printf("DLC %d\n\n", frame.length);
    } else {
        std::printf("%s\n\n", counted(frame.length, "octet").c_str());
    }
    std::printf("  %-19s  %-7s  %s\n", "field", "value", "bits");
    for (const Row& row : rows_of(frame, bits)) {
        std::printf("  %-19s  %-7s  %s\n", row.field.c_str(), row.value.c_str(), row.bits.c_str());
    }
    std::printf(
        "\n"
        "0 is dominant, 1 recessive; (0) and (1) are stuff bits; the ACK slot is the receivers'.\n"
        "CRC %s, %s, %zu bits from SOF to the end of EOF, %zu with the intermission.\n"
        "\n",
        hex(bits.crc, 4).c_str(), counted(bits.stuff_bits, "stuff bit").c_str(), bits.size,
        bits.size_with_intermission());
    std::printf("  %-15s  %15s  %17s\n", "bit rate", "SOF to EOF", "with intermission");
    for (const std::uint32_t bitrate : bitrates) {
        std::printf("  %9u bit/s  %15s  %17s\n", bitrate, time_of(bits.size, bitrate).c_str(),
                    time_of(bits.size_with_intermission(), bitrate).c_str());
    }
}

int run(const std::vector<std::string>& texts, const std::string& bitrate_text) {
    std::vector<std::uint32_t> bitrates{usual_bitrates.begin(), usual_bitrates.end()};
    if (!bitrate_text.empty()) {
        const auto bitrate = can::parse_bitrate(bitrate_text);
        if (!bitrate) return fail("--bitrate: " + bitrate.error());
        bitrates = {*bitrate};
    }
    std::vector<can::Frame> frames;
    for (const std::string& text : texts) {
        const auto frame = parse_frame(text);
        if (!frame) return fail(frame.error());
        frames.push_back(*frame);
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (i > 0) std::putchar('\n');
        print(texts[i], frames[i], bitrates);
    }
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
        std::perror("canorb-bits: cannot write");
        return output_error;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::string> frames;
    std::string bitrate;
    CLI::App app{
        "Prints CAN frames bit by bit, as they are on the bus: fields, stuff bits, CRC, length and "
        "time.",
        "canorb-bits"};
    app.set_version_flag("--version", std::string{"canorb-bits "} + CANORB_VERSION);
    app.add_option("frame", frames,
                   "ID#DATA as candump -L prints it: 123#DEADBEEF; 12345678#DEADBEEF, an extended "
                   "frame; 123#R or 123#R4, remote frames")
        ->required();
    app.add_option("--bitrate", bitrate,
                   "bit/s for the time; without it 125000, 250000, 500000 and 1000000");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : usage_error;
    }
    return run(frames, bitrate);
}
