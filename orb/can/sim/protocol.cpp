#include "orb/can/sim/protocol.hpp"

#include <algorithm>
#include <cassert>

namespace canorb::can::sim {
namespace {

constexpr std::string_view magic = "canorb-bus";

enum class PacketType : std::uint8_t {
    hello = 0x01,
    send = 0x02,
    abort = 0x03,
    filters = 0x04,
    listen_only = 0x05,
    recover = 0x06,
    welcome = 0x81,
    refusal = 0x82,
    received = 0x83,
    transmit_result = 0x84,
    state_changed = 0x85,
    frames_lost = 0x86,
    bus_status = 0x87,
    node_status = 0x88,
};

constexpr std::uint8_t paced_flag = 0x01;
constexpr std::uint8_t one_shot_flag = 0x01;
constexpr std::uint32_t extended_flag = 0x80000000;
constexpr std::uint32_t data_only_flag = 0x40000000;
constexpr std::uint32_t remote_flag = 0x40000000;

/// Takes fields off the front of a packet. Once one is missing all that follow read as 0 and
/// finished() is false.
class Reader {
  public:
    explicit Reader(Bytes octets) : rest_(octets) {}

    std::uint8_t get8() { return static_cast<std::uint8_t>(get(1)); }
    std::uint16_t get16() { return static_cast<std::uint16_t>(get(2)); }
    std::uint32_t get32() { return static_cast<std::uint32_t>(get(4)); }
    std::uint64_t get64() { return get(8); }

    Bytes get_bytes(std::size_t count) {
        if (count > rest_.size()) {
            fail();
            return {};
        }
        const Bytes taken = rest_.first(count);
        rest_ = rest_.subspan(count);
        return taken;
    }

    Bytes get_rest() { return get_bytes(rest_.size()); }

    void fail() {
        ok_ = false;
        rest_ = {};
    }

    bool finished() const { return ok_ && rest_.empty(); }

  private:
    std::uint64_t get(std::size_t width) {
        std::uint64_t value = 0;
        for (const std::uint8_t octet : get_bytes(width)) value = (value << 8) | octet;
        return value;
    }

    Bytes rest_;
    bool ok_ = true;
};

bool is_printable(std::uint8_t octet) {
    return octet >= 0x20 && octet < 0x7F;
}

/// The rest of a packet.
std::string get_text(Reader& reader, std::size_t longest) {
    const Bytes octets = reader.get_rest();
    if (octets.size() > longest || !std::all_of(octets.begin(), octets.end(), is_printable)) {
        reader.fail();
    }
    return std::string{octets.begin(), octets.end()};
}

void put(Packet& packet, PacketType type) {
    packet.put8(static_cast<std::uint8_t>(type));
}

void put(Packet& packet, const Frame& frame) {
    assert(is_classic(frame));
    packet.put32(frame.id | (frame.extended ? extended_flag : 0) |
                 (frame.remote ? remote_flag : 0));
    packet.put8(frame.length);
    for (const std::uint8_t octet : frame.payload()) packet.put8(octet);
}

Frame get_frame(Reader& reader) {
    Frame frame;
    const std::uint32_t id = reader.get32();
    frame.extended = (id & extended_flag) != 0;
    frame.remote = (id & remote_flag) != 0;
    frame.id = id & ~(extended_flag | remote_flag);
    frame.length = reader.get8();
    if (!is_classic(frame)) {
        reader.fail();
        return Frame{};
    }
    if (!frame.remote) {
        const Bytes data = reader.get_bytes(frame.length);
        std::copy(data.begin(), data.end(), frame.data.begin());
    }
    return frame;
}

void put(Packet& packet, TimePoint time) {
    packet.put64(static_cast<std::uint64_t>(time.time_since_epoch().count()));
}

TimePoint get_time(Reader& reader) {
    return TimePoint{Duration{static_cast<Duration::rep>(reader.get64())}};
}

TransmitHandle get_handle(Reader& reader) {
    return TransmitHandle{reader.get64()};
}

/// An octet of flags with none but `known` set.
std::uint8_t get_flags(Reader& reader, std::uint8_t known) {
    const std::uint8_t flags = reader.get8();
    if ((flags & ~known) != 0) reader.fail();
    return flags;
}

/// An octet that names one of the enumerators up to `last`.
template <typename Enum>
Enum get_enum(Reader& reader, Enum last) {
    const std::uint8_t value = reader.get8();
    if (value > static_cast<std::uint8_t>(last)) reader.fail();
    return static_cast<Enum>(value);
}

void put(Packet& packet, const ErrorStatus& status) {
    packet.put8(static_cast<std::uint8_t>(status.state));
    packet.put16(status.tec);
    packet.put16(status.rec);
}

ErrorStatus get_error_status(Reader& reader) {
    ErrorStatus status;
    status.state = get_enum(reader, ControllerState::stopped);
    status.tec = reader.get16();
    status.rec = reader.get16();
    return status;
}

void put(Packet& packet, const Hello& hello) {
    put(packet, PacketType::hello);
    packet.put_text(magic);
    packet.put8(hello.version);
    packet.put8(static_cast<std::uint8_t>(hello.wish));
    packet.put_text(hello.client_name.substr(0, max_client_name));
}

void put(Packet& packet, const SendRequest& request) {
    put(packet, PacketType::send);
    put(packet, request.time);
    packet.put64(static_cast<std::uint64_t>(request.handle));
    packet.put8(request.options.one_shot ? one_shot_flag : std::uint8_t{0});
    put(packet, request.frame);
}

void put(Packet& packet, const AbortRequest& request) {
    put(packet, PacketType::abort);
    put(packet, request.time);
    packet.put64(static_cast<std::uint64_t>(request.handle));
}

void put(Packet& packet, const FilterRequest& request) {
    assert(request.filters.size() <= max_packet_filters);
    put(packet, PacketType::filters);
    put(packet, request.time);
    packet.put8(static_cast<std::uint8_t>(request.filters.size()));
    for (const Filter& filter : request.filters) {
        packet.put32(filter.mask);
        packet.put32((filter.value & ~(extended_flag | data_only_flag)) |
                     (filter.extended ? extended_flag : 0) |
                     (filter.data_only ? data_only_flag : 0));
    }
}

void put(Packet& packet, const ListenOnlyRequest& request) {
    put(packet, PacketType::listen_only);
    put(packet, request.time);
    packet.put8(request.on ? 1 : 0);
}

void put(Packet& packet, const RecoverRequest& request) {
    put(packet, PacketType::recover);
    put(packet, request.time);
}

void put(Packet& packet, const Welcome& welcome) {
    put(packet, PacketType::welcome);
    packet.put8(protocol_version);
    packet.put8(welcome.paced ? paced_flag : std::uint8_t{0});
    packet.put32(welcome.bitrate);
    packet.put16(welcome.mailboxes);
    packet.put16(welcome.filter_list);
}

void put(Packet& packet, const Refusal& refusal) {
    put(packet, PacketType::refusal);
    packet.put8(refusal.version);
    packet.put_text(refusal.reason.substr(0, max_refusal_reason));
}

void put(Packet& packet, const Received& received) {
    put(packet, PacketType::received);
    put(packet, received.time);
    put(packet, received.frame);
}

void put(Packet& packet, const TransmitResult& result) {
    put(packet, PacketType::transmit_result);
    packet.put64(static_cast<std::uint64_t>(result.handle));
    packet.put8(static_cast<std::uint8_t>(result.outcome));
    put(packet, result.time);
}

void put(Packet& packet, const StateChanged& change) {
    put(packet, PacketType::state_changed);
    put(packet, change.status);
    put(packet, change.time);
}

void put(Packet& packet, const FramesLost& lost) {
    put(packet, PacketType::frames_lost);
    packet.put64(lost.count);
    put(packet, lost.time);
}

void put(Packet& packet, const BusStatus& status) {
    put(packet, PacketType::bus_status);
    put(packet, status.time);
    packet.put64(status.bits);
    packet.put64(status.busy_bits);
    packet.put64(status.recent_bits);
    packet.put64(status.recent_busy_bits);
    packet.put64(status.frames);
    packet.put64(status.error_frames);
    packet.put16(status.nodes);
}

void put(Packet& packet, const NodeStatus& node) {
    put(packet, PacketType::node_status);
    put(packet, node.status);
    packet.put64(node.sent);
    packet.put64(node.received);
    packet.put64(node.lost_arbitrations);
    packet.put64(node.errors);
    packet.put_text(node.name.substr(0, max_client_name));
}

Hello get_hello(Reader& reader) {
    Hello hello;
    const Bytes found = reader.get_bytes(magic.size());
    if (!std::equal(
            found.begin(), found.end(), magic.begin(), magic.end(),
            [](std::uint8_t octet, char c) { return octet == static_cast<std::uint8_t>(c); })) {
        reader.fail();
    }
    hello.version = reader.get8();
    if (hello.version != protocol_version) {
        reader.get_rest();
        return hello;
    }
    hello.wish = get_enum(reader, Hello::Wish::status);
    hello.client_name = get_text(reader, max_client_name);
    return hello;
}

SendRequest get_send(Reader& reader) {
    SendRequest request;
    request.time = get_time(reader);
    request.handle = get_handle(reader);
    request.options.one_shot = get_flags(reader, one_shot_flag) != 0;
    request.frame = get_frame(reader);
    return request;
}

FilterRequest get_filters(Reader& reader) {
    FilterRequest request;
    request.time = get_time(reader);
    const std::size_t count = reader.get8();
    if (count > max_packet_filters) reader.fail();
    for (std::size_t i = 0; i < std::min(count, max_packet_filters); ++i) {
        Filter filter;
        filter.mask = reader.get32();
        const std::uint32_t value = reader.get32();
        filter.value = value & ~(extended_flag | data_only_flag);
        filter.extended = (value & extended_flag) != 0;
        filter.data_only = (value & data_only_flag) != 0;
        request.filters.push_back(filter);
    }
    return request;
}

AbortRequest get_abort(Reader& reader) {
    const TimePoint time = get_time(reader);
    return AbortRequest{time, get_handle(reader)};
}

ListenOnlyRequest get_listen_only(Reader& reader) {
    const TimePoint time = get_time(reader);
    return ListenOnlyRequest{time, get_flags(reader, 1) != 0};
}

Welcome get_welcome(Reader& reader) {
    Welcome welcome;
    if (reader.get8() != protocol_version) reader.fail();
    welcome.paced = get_flags(reader, paced_flag) != 0;
    welcome.bitrate = reader.get32();
    welcome.mailboxes = reader.get16();
    welcome.filter_list = reader.get16();
    return welcome;
}

Refusal get_refusal(Reader& reader) {
    Refusal refusal;
    refusal.version = reader.get8();
    refusal.reason = get_text(reader, max_refusal_reason);
    return refusal;
}

Received get_received(Reader& reader) {
    const TimePoint time = get_time(reader);
    return Received{get_frame(reader), time};
}

TransmitResult get_transmit_result(Reader& reader) {
    const TransmitHandle handle = get_handle(reader);
    const auto outcome = get_enum(reader, TransmitOutcome::failed);
    return TransmitResult{handle, outcome, get_time(reader)};
}

StateChanged get_state_changed(Reader& reader) {
    StateChanged change;
    change.status = get_error_status(reader);
    change.time = get_time(reader);
    return change;
}

FramesLost get_frames_lost(Reader& reader) {
    const std::uint64_t count = reader.get64();
    return FramesLost{count, get_time(reader)};
}

BusStatus get_bus_status(Reader& reader) {
    BusStatus status;
    status.time = get_time(reader);
    status.bits = reader.get64();
    status.busy_bits = reader.get64();
    status.recent_bits = reader.get64();
    status.recent_busy_bits = reader.get64();
    status.frames = reader.get64();
    status.error_frames = reader.get64();
    status.nodes = reader.get16();
    return status;
}

NodeStatus get_node_status(Reader& reader) {
    NodeStatus node;
    node.status = get_error_status(reader);
    node.sent = reader.get64();
    node.received = reader.get64();
    node.lost_arbitrations = reader.get64();
    node.errors = reader.get64();
    node.name = get_text(reader, max_client_name);
    return node;
}

}  // namespace

void Packet::put8(std::uint8_t value) {
    assert(size_ < octets_.size());
    octets_[size_++] = value;
}

void Packet::put16(std::uint16_t value) {
    put8(static_cast<std::uint8_t>(value >> 8));
    put8(static_cast<std::uint8_t>(value));
}

void Packet::put32(std::uint32_t value) {
    put16(static_cast<std::uint16_t>(value >> 16));
    put16(static_cast<std::uint16_t>(value));
}

void Packet::put64(std::uint64_t value) {
    put32(static_cast<std::uint32_t>(value >> 32));
    put32(static_cast<std::uint32_t>(value));
}

void Packet::put_text(std::string_view text) {
    for (const char c : text) {
        const auto octet = static_cast<std::uint8_t>(c);
        put8(is_printable(octet) ? octet : std::uint8_t{'?'});
    }
}

Packet encode(const ClientPacket& value) {
    Packet packet;
    std::visit([&](const auto& form) { put(packet, form); }, value);
    return packet;
}

Packet encode(const ServerPacket& value) {
    Packet packet;
    std::visit([&](const auto& form) { put(packet, form); }, value);
    return packet;
}

std::optional<ClientPacket> parse_client_packet(Bytes octets) {
    Reader reader{octets};
    std::optional<ClientPacket> packet;
    switch (PacketType{reader.get8()}) {
        case PacketType::hello:
            packet = get_hello(reader);
            break;
        case PacketType::send:
            packet = get_send(reader);
            break;
        case PacketType::abort:
            packet = get_abort(reader);
            break;
        case PacketType::filters:
            packet = get_filters(reader);
            break;
        case PacketType::listen_only:
            packet = get_listen_only(reader);
            break;
        case PacketType::recover:
            packet = RecoverRequest{get_time(reader)};
            break;
        default:
            return std::nullopt;
    }
    if (!reader.finished()) return std::nullopt;
    return packet;
}

std::optional<ServerPacket> parse_server_packet(Bytes octets) {
    Reader reader{octets};
    std::optional<ServerPacket> packet;
    switch (PacketType{reader.get8()}) {
        case PacketType::welcome:
            packet = get_welcome(reader);
            break;
        case PacketType::refusal:
            packet = get_refusal(reader);
            break;
        case PacketType::received:
            packet = get_received(reader);
            break;
        case PacketType::transmit_result:
            packet = get_transmit_result(reader);
            break;
        case PacketType::state_changed:
            packet = get_state_changed(reader);
            break;
        case PacketType::frames_lost:
            packet = get_frames_lost(reader);
            break;
        case PacketType::bus_status:
            packet = get_bus_status(reader);
            break;
        case PacketType::node_status:
            packet = get_node_status(reader);
            break;
        default:
            return std::nullopt;
    }
    if (!reader.finished()) return std::nullopt;
    return packet;
}

}  // namespace canorb::can::sim
