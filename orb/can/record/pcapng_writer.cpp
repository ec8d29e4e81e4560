#include "orb/can/record/pcapng_writer.hpp"

#include <algorithm>
#include <utility>

#include "orb/base/counted.hpp"
#include "orb/can/sim/error_capture.hpp"

namespace canorb::can {
namespace {

// Block types and options of pcapng.
constexpr std::uint32_t section_header = 0x0A0D0D0A;
constexpr std::uint32_t interface_description = 1;
constexpr std::uint32_t enhanced_packet = 6;
constexpr std::uint32_t byte_order_magic = 0x1A2B3C4D;
constexpr std::uint64_t unknown_section_length = 0xFFFFFFFFFFFFFFFF;
constexpr std::uint16_t link_type_can_socketcan = 227;
constexpr std::uint16_t option_end = 0;
constexpr std::uint16_t option_comment = 1;
constexpr std::uint16_t option_section_application = 4;
constexpr std::uint16_t option_interface_name = 2;
constexpr std::uint16_t option_interface_speed = 8;
constexpr std::uint16_t option_interface_time_resolution = 9;

// linux/can.h and linux/can/error.h.
constexpr std::uint32_t extended_flag = 0x80000000;
constexpr std::uint32_t remote_flag = 0x40000000;
constexpr std::uint32_t error_flag = 0x20000000;
constexpr std::uint32_t error_controller = 0x04;
constexpr std::uint32_t error_protocol = 0x08;
constexpr std::uint32_t error_no_acknowledgment = 0x20;
constexpr std::uint32_t error_bus_off = 0x40;
constexpr std::uint32_t error_bus = 0x80;
constexpr std::uint32_t error_counters = 0x200;
constexpr std::uint8_t controller_receive_warning = 0x04;
constexpr std::uint8_t controller_transmit_warning = 0x08;
constexpr std::uint8_t controller_receive_passive = 0x10;
constexpr std::uint8_t controller_transmit_passive = 0x20;
constexpr std::uint8_t protocol_bit = 0x01;
constexpr std::uint8_t protocol_form = 0x02;
constexpr std::uint8_t protocol_stuff = 0x04;
constexpr std::uint8_t protocol_transmitting = 0x80;
constexpr std::uint16_t warning_limit = 96;
constexpr std::uint16_t passive_limit = 128;

/// Little endian, as everything in the file but the CAN identifier.
template <typename T>
void put(std::string& out, T value) {
    for (std::size_t i = 0; i < sizeof value; ++i) {
        out += static_cast<char>((value >> (8 * i)) & 0xFFU);
    }
}

void put_big_endian(std::string& out, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) {
        out += static_cast<char>((value >> shift) & 0xFFU);
    }
}

/// Every part of a block begins at a multiple of 4 octets.
void put_padded(std::string& out, std::string_view octets) {
    out += octets;
    out.append((4 - octets.size() % 4) % 4, '\0');
}

void put_option(std::string& out, std::uint16_t code, std::string_view value) {
    value = value.substr(0, 0xFFFF);
    put(out, code);
    put(out, static_cast<std::uint16_t>(value.size()));
    put_padded(out, value);
}

std::string block(std::uint32_t type, std::string_view body) {
    const auto length = static_cast<std::uint32_t>(body.size() + 12);
    std::string out;
    put(out, type);
    put(out, length);
    out += body;
    put(out, length);
    return out;
}

std::string section_header_block() {
    std::string body;
    put(body, byte_order_magic);
    put(body, std::uint16_t{1});  // version 1.0
    put(body, std::uint16_t{0});
    put(body, unknown_section_length);
    put_option(body, option_section_application, "canorb");
    put_option(body, option_end, {});
    return block(section_header, body);
}

std::string interface_block(const PcapngOptions& options) {
    std::string body;
    put(body, link_type_can_socketcan);
    put(body, std::uint16_t{0});
    put(body, std::uint32_t{0});  // packets of any length
    put_option(body, option_interface_name, options.interface);
    if (options.bitrate != 0) {
        std::string speed;
        put(speed, std::uint64_t{options.bitrate});
        put_option(body, option_interface_speed, speed);
    }
    put_option(body, option_interface_time_resolution, "\x09");  // 10 to the -9 s
    put_option(body, option_end, {});
    return block(interface_description, body);
}

std::string packet_block(TimePoint time, Duration unix_time_offset, std::string_view packet,
                         std::string_view comment) {
    const Duration unix_time = time.time_since_epoch() + unix_time_offset;
    const auto nanoseconds =
        static_cast<std::uint64_t>(std::max(unix_time, Duration::zero()).count());
    std::string body;
    put(body, std::uint32_t{0});  // the first interface
    put(body, static_cast<std::uint32_t>(nanoseconds >> 32));
    put(body, static_cast<std::uint32_t>(nanoseconds));
    put(body, static_cast<std::uint32_t>(packet.size()));  // captured
    put(body, static_cast<std::uint32_t>(packet.size()));  // on the bus
    put_padded(body, packet);
    put_option(body, option_comment, comment);
    put_option(body, option_end, {});
    return block(enhanced_packet, body);
}

/// As LINKTYPE_CAN_SOCKETCAN has it: struct can_frame with the identifier in network order.
std::string packet_of(std::uint32_t id_and_flags, std::uint8_t length, Bytes data) {
    std::string packet;
    put_big_endian(packet, id_and_flags);
    packet += static_cast<char>(length);
    packet.append(3, '\0');
    for (const std::uint8_t octet : data) packet += static_cast<char>(octet);
    return packet;
}

std::string name_or_number(std::string_view name, sim::NodeIndex node) {
    if (!name.empty()) return std::string{name};
    return "node " + std::to_string(static_cast<unsigned>(node));
}

std::string comment_of(const sim::CompletedFrame& completed, std::string_view sender) {
    std::string comment = name_or_number(sender, completed.sender) + ", " +
                          counted(completed.bits, "bit") + " on the wire, " +
                          counted(completed.stuff_bits, "stuff bit");
    if (completed.lost_arbitrations > 0) {
        comment += ", " + counted(completed.lost_arbitrations, "node") + " lost the arbitration";
    }
    return comment;
}

bool has_several_bits(FrameField field) {
    switch (field) {
        case FrameField::identifier:
        case FrameField::extended_identifier:
        case FrameField::data_length_code:
        case FrameField::data:
        case FrameField::crc:
        case FrameField::end_of_frame:
        case FrameField::intermission:
        case FrameField::suspend_transmission:
        case FrameField::active_error_flag:
        case FrameField::passive_error_flag:
        case FrameField::error_superposition:
        case FrameField::error_delimiter:
        case FrameField::overload_flag:
        case FrameField::overload_delimiter:
            return true;
        default:
            return false;
    }
}

std::string comment_of(const sim::NodeError& error, std::string_view node) {
    const sim::ErrorCapture& capture = error.capture;
    std::string comment = name_or_number(node, error.node);
    comment += capture.transmitting ? ", sending: " : ", receiving: ";
    comment += sim::name(capture.kind);
    comment += " at ";
    comment += name(capture.position.field);
    if (has_several_bits(capture.position.field)) {
        comment += " bit " + std::to_string(capture.position.index + 1);
    }
    if (capture.position.stuff) comment += ", the stuff bit after it";
    const bool silent = error.status.state == ControllerState::bus_off;  // from this error on
    comment += silent              ? "; no error flag; then "
               : error.active_flag ? "; active error flag; then "
                                   : "; passive error flag; then ";
    comment += name(error.status.state);
    comment += ", TEC " + std::to_string(error.status.tec);
    comment += ", REC " + std::to_string(error.status.rec);
    return comment;
}

std::uint8_t controller_octet(const ErrorStatus& status) {
    std::uint8_t octet = 0;
    if (status.state == ControllerState::bus_off) return octet;  // has a class of its own
    if (status.tec >= passive_limit) {
        octet |= controller_transmit_passive;
    } else if (status.tec >= warning_limit) {
        octet |= controller_transmit_warning;
    }
    if (status.rec >= passive_limit) {
        octet |= controller_receive_passive;
    } else if (status.rec >= warning_limit) {
        octet |= controller_receive_warning;
    }
    return octet;
}

std::uint8_t protocol_octet(const sim::ErrorCapture& capture) {
    const std::uint8_t direction = capture.transmitting ? protocol_transmitting : 0;
    switch (capture.kind) {
        case sim::ErrorKind::bit:
            return direction | protocol_bit;
        case sim::ErrorKind::form:
            return direction | protocol_form;
        case sim::ErrorKind::stuff:
            return direction | protocol_stuff;
        case sim::ErrorKind::crc:
        case sim::ErrorKind::acknowledgment:
            break;  // told by the place alone
    }
    return direction;
}

std::string packet_of(const sim::NodeError& error) {
    const ErrorStatus& status = error.status;
    std::uint32_t classes = error_protocol | error_bus | error_counters;
    if (error.capture.kind == sim::ErrorKind::acknowledgment) classes |= error_no_acknowledgment;
    if (status.state == ControllerState::bus_off) classes |= error_bus_off;
    const std::uint8_t controller = controller_octet(status);
    if (controller != 0) classes |= error_controller;
    const auto limited = [](std::uint16_t counter) {
        return static_cast<std::uint8_t>(std::min<std::uint16_t>(counter, 255));
    };
    // CAN_ERR_PROT_LOC_* are the segments of an SJA1000.
    const auto place = static_cast<std::uint8_t>(sja1000_error_code(error.capture) & 0x1FU);
    const std::uint8_t data[] = {0, controller, protocol_octet(error.capture), place,
                                 0, 0,          limited(status.tec),           limited(status.rec)};
    return packet_of(error_flag | classes, sizeof data, data);
}

}  // namespace

Result<std::unique_ptr<PcapngWriter>, std::string> PcapngWriter::create(
    const std::string& path, const PcapngOptions& options) {
    auto file = RecordFile::create(path);
    if (!file) return Failure{file.error()};
    std::unique_ptr<PcapngWriter> writer{new PcapngWriter{std::move(*file), options}};
    if (!writer->error().empty()) return Failure{writer->error()};
    return writer;
}

PcapngWriter::PcapngWriter(RecordFile file, const PcapngOptions& options)
    : file_(std::move(file)), unix_time_offset_(options.unix_time_offset) {
    file_.append(section_header_block());
    file_.append(interface_block(options));
    file_.flush();
}

void PcapngWriter::frame(const sim::CompletedFrame& completed, std::string_view sender) {
    const Frame& frame = completed.frame;
    std::uint32_t id = frame.id;
    if (frame.extended) id |= extended_flag;
    if (frame.remote) id |= remote_flag;
    file_.append(packet_block(completed.time, unix_time_offset_,
                              packet_of(id, frame.length, frame.payload()),
                              comment_of(completed, sender)));
}

void PcapngWriter::error(const sim::NodeError& error, std::string_view node) {
    if (!error.primary) return;
    file_.append(
        packet_block(error.time, unix_time_offset_, packet_of(error), comment_of(error, node)));
}

}  // namespace canorb::can
