#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "orb/base/bytes.hpp"
#include "orb/can/controller.hpp"

/// What a client and the bus daemon say to each other: doc/wire/sim-bus.md. One value is one
/// packet on the socket. The same functions serve both ends.
namespace canorb::can::sim {

/// Grows with every change that an older peer would misunderstand.
inline constexpr std::uint8_t protocol_version = 1;

/// Octets in the longest packet.
inline constexpr std::size_t max_packet_size = 512;
inline constexpr std::size_t max_client_name = 32;
inline constexpr std::size_t max_refusal_reason = 400;
inline constexpr std::size_t max_packet_filters = 56;

/// A client's first packet. Of another version than ours nothing but `version` is known.
struct Hello {
    enum class Wish : std::uint8_t {
        controller,
        query,   ///< only asks whether it would be welcome; the daemon closes after the answer
        status,  ///< the same, and wants a BusStatus and each node's NodeStatus after the answer
    };
    std::uint8_t version = protocol_version;
    Wish wish = Wish::controller;
    std::string client_name{};  ///< printable ASCII, at most max_client_name
};

/// What a client asks for after its hello. `time` is when, on CLOCK_MONOTONIC: a bus that is paced
/// by that clock lets it happen then, in the order of all clients' times, however late the daemon
/// gets to it.
struct SendRequest {
    TimePoint time;
    TransmitHandle handle{};
    SendOptions options;
    Frame frame;
};

struct AbortRequest {
    TimePoint time;
    TransmitHandle handle{};
};

struct FilterRequest {
    TimePoint time;
    std::vector<Filter> filters;  ///< at most max_packet_filters
};

struct ListenOnlyRequest {
    TimePoint time;
    bool on = false;
};

struct RecoverRequest {
    TimePoint time;
};

using ClientPacket = std::variant<Hello, SendRequest, AbortRequest, FilterRequest,
                                  ListenOnlyRequest, RecoverRequest>;

/// The client has a controller now.
struct Welcome {
    bool paced = true;  ///< by the real clock; else bus time moves by frames only
    std::uint32_t bitrate = 0;
    std::uint16_t mailboxes = 0;
    std::uint16_t filter_list = 0;
};

/// The client has none; the daemon closes the connection.
struct Refusal {
    std::uint8_t version = protocol_version;  ///< the daemon's
    std::string reason;                       ///< a sentence, at most max_refusal_reason
};

/// How full a bus is. Busy is each bit from SOF to the end of the intermission.
struct BusStatus {
    TimePoint time{};               ///< on the bus's clock
    std::uint64_t bits = 0;         ///< since the bus began
    std::uint64_t busy_bits = 0;    ///< among them
    std::uint64_t recent_bits = 0;  ///< of the last second, less where the bus is younger
    std::uint64_t recent_busy_bits = 0;
    std::uint64_t frames = 0;        ///< sent and acknowledged
    std::uint64_t error_frames = 0;  ///< disturbances, however many nodes saw them
    std::uint16_t nodes = 0;         ///< so many NodeStatus follow
};

/// What a node is and has done since it was attached.
struct NodeStatus {
    ErrorStatus status{};
    std::uint64_t sent = 0;      ///< frames, acknowledged
    std::uint64_t received = 0;  ///< valid frames of others
    std::uint64_t lost_arbitrations = 0;
    std::uint64_t errors = 0;  ///< detected by it
    std::string name{};        ///< printable ASCII, at most max_client_name
};

using ServerPacket = std::variant<Welcome, Refusal, Received, TransmitResult, StateChanged,
                                  FramesLost, BusStatus, NodeStatus>;

/// A packet's octets.
class Packet {
  public:
    Bytes bytes() const { return Bytes{octets_.data(), size_}; }

    void put8(std::uint8_t value);
    void put16(std::uint16_t value);
    void put32(std::uint32_t value);
    void put64(std::uint64_t value);
    void put_text(std::string_view text);

  private:
    std::array<std::uint8_t, max_packet_size> octets_;
    std::size_t size_ = 0;
};

/// Too long names and reasons are cut; more filters than fit are a programming error.
Packet encode(const ClientPacket& packet);
Packet encode(const ServerPacket& packet);

/// Nothing when the octets are no such packet, whole and with nothing behind it.
std::optional<ClientPacket> parse_client_packet(Bytes octets);
std::optional<ServerPacket> parse_server_packet(Bytes octets);

}  // namespace canorb::can::sim
