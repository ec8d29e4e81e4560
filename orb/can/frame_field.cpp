#include "orb/can/frame_field.hpp"

namespace canorb::can {

std::string_view name(FrameField field) {
    switch (field) {
        case FrameField::start_of_frame:
            return "start of frame";
        case FrameField::identifier:
            return "identifier";
        case FrameField::remote_request:
            return "RTR";
        case FrameField::identifier_extension:
            return "IDE";
        case FrameField::extended_identifier:
            return "extended identifier";
        case FrameField::extended_remote_request:
            return "extended RTR";
        case FrameField::reserved_1:
            return "r1";
        case FrameField::reserved_0:
            return "r0";
        case FrameField::data_length_code:
            return "DLC";
        case FrameField::data:
            return "data";
        case FrameField::crc:
            return "CRC";
        case FrameField::crc_delimiter:
            return "CRC delimiter";
        case FrameField::ack_slot:
            return "ACK slot";
        case FrameField::ack_delimiter:
            return "ACK delimiter";
        case FrameField::end_of_frame:
            return "end of frame";
        case FrameField::intermission:
            return "intermission";
        case FrameField::suspend_transmission:
            return "suspend transmission";
        case FrameField::active_error_flag:
            return "active error flag";
        case FrameField::passive_error_flag:
            return "passive error flag";
        case FrameField::error_superposition:
            return "error superposition";
        case FrameField::error_delimiter:
            return "error delimiter";
        case FrameField::overload_flag:
            return "overload flag";
        case FrameField::overload_delimiter:
            return "overload delimiter";
        case FrameField::idle:
            return "idle";
    }
    return "?";
}

}  // namespace canorb::can
