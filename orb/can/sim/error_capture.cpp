#include "orb/can/sim/error_capture.hpp"

namespace canorb::can::sim {
namespace {

std::uint8_t segment(FramePosition position) {
    switch (position.field) {
        case FrameField::start_of_frame:
            return 0b00011;
        case FrameField::identifier:  // ID.28 to ID.21, ID.20 to ID.18
            return position.index < 8 ? 0b00010 : 0b00110;
        case FrameField::remote_request:
            return 0b00100;
        case FrameField::identifier_extension:
            return 0b00101;
        case FrameField::extended_identifier:  // ID.17 to ID.13, ID.12 to ID.5, ID.4 to ID.0
            return position.index < 5 ? 0b00111 : position.index < 13 ? 0b01111 : 0b01110;
        case FrameField::extended_remote_request:
            return 0b01100;
        case FrameField::reserved_1:
            return 0b01101;
        case FrameField::reserved_0:
            return 0b01001;
        case FrameField::data_length_code:
            return 0b01011;
        case FrameField::data:
            return 0b01010;
        case FrameField::crc:
            return 0b01000;
        case FrameField::crc_delimiter:
            return 0b11000;
        case FrameField::ack_slot:
            return 0b11001;
        case FrameField::ack_delimiter:
            return 0b11011;
        case FrameField::end_of_frame:
            return 0b11010;
        case FrameField::active_error_flag:
            return 0b10001;
        case FrameField::passive_error_flag:
            return 0b10110;
        case FrameField::error_superposition:
            return 0b10011;
        case FrameField::error_delimiter:
        case FrameField::overload_delimiter:
            return 0b10111;
        case FrameField::overload_flag:
            return 0b11100;
        case FrameField::intermission:
        case FrameField::suspend_transmission:
        case FrameField::idle:
            break;
    }
    return 0b10010;
}

std::uint8_t code(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::bit:
            return 0b00;
        case ErrorKind::form:
            return 0b01;
        case ErrorKind::stuff:
            return 0b10;
        case ErrorKind::crc:
        case ErrorKind::acknowledgment:
            break;
    }
    return 0b11;
}

}  // namespace

std::string_view name(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::bit:
            return "bit error";
        case ErrorKind::stuff:
            return "stuff error";
        case ErrorKind::crc:
            return "CRC error";
        case ErrorKind::form:
            return "form error";
        case ErrorKind::acknowledgment:
            break;
    }
    return "ACK error";
}

std::uint8_t sja1000_error_code(const ErrorCapture& capture) {
    return static_cast<std::uint8_t>((code(capture.kind) << 6) |
                                     ((capture.transmitting ? 0 : 1) << 5) |
                                     segment(capture.position));
}

}  // namespace canorb::can::sim
